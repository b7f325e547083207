"""Measure ratios valid on a busy machine: opening to reading, nvcore to COCO evaluators.

    python -m bench.paired [--quick] [--only SECTION] [--rounds N] [--out FILE]

Compared programs run one right after the other, round after round. Each ratio is taken within a
round, and the table has the median of the rounds. With ``--out`` the sections of that page are
written.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from bench.tables import seconds_text, table
from bench.web.tables import put_section
from bench.workers import ROOT, TOOLS_PYTHON, run_worker

EVALUATORS = ("hotcoco", "ultrafast-pycocotools", "vernier", "faster-coco-eval")
OURS = "nvcore analyse"
SHAPES = {"our frames": (100_000, ()), "pictures as COCO's": (5_000, ("--coco",))}
"""Number of frames and flags of `bench.sets` for each set on which the evaluators run."""
MOST_CSV, MOST_PARQUET = 5, 1.7
"""Targets for a million frames: opening CSV, and loading Parquet, relative to reading alone."""
OPENING = """\
## Opening files

`load` (reading, hashing, placing the boxes), `audit` and `analyse` from the session file, beside
pyarrow reading the same three files (truth, X, Y) with its defaults, just before in the same
process, after a run on a small set. *Ratio* is all three steps over pyarrow, *of load* the first
step: the median of {rounds} rounds (lowest to highest). *Peak* is the memory that loading takes.
Targets: a ratio of {csv} for CSV, of {parquet} for loading Parquet.
Load of the machine when it began: {load:.1f}.
"""
BESIDE = """\
## Beside COCO's evaluators

Both systems against the truth at an IoU of 0.5, from boxes in memory in each tool's own form. The
evaluators give average precision and recall, nvcore a whole comparison. Each round runs all of them
one after the other, each in a fresh process (median of {repeat} runs).
*Ratio* is the time over that of `analyse` in the same round: the median of {rounds} rounds.
*Our frames*: 4 pedestrians and about 5 detections a frame. *Pictures as COCO's*: one class, no
tracks, about 7 pedestrians and 100 detections a picture, most with low scores. vernier 0.5 always
evaluates COCO's four area ranges, the others one.
Load of the machine when it began: {load:.1f}.
"""


def opening_section(n_frames: int, rounds: int) -> str:
    """Return the section on opening against pyarrow reading the files."""
    load = os.getloadavg()[0]
    steps = ("pyarrow", "load", "audit", "analyse")
    rows = []
    for ending in ("csv", "parquet"):
        with tempfile.TemporaryDirectory() as folder:
            flags = ("--parquet",) if ending == "parquet" else ()
            _run("bench.csv_files", str(n_frames), folder, *flags)
            python = Path(sys.executable)
            figures = run_worker(python, "bench.opening", folder, "--repeat", str(rounds))
            size_mb = sum(path.stat().st_size for path in Path(folder).glob(f"*.{ending}")) / 1e6
        if "failed" in figures:
            rows.append([f"{ending}: {figures['failed']}", *("–" for _ in range(len(steps) + 3))])
            continue
        ratios = ([run[name] for run in figures["runs"]] for name in ("ratio", "load_ratio"))
        rows.append(
            [
                f"{ending}, {n_frames:,} ({size_mb:.0f} MB)",
                *(seconds_text(figures[step]) for step in steps),
                *(f"{median(of):.2f} ({min(of):.2f} to {max(of):.2f})" for of in ratios),
                f"{figures['kb_a_frame']:.2f} kB a frame",
            ]
        )
    text = OPENING.format(rounds=rounds, load=load, csv=MOST_CSV, parquet=MOST_PARQUET)
    return f"{text}\n{table(['frames', *steps, 'ratio', 'of load', 'peak'], rows)}\n"


def evaluators_section(sizes: dict[str, int], rounds: int, repeat: int) -> str:
    """Return the section on nvcore and COCO evaluators on each set."""
    load = os.getloadavg()[0]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for shape, n in sizes.items():
            path = Path(folder) / f"{n}.npz"
            _run("bench.sets", str(n), str(path), *SHAPES[shape][1])
            rounds_of = [_round(path, repeat) for _ in range(rounds)]
            rows += [_row(f"{shape}, {n:,}", name, rounds_of) for name in (OURS, *EVALUATORS)]
    head = ["set", "tool", "both systems", "ratio", "held against ours"]
    text = BESIDE.format(rounds=rounds, repeat=repeat, load=load)
    return f"{text}\n{table(head, rows)}\n"


def _round(path: Path, repeat: int) -> dict[str, dict[str, Any]]:
    """Return the results of every tool, run one after the other."""
    times = ("--repeat", str(repeat))
    ours = run_worker(Path(sys.executable), "bench.ours", str(path), "--only-analyse", *times)
    figures = {OURS: ours}
    for name in EVALUATORS:
        figures[name] = run_worker(TOOLS_PYTHON, "bench.others", name, str(path), *times)
    return figures


def _row(shape: str, name: str, rounds: Sequence[dict[str, dict[str, Any]]]) -> list[str]:
    failed = next((run[name]["failed"] for run in rounds if "failed" in run[name]), None)
    if failed is not None:
        return [shape, name, "–", "–", failed]
    took = [_seconds(run[name]) for run in rounds]
    ratios = [_seconds(run[name]) / _seconds(run[OURS]) for run in rounds]
    agreement = "" if name == OURS else _agreement(rounds[0][OURS], rounds[0][name])
    version = rounds[0][name]["versions"].get(name, "")
    return [
        shape,
        f"{name} {version}".strip(),
        seconds_text(median(took)),
        f"{median(ratios):.2f}",
        agreement,
    ]


def _seconds(figures: dict[str, Any]) -> float:
    seconds = figures["seconds"]
    middle: float = median(seconds["analyse"] if isinstance(seconds, dict) else seconds)
    return middle


def _agreement(ours: dict[str, Any], theirs: dict[str, Any]) -> str:
    pairs = zip(theirs["check"], ours["check"]["recall"], strict=True)
    off = max(abs(check["recall"] - recall) for check, recall in pairs)
    return "same recall" if off < 1e-9 else f"recall differs by {off:.1e}"


def _run(module: str, *arguments: str) -> None:
    subprocess.run([sys.executable, "-m", module, *arguments], cwd=ROOT, check=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", choices=("opening", "evaluators"), default="")
    parser.add_argument("--rounds", type=int, help="default: 3; 1 if quick")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    quick, rounds = options.quick, options.rounds or (1 if options.quick else 3)
    sizes = {shape: n // 10 if quick else n for shape, (n, _) in SHAPES.items()}
    sections: dict[str, Callable[[], str]] = {
        "opening": lambda: opening_section(20_000 if quick else 1_000_000, rounds),
        "evaluators": lambda: evaluators_section(sizes, rounds, 2 if quick else 5),
    }
    for name, make in sections.items():
        if options.only in ("", name):
            section = make()
            print(section)
            if options.out:
                put_section(options.out, section)


if __name__ == "__main__":
    main()
