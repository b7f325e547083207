"""Train the estimator of the sample's simulated observer, which the page Driver offers.

python -m scripts.train_sample_driver  # writes estimators/models/sample.npz
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import nvcore as nv
from nvcore.subjects.driver.calls.python import image_features
from nvcore.subjects.driver.estimators.model_file import SAMPLE_ESTIMATOR
from nvcore.subjects.driver.evaluation.estimator_report import render_training

SAMPLE: Final = Path(__file__).resolve().parents[1] / "sample_data"
NAME: Final = "sample"


def main() -> None:
    """Train on the sample's simulated trials, and print the errors."""
    with TemporaryDirectory() as folder:
        features = Path(folder) / "features.csv"
        image_features(SAMPLE / "study", SAMPLE / "study" / "boxes.csv", features)
        training = nv.train_driver(
            SAMPLE / "trials_simulated.csv",
            features=features,
            out=SAMPLE_ESTIMATOR,
            name=NAME,
            progress=_say,
        )
    print(render_training(training))


def _say(share: float, words: str) -> None:
    if sys.stderr.isatty():
        print(f"\r{share:4.0%} {words:60s}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
