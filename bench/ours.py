"""Measure nvcore on one set: `analyse` for two systems, and each change of a parameter.

    python -m bench.ours SET.npz [--repeat 5]

The time is that from the dataset in memory to the result. A run on a small set first loads the
compiled functions.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from bench.measure import TO_VERDICT, measure, repeat, report, versions
from bench.sets import COLUMNS, FPS, HEIGHT, WIDTH, BoxSet, load_set, make_set
from nvcore.auditing import audit
from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence import bootstrap
from nvcore.evidence.table import judge_both
from nvcore.report.verdict import Verdict, verdict
from nvcore.settings.params import Params

CHANGES = {
    "alpha": lambda i: Params(alpha=0.5 + 0.05 * i),
    "sigmoid midpoint": lambda i: Params(midpoint=40.0 + i),
    "edge weight": lambda i: Params(edge_weight=0.1 + 0.1 * i),
    "threshold": lambda i: Params(threshold_x=0.3 + 0.02 * i, threshold_y=0.35 + 0.02 * i),
    "IoU": lambda i: Params(iou=0.3 + 0.03 * i),
}
"""New parameters of the i-th repetition. Each starts from the result with the defaults."""


def to_dataset(boxes: BoxSet) -> Dataset:
    lengths = boxes.lengths
    recordings = pd.DataFrame(
        {
            "name": [f"r{i:04d}" for i in range(len(lengths))],
            "width": WIDTH,
            "height": HEIGHT,
            "fps": FPS,
        }
    )
    sources = (boxes.truth, *boxes.systems)
    table = pd.DataFrame(
        {name: np.concatenate([getattr(s, name) for s in sources]) for name in COLUMNS}
    )
    table["source"] = np.repeat([0, 1, 2], [len(s) for s in sources])
    frames = [np.arange(n) for n in lengths]
    return dataset_from_tables(recordings, frames, table, ["x", "y"], fingerprint="synthetic")


def _checks(result: Result) -> dict[str, list[float]]:
    """Return values that other tools compute as well."""
    systems = (result.x, result.y)
    return {
        "matched": [int(s.matched.sum()) for s in systems],
        "recall": [float(s.matched.sum() / result.n_truth.sum()) for s in systems],
        "n_truth": [int(result.n_truth.sum()) for _ in systems],
        "n_det": [int(s.n_det.sum()) for s in systems],
        "mean_similarity": [s.summary.mean for s in systems],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("set", type=Path)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--only-analyse", action="store_true", help="no changes of parameters")
    options = parser.parse_args()
    warm = to_dataset(make_set(1_000))
    compare(warm, previous=compare(warm))
    dataset = to_dataset(load_set(options.set))
    dataset.frame_columns, dataset.truth  # noqa: B018  columns of the input, made once

    def analyse() -> Result:
        dataset.derived.clear()  # discard the results of the previous run
        return compare(dataset)

    def judge(_: int) -> Verdict:
        """Run everything from the dataset to the verdict."""
        result = analyse()
        dataset.__dict__.pop("copies", None)  # also recomputed
        bootstrap._remembered.cache_clear()
        bootstrap._kept_counts.cache_clear()
        evidence, companions = judge_both(result)
        return verdict(result, audit(dataset), evidence=evidence, companions=companions)

    base, analyse_s, peak_mb = measure(analyse, options.repeat)
    seconds = {"analyse": analyse_s}
    if not options.only_analyse:
        seconds[TO_VERDICT] = repeat(judge, options.repeat)
    changes = {} if options.only_analyse else CHANGES
    for name, params in changes.items():
        seconds[f"change of {name}"] = repeat(
            lambda i, params=params: compare(dataset, params(i), previous=base), options.repeat
        )
    report(
        seconds=seconds,
        peak_mb=peak_mb,
        input_mb=float(dataset.boxes.memory_usage().sum() / 1024**2),
        check=_checks(base),
        versions=versions("numpy", "numba", "pandas", "pyarrow", "scipy"),
    )


if __name__ == "__main__":
    main()
