"""Time and memory of one piece of work; a worker's report, one line of JSON.

Imports nothing but the standard library: every environment can use it.
"""

from __future__ import annotations

import gc
import json
import resource
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any

TO_VERDICT = "to the verdict"
"""Name of the row: comparison, audit, intervals, tests, companions and verdict."""
BUDGET_S = 30.0
"""No further repetition of one piece of work after so long."""


def measure(work: Callable[[], Any], times: int) -> tuple[Any, list[float], float]:
    """Result of the first of up to `times` calls, seconds of all, peak memory of the first, MB."""
    start = perf_counter()
    result, peak_mb = peak_beyond(work)
    return result, repeat(lambda _: work(), times, [perf_counter() - start]), peak_mb


def repeat(work: Callable[[int], Any], times: int, seconds: Sequence[float] = ()) -> list[float]:
    """Seconds of up to `times` calls ``work(i)``, after those in `seconds`; results are dropped."""
    seconds = list(seconds)
    while len(seconds) < times and sum(seconds) < BUDGET_S:
        gc.collect()
        start = perf_counter()
        result = work(len(seconds))
        seconds.append(perf_counter() - start)
        del result
    return seconds


def peak_beyond(work: Callable[[], Any]) -> tuple[Any, float]:
    """Result of `work`, and by how many MB the process's peak memory passed what it had before.

    On Linux the peak so far (of making the input) is forgotten first, and the peak is the
    process's own: ``getrusage`` there starts from that of the process which started this one.
    Elsewhere it is getrusage's, and a peak below that of making the input shows as 0.
    """
    gc.collect()
    if not _STATUS.exists():
        before = _rusage_peak_mb()
        return work(), _rusage_peak_mb() - before
    Path("/proc/self/clear_refs").write_text("5")
    before = _status_mb("VmRSS")
    result = work()
    return result, max(0.0, _status_mb("VmHWM") - before)


_STATUS = Path("/proc/self/status")


def _status_mb(name: str) -> float:
    values = dict(line.split(":", 1) for line in _STATUS.read_text().splitlines())
    return int(values[name].split()[0]) / 1024


def _rusage_peak_mb() -> float:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024**2 if sys.platform == "darwin" else 1024)


def versions(*packages: str) -> dict[str, str]:
    """Installed versions, Python's first."""
    return {"Python": sys.version.split()[0], **{name: version(name) for name in packages}}


def report(**figures: Any) -> None:
    """Print a worker's figures for `bench.run`: the last line of its output."""
    print(json.dumps(figures))
