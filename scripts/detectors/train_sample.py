"""Train or evaluate the pedestrian model of the sample recordings, which ships as `icf:sample`.

    python -m scripts.detectors.train_sample             # writes
    nvcore/subjects/detectors/models/sample.npz python -m scripts.detectors.train_sample --evaluate
    # on recordings that it was not trained on

The settings were chosen on `oncoming_glare` and `rural_child`, with a model of four others of
`TRAINED`. The same versions of OpenCV and of the video library give the same bytes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import nvcore as nv
from nvcore.metrics.detection import DetectionCurve, detection_curve
from nvcore.metrics.detection.miss_rate import log_average_miss_rate
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS
from nvcore.subjects.detectors.registry import SAMPLE_MODEL
from tools.sample.camera import N_FRAMES

SESSION: Final = Path(__file__).resolve().parents[2] / "sample_data" / "session.toml"
TRAINED: Final = (
    *("urban_crossing", "urban_groups", "rural_road", "rural_child"),
    *("summer_night", "oncoming_glare", "winter_frost"),
)
TESTED: Final = ("urban_sidewalk", "rural_cyclist", "odd_pose")
SETTINGS: Final = {
    "window_width": 20,
    "window_height": 40,
    "object_width": 12.0,
    "object_height": 32.0,
    "least_area": 16,
    "features": 2000,
    "trees_per_round": (32, 128, 256),
    "negatives": 6000,
    "negatives_per_round": 4000,
    "scales": tuple(round(0.35 * 2 ** (i / 4), 4) for i in range(19)),
}
"""Changes of the pedestrian preset, as pedestrians of the sample are mostly below 50 px."""
NAME: Final = "ICF sample"
EVERY: Final = 4
"""One in this many frames is trained on or measured."""
SEED: Final = 1
FPPI: Final = 0.3
"""False positives per picture at which similarities are compared."""
COMPARED: Final[tuple[tuple[str, Mapping[str, float]], ...]] = (
    ("icf:sample", {}),
    ("hog", {"upscale": 2}),
)


def train_sample(out: Path) -> None:
    """Train on `TRAINED` and write the model."""

    def progress(share: float, words: str) -> None:
        if sys.stderr.isatty():
            print(f"\r{share:4.0%} {words:60s}", end="", file=sys.stderr, flush=True)

    training = nv.train(
        SESSION,
        out,
        settings=SETTINGS,
        name=NAME,
        only=TRAINED,
        every=EVERY,
        seed=SEED,
        progress=progress,
    )
    print(training)
    print(f"{out.name}: {out.stat().st_size / 1000:.0f} kB")


def evaluate() -> None:
    """Print miss rates and mean similarity of each detector on `TESTED` as table rows."""
    part = nv.load(SESSION, frames=range(0, N_FRAMES, EVERY))
    print("| | miss rate, all | miss rate, reasonable | mean similarity |")
    print("|---|---|---|---|")
    for detector, settings in COMPARED:
        with TemporaryDirectory() as folder:
            written = nv.detect(part, detector, folder, settings=settings, only=TESTED)
            dataset = nv.load(written.session)
            curves = [
                detection_curve(dataset, written.name, Params(), PROTOCOLS[protocol])
                for protocol in ("all", "reasonable")
            ]
            result = nv.compare(written.session, threshold_y=threshold_at(curves[0]))
        rates = " | ".join(f"{log_average_miss_rate(curve):.3f}" for curve in curves)
        changes = "".join(f", {name}={value:g}" for name, value in settings.items())
        similarity = result.y.summary.mean
        print(f"| `{detector}`{changes} | {rates} | {similarity:.3f} |", flush=True)


def threshold_at(curve: DetectionCurve) -> float:
    """Return the lowest threshold with at most `FPPI` false positives per picture."""
    return float(curve.threshold[curve.fppi <= FPPI].min(initial=curve.threshold.max()))


def main() -> None:
    """Train or evaluate."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=SAMPLE_MODEL, help="default: in the package")
    parser.add_argument("--evaluate", action="store_true")
    options = parser.parse_args()
    if options.evaluate:
        evaluate()
    else:
        train_sample(options.out)


if __name__ == "__main__":
    main()
