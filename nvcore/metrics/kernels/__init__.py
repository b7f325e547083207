"""Compiled loops over frames, boxes and encounters.

All kernels work on columns sorted by frame, where ``offsets[f]:offsets[f + 1]`` are the rows of
frame f, and write into arrays that the caller allocates. They take a range of frames (``lo``,
``hi``) and release the interpreter lock, so that `over_ranges` can run them in threads. This avoids
numba's own parallel mode, which takes seconds to compile. Frames have a handful of boxes, so all
pairs are tried; below about 48 boxes per side this is faster than sorting.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, Final

import numpy as np

from nvcore.metrics.kernels.compiling import compiler

ABSORB_SHARE: Final = 0.5
"""Least share of a detection's area inside an ignore region for the detection not to count."""

compiled = compiler()
"""Decorator: compile on first use, cache the machine code on disk, release the interpreter lock."""

MIN_PER_THREAD: Final = 20_000
"""Smallest number of frames that justifies a thread."""


def thread_count() -> int:
    """Return the number of threads to use: ``OMP_NUM_THREADS``, or the number of usable cores."""
    stated = os.environ.get("OMP_NUM_THREADS", "")
    if stated.isdecimal():
        return max(int(stated), 1)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def over_ranges(
    kernel: Callable[..., Any], n: int, *arguments: Any, least: int | None = None
) -> list[Any]:
    """Run ``kernel(lo, hi, *arguments)`` over 0..n in `thread_count` threads.

    Parameters
    ----------
    least
        Smallest part of the range that justifies a thread; None: `MIN_PER_THREAD`.
    """
    n_threads = min(thread_count(), n // (least or MIN_PER_THREAD))
    if n_threads < 2:
        return [kernel(0, n, *arguments)]
    edges = np.linspace(0, n, n_threads + 1).astype(np.int64)
    with ThreadPoolExecutor(n_threads) as pool:
        jobs = [pool.submit(kernel, int(lo), int(hi), *arguments) for lo, hi in pairwise(edges)]
        return [job.result() for job in jobs]


@compiled
def centre(x: float, w: float, width: float) -> float:
    """Return the lateral position of a box: its centre, clipped to the picture."""
    return min(max(x + 0.5 * w, 0.0), width)


@compiled
def border(c: float, width: float, rho: float) -> float:
    """Return the upper limit of the distance of a box at `c`, px, for this edge weight."""
    return rho * 0.5 * width + (1.0 - rho) * min(c, width - c)


@compiled
def intersection(
    ax: float, ay: float, aw: float, ah: float, bx: float, by: float, bw: float, bh: float
) -> float:
    """Return the area shared by two boxes in continuous pixels, or 0 if they do not touch."""
    across = min(ax + aw, bx + bw) - max(ax, bx)
    down = min(ay + ah, by + bh) - max(ay, by)
    if across <= 0.0 or down <= 0.0:
        return 0.0
    return across * down
