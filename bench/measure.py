"""Time and memory of a piece of work, and a worker's report as one line of JSON.

The module imports only the standard library, so that every environment can use it.
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
"""Name of the row with comparison, audit, intervals, tests, companions and verdict."""
BUDGET_S = 30.0
"""Total time after which a piece of work is not repeated again."""


def measure(work: Callable[[], Any], times: int) -> tuple[Any, list[float], float]:
    """Return the first result of up to `times` calls, all seconds, and the first call's peak MB."""
    start = perf_counter()
    result, peak_mb = peak_beyond(work)
    return result, repeat(lambda _: work(), times, [perf_counter() - start]), peak_mb


def repeat(work: Callable[[int], Any], times: int, seconds: Sequence[float] = ()) -> list[float]:
    """Call ``work(i)`` up to `times` times, and return the seconds after those given."""
    seconds = list(seconds)
    while len(seconds) < times and sum(seconds) < BUDGET_S:
        gc.collect()
        start = perf_counter()
        result = work(len(seconds))
        seconds.append(perf_counter() - start)
        del result
    return seconds


def peak_beyond(work: Callable[[], Any]) -> tuple[Any, float]:
    """Return the result of `work`, and the MB by which it raised the process's peak memory.

    On Linux, the earlier peak (from making the input) is reset, and the peak is the process's own.
    There ``getrusage`` would start from that of the parent process. Elsewhere getrusage is used,
    and a peak below that of making the input counts as 0.
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
    """Return installed versions, Python's first."""
    return {"Python": sys.version.split()[0], **{name: version(name) for name in packages}}


def report(**figures: Any) -> None:
    """Print a worker's results for `bench.run` as the last line of its output."""
    print(json.dumps(figures))
