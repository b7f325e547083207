"""The compiled loops of training and detection.

As those of `nvcore.metrics.kernels` they take a range (``lo``, ``hi``), release the interpreter
lock and write into arrays that the caller made, so that threads share the work. No result depends
on where a range ends. Sums over rectangles are differences of four values of an integral image of
32 bits, taken modulo 2^32: exact for a picture of any size.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any

import numpy as np


def in_threads(kernel: Callable[..., Any], n: int, *arguments: Any) -> list[Any]:
    """Run ``kernel(lo, hi, *arguments)`` over 0..n, in as many threads as there are cores."""
    n_threads = min(os.cpu_count() or 1, n)
    if n_threads < 2:
        return [kernel(0, n, *arguments)]
    edges = np.linspace(0, n, n_threads + 1).astype(np.int64)
    with ThreadPoolExecutor(n_threads) as pool:
        jobs = [pool.submit(kernel, int(lo), int(hi), *arguments) for lo, hi in pairwise(edges)]
        return [job.result() for job in jobs]
