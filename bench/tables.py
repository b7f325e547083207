"""Text of docs/benchmarks.md from the results of `bench.run`."""

from __future__ import annotations

import math
import os
import platform
import subprocess
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from typing import Any

from bench.measure import TO_VERDICT
from bench.workers import ROOT

METHOD = """\
Synthetic sets with a fixed seed (`bench/sets.py`): exactly 4 pedestrians a frame, 4 + 4 detections
on average, recordings of 1,000 frames, tracks of 80 frames on average, late first detections,
dropouts and lasting false alarms. Numbers are medians of repeated runs, each tool in a fresh
process, one after the other. Peak memory is what the process needed beyond its input.

*Timed* is the work from boxes in memory, in the tool's own objects, to measures. Only the rows
*from files* include reading files. Loading nvcore's compiled functions is not included.
"""

FROM_FILES_NOTE = """\
For the rows *from files* and *TrackEval preprocessing + CLEAR* the set is written as MOTChallenge
text just before (and so cached in memory): boxes to three decimals, one sequence with `seqinfo.ini`
a recording. One process scores both systems, timed after its imports and a run on 100 frames.

- *nvcore, from files*: `load` (detecting the format, reading and hashing, placing the boxes in
  frames) and `analyse`, which may use two threads; neither the audit nor writing results.
- *TrackEval Evaluator, from files*: `Evaluator` on `MotChallenge2DBox` with CLEAR and Count:
  reading, IoU, preprocessing, CLEAR. It reads the truth anew for each system. Preprocessing is the
  default of MOT17, which looks for distractors (the set has none). No parallel mode, no output.
- *TrackEval preprocessing + CLEAR*: `get_preprocessed_seq_data` and CLEAR. TrackEval computes IoU
  while it reads: that is under *making its objects*, whereas the time of `analyse` includes it.
- *TrackEval CLEAR*: IoU and the metric alone, on arrays.

The target for TrackEval is for *TrackEval preprocessing + CLEAR*: what its user waits for once the
files are read.
"""

MOST_RATIOS = {
    "change of alpha": 0.02,
    "change of sigmoid midpoint": 0.2,
    "change of threshold": 0.7,
    "change of IoU": 0.7,
}
"""Targets for 1M frames: their time relative to that of `analyse`."""
MOST_TO_VERDICT = 3
"""Target for the time to the verdict, relative to that of `analyse`."""
PEAK_MB = 1_500
"""Target for peak memory at 1M frames."""
LEAST_RATIOS = {
    "numpy loop": 70,
    "TrackEval preprocessing + CLEAR": 100,
    "faster-coco-eval": 20,
    "hotcoco compare": 1,
}
"""Targets for 100k frames: their time relative to that of `analyse`."""
OURS_FROM_FILES = "nvcore, from files"
CALLS_S = {
    "libraries": ("`import numba, pandas, pyarrow, scipy.stats`, for comparison", math.inf),
    "first": ("first `nvcore compare` of the sample (compiles)", 3),
    "second": ("second `nvcore compare` of the sample", 2),
    "import": ("`from nvcore import compare`", 1.2),
}
"""Commands that start a process, with targets in processor seconds."""


def seconds_text(seconds: float) -> str:
    """Format seconds with three digits in a suitable unit."""
    return f"{seconds * 1e3:.3g} ms" if seconds < 0.9995 else f"{seconds:.3g} s"


def growth_exponent(sizes: Sequence[int], seconds: Sequence[float]) -> float:
    """Fit the slope of log time over log size. 1 is linear, NaN below two sizes."""
    if len(sizes) < 2:
        return math.nan
    x, y = [math.log(n) for n in sizes], [math.log(s) for s in seconds]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    across = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True))
    return across / sum((a - mean_x) ** 2 for a in x)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table, padded for reading in a terminal. The first column is text."""
    widths = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]

    def line(cells: Sequence[str]) -> str:
        first, *others = zip(cells, widths, strict=True)
        padded = [first[0].ljust(first[1]), *(cell.rjust(width) for cell, width in others)]
        return "| " + " | ".join(padded) + " |"

    rule = "|" + "|".join(
        "-" * (width + 2) if i == 0 else "-" * (width + 1) + ":" for i, width in enumerate(widths)
    )
    return "\n".join([line(head), rule + "|", *(line(row) for row in rows)])


def write_tables(
    ours: dict[int, dict[str, Any]],
    beside: dict[str, dict[str, Any]],
    others_at: int,
    command_line: dict[str, list[float] | str],
) -> str:
    """Return the whole page.

    Parameters
    ----------
    ours
        Reports of `bench.ours` by number of frames.
    beside
        Reports of `bench.baselines` and `bench.others` at `others_at` frames by name, or
        ``{"failed": why}``.
    command_line
        Result of `measure_command_line`.
    """
    parts = [
        "# Benchmarks",
        "Written by `make bench`; do not edit.",
        _machine(ours, beside),
        METHOD.rstrip(),
        "## `analyse`, two systems",
        _growth_table(ours),
        _growth_note(ours),
        "## Targets",
        _targets_table(ours, beside, others_at),
        f"## Beside other tools, {others_at:,} frames",
        _beside_note(),
        _beside_table(ours[others_at], beside),
        FROM_FILES_NOTE.rstrip(),
        "## Command line",
        _command_line_text(command_line),
    ]
    return "\n\n".join(parts) + "\n"


def _machine(ours: dict[int, dict[str, Any]], beside: dict[str, dict[str, Any]]) -> str:
    python, *packages = _versions(next(iter(ours.values())))
    tools = {
        f"{name} {version}"
        for figures in beside.values()
        for name, version in figures.get("versions", {}).items()
        if name not in ("Python", "numpy", "numba", "pandas", "pyarrow", "scipy")
    }
    memory_gb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1024**3
    lines = [
        f"- Machine: {_processor()}, {os.cpu_count()} cores, {memory_gb:.0f} GB, "
        f"{platform.system()} {platform.machine()}",
        f"- {python}; {', '.join(packages)}",
        f"- Other tools: {', '.join(sorted(tools)) or 'none installed'}",
        f"- Date: {datetime.now(UTC):%Y-%m-%d}; commit {commit(ROOT)}",
    ]
    return "\n".join(lines)


def commit(root: Path) -> str:
    """Return the short description of a checkout's commit, or "unknown" without git."""
    git = ["git", "-C", str(root), "describe", "--always", "--dirty", "--exclude=*"]
    return subprocess.run(git, capture_output=True, text=True, check=False).stdout.strip() or (
        "unknown"
    )


def _versions(figures: dict[str, Any]) -> list[str]:
    return [f"{name} {version}" for name, version in figures["versions"].items()]


def _processor() -> str:
    listing = Path("/proc/cpuinfo")
    if listing.exists():
        for line in listing.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or "unknown processor"


def _growth_table(ours: dict[int, dict[str, Any]]) -> str:
    sizes = sorted(ours)
    names = list(ours[sizes[0]]["seconds"])
    rows = [
        [
            name,
            *(seconds_text(median(ours[n]["seconds"][name])) for n in sizes),
            _exponent(ours, sizes, name),
        ]
        for name in names
    ]
    memory = ["peak memory beyond input", *(f"{ours[n]['peak_mb']:.0f} MB" for n in sizes), ""]
    inputs = ["input", *(f"{ours[n]['input_mb']:.0f} MB" for n in sizes), ""]
    return table(["", *(f"{n:,} frames" for n in sizes), "growth"], [*rows, memory, inputs])


def _large(sizes: Sequence[int]) -> list[int]:
    return [n for n in sizes if n >= 10_000]


def _exponent(ours: dict[int, dict[str, Any]], sizes: Sequence[int], name: str) -> str:
    large = _large(sizes)
    exponent = growth_exponent(large, [median(ours[n]["seconds"][name]) for n in large])
    return "" if math.isnan(exponent) else f"{exponent:.2f}"


def _growth_note(ours: dict[int, dict[str, Any]]) -> str:
    repeats = min(len(runs) for figures in ours.values() for runs in figures["seconds"].values())
    return (
        "A change starts from the result with the default parameters (`previous=`) and moves one "
        "parameter of both systems to a value not seen before. *Growth* is the slope of log time "
        "over log frames from 10,000 frames on: 1 is linear, less means that fixed costs still "
        f"show. At least {repeats} runs each."
    )


def _targets_table(
    ours: dict[int, dict[str, Any]], beside: dict[str, dict[str, Any]], others_at: int
) -> str:
    rows: list[list[str]] = []

    def row(what: str, target: str, result: str, is_met: bool) -> None:
        rows.append([what, target, result, "yes" if is_met else "no"])

    million = ours.get(1_000_000)  # targets are for this number of frames
    if million:
        for what, most in MOST_RATIOS.items():
            ratio = median(million["seconds"][what]) / median(million["seconds"]["analyse"])
            row(f"{what} over analyse, 1,000,000 frames", f"{most} or less",
                f"{ratio:.2g}", ratio <= most)  # fmt: skip
        peak_mb = million["peak_mb"]
        row("peak memory beyond input, 1,000,000 frames", f"{PEAK_MB} MB or less",
            f"{peak_mb:.0f} MB", peak_mb <= PEAK_MB)  # fmt: skip
    large = _large(sorted(ours))
    growth = growth_exponent(large, [median(ours[n]["seconds"]["analyse"]) for n in large])
    if not math.isnan(growth):
        row("growth of analyse", "1.1 or less", f"{growth:.2f}", growth <= 1.1)
    analyse_s = median(ours[others_at]["seconds"]["analyse"])
    if TO_VERDICT in ours[others_at]["seconds"]:
        ratio = median(ours[others_at]["seconds"][TO_VERDICT]) / analyse_s
        row(f"{TO_VERDICT} over analyse, {others_at:,} frames", f"{MOST_TO_VERDICT} or less",
            f"{ratio:.3g}", ratio <= MOST_TO_VERDICT)  # fmt: skip
    for name, least in LEAST_RATIOS.items() if others_at == 100_000 else ():
        if "failed" not in beside[name]:
            ratio = median(beside[name]["seconds"]) / analyse_s
            row(f"{name} over analyse, {others_at:,} frames", f"{least} or more",
                f"{ratio:.3g}", ratio >= least)  # fmt: skip
    return table(["what", "target", "found", "met"], rows)


def _beside_note() -> str:
    return (
        "Every row scores both systems on the same boxes, but the tools compute different things. "
        "hotcoco, ultrafast-pycocotools, vernier (over COCO's four area ranges) and "
        "faster-coco-eval: average precision at one IoU. `hotcoco compare`: both evaluations and "
        "`compare` without bootstrap. TrackEval and motmetrics: CLEAR tracking figures, from "
        "faultless track ids, one sequence a recording. The loops by hand: only similarity and "
        "matches (numpy) or unweighted distances (scipy). *Making its objects* turns the boxes "
        "into the tool's own form and is not in the time. *Ratio* is the time over that of "
        "`analyse`, in the rows *from files* over that of nvcore from files."
    )


def _beside_table(ours: dict[str, Any], beside: dict[str, dict[str, Any]]) -> str:
    analyse_s = median(ours["seconds"]["analyse"])
    rows = [
        ["nvcore analyse", seconds_text(analyse_s), "1", str(len(ours["seconds"]["analyse"])),
         f"{ours['peak_mb']:.0f} MB", "", ""]
    ]  # fmt: skip
    from_files = beside[OURS_FROM_FILES]
    for name, figures in beside.items():
        if "failed" in figures:
            rows.append([name, "–", "–", "–", "–", "–", figures["failed"]])
            continue
        took = median(figures["seconds"])
        prepare = seconds_text(figures["prepare_s"]) if "prepare_s" in figures else ""
        ratio = f"{took / analyse_s:.3g}"
        if name.endswith("from files"):
            ratio = "–"
            if "failed" not in from_files:
                ratio = f"{took / median(from_files['seconds']):.3g} (from files)"
        rows.append(
            [name, seconds_text(took), ratio, str(len(figures["seconds"])),
             f"{figures['peak_mb']:.0f} MB", prepare, _agreement(ours["check"], figures)]
        )  # fmt: skip
    head = ["", "both systems", "ratio", "runs", "peak memory", "making its objects",
            "held against ours"]  # fmt: skip
    return table(head, rows)


def _agreement(check: dict[str, list[float]], figures: dict[str, Any]) -> str:
    """Describe in one sentence how a tool's results for both systems compare with ours."""
    if "agreement" in figures:
        return str(figures["agreement"])
    theirs = figures["check"]
    if "recall" in theirs[0]:
        off = max(abs(t["recall"] - r) for t, r in zip(theirs, check["recall"], strict=True))
        return "same recall" if off < 1e-9 else f"recall differs by {off:.1e}"
    off = max(abs(t["matched"] - m) / m for t, m in zip(theirs, check["matched"], strict=True))
    # they assign optimally and keep tracks together, ours is greedy by score
    matches = "same matches" if not off else f"matches within {math.ceil(off * 1e4) / 100:.2g} %"
    if "n_det" not in theirs[0]:
        return matches
    counted = all(
        t[n] == m for n in ("n_truth", "n_det") for t, m in zip(theirs, check[n], strict=True)
    )
    return f"{'same' if counted else 'another'} number of boxes, {matches}"


def _command_line_text(command_line: dict[str, list[float] | str]) -> str:
    if "failed" in command_line:
        return f"Not measured: {command_line['failed']}"
    rows = [
        [what, *map(seconds_text, command_line[call]), *_judged(command_line[call][1], limit_s)]
        for call, (what, limit_s) in CALLS_S.items()
    ]  # fmt: skip
    return table(["whole process", "by the clock", "processor", "target", "met"], rows)


def _judged(seconds: float, limit_s: float) -> tuple[str, str]:
    if math.isinf(limit_s):
        return "", ""
    return f"{limit_s} s or less", "yes" if seconds <= limit_s else "no"
