"""Measure the time from MOTChallenge files to results for two systems, as users experience it.

    python -m bench.from_files TOOL FOLDER [--repeat 3]

FOLDER is an output of `bench.mot_files`. Timed after the imports and a run on a small set:

- ``nvcore, from files``: `load` (reading, hashing the files, placing the boxes) and `analyse`,
  with the default two threads.
- ``TrackEval Evaluator, from files``: its `Evaluator` on `MotChallenge2DBox` with CLEAR (and Count,
  which it always adds): reading, IoU, preprocessing, CLEAR. One process; no printing, no output.
- ``TrackEval preprocessing + CLEAR``: the same without reading and IoU, which TrackEval does in
  one step; that step is `prepare_s`.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

from bench.measure import measure, report, versions
from bench.mot_files import SYSTEMS, write_mot
from bench.sets import make_set

WARM_FRAMES = 100
Figures = list[dict[str, float]]
Work = Callable[[], Figures]


def _nvcore(folder: Path) -> Work:
    from nvcore.comparison.compare import compare
    from nvcore.inputs.load import load
    from nvcore.inputs.session import Session, Source, SystemSource

    session = Session(
        folder,
        Source(("gt",)),
        tuple(SystemSource((f"trackers/{name}/data",), name=name) for name in SYSTEMS),
    )

    def work() -> Figures:
        result = compare(load(session))
        return [
            {
                "matched": int(system.matched.sum()),
                "n_truth": int(result.n_truth.sum()),
                "n_det": int(system.n_det.sum()),
            }
            for system in (result.x, result.y)
        ]

    return work


def _trackeval(folder: Path) -> tuple[Any, Any]:
    """Return TrackEval's dataset and metric."""
    from trackeval.datasets import MotChallenge2DBox
    from trackeval.metrics import CLEAR

    dataset = MotChallenge2DBox(
        {
            "GT_FOLDER": str(folder / "gt"),
            "TRACKERS_FOLDER": str(folder / "trackers"),
            "TRACKERS_TO_EVAL": list(SYSTEMS),
            "SEQMAP_FILE": str(folder / "seqmap.txt"),
            "SKIP_SPLIT_FOL": True,
            "PRINT_CONFIG": False,
        }
    )
    return dataset, CLEAR({"THRESHOLD": 0.5, "PRINT_CONFIG": False})


def _figures(clear: dict[str, float]) -> dict[str, float]:
    matched = int(clear["CLR_TP"])
    return {
        "matched": matched,
        "n_truth": matched + int(clear["CLR_FN"]),
        "n_det": matched + int(clear["CLR_FP"]),
    }


def _evaluator(folder: Path) -> Work:
    from trackeval import Evaluator

    silent = dict.fromkeys(
        ("PRINT_RESULTS", "PRINT_CONFIG", "TIME_PROGRESS", "OUTPUT_SUMMARY", "OUTPUT_DETAILED",
         "PLOT_CURVES", "USE_PARALLEL"),
        False,
    )  # fmt: skip

    def work() -> Figures:
        dataset, metric = _trackeval(folder)
        evaluator = Evaluator({**silent, "LOG_ON_ERROR": None})
        trackers = evaluator.evaluate([dataset], [metric])[0]["MotChallenge2DBox"]
        return [_figures(trackers[x]["COMBINED_SEQ"]["pedestrian"]["CLEAR"]) for x in SYSTEMS]

    return work


def _preprocessing_and_clear(folder: Path) -> Work:
    dataset, metric = _trackeval(folder)
    read = {
        tracker: {name: dataset.get_raw_seq_data(tracker, name) for name in dataset.seq_list}
        for tracker in SYSTEMS
    }

    def work() -> Figures:
        figures = []
        for recordings in read.values():
            scores = {
                name: metric.eval_sequence(dataset.get_preprocessed_seq_data(raw, "pedestrian"))
                for name, raw in recordings.items()
            }
            figures.append(_figures(metric.combine_sequences(scores)))
        return figures

    return work


TOOLS: dict[str, tuple[Callable[[Path], Work], tuple[str, ...]]] = {
    "nvcore, from files": (_nvcore, ("numpy", "numba", "pandas", "pyarrow")),
    "TrackEval Evaluator, from files": (_evaluator, ("trackeval", "numpy", "scipy")),
    "TrackEval preprocessing + CLEAR": (_preprocessing_and_clear, ("trackeval", "numpy", "scipy")),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tool", choices=sorted(TOOLS))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    prepare, packages = TOOLS[options.tool]
    with contextlib.redirect_stdout(io.StringIO()):  # TrackEval prints each tracker's name
        with tempfile.TemporaryDirectory() as small:
            write_mot(make_set(WARM_FRAMES), Path(small))
            prepare(Path(small))()
        start = perf_counter()
        work = prepare(options.folder)
        prepare_s = perf_counter() - start
        figures, seconds, peak_mb = measure(work, options.repeat)
    has_objects = options.tool == "TrackEval preprocessing + CLEAR"  # the others start from files
    report(
        seconds=seconds,
        peak_mb=peak_mb,
        check=figures,
        versions=versions(*packages),
        **({"prepare_s": prepare_s} if has_objects else {}),
    )


if __name__ == "__main__":
    main()
