"""Choice of the length of time blocks, so that successive blocks are nearly independent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import scipy

INSIGNIFICANT: Final = 2.0
"""Autocorrelations below this many times sqrt(log10(n) / n) count as zero."""


def block_length(trace: np.ndarray, first: np.ndarray) -> int:
    """Return the block length in frames for resampling a trace in non-overlapping blocks.

    This is the automatic choice of Politis and White: the length that minimises the error of the
    bootstrap's variance, from the trace's autocorrelations up to the lag at which they fade. Blocks
    that do not overlap have a variance of ``2 * g(0)^2 * b / n``.

    Parameters
    ----------
    trace
        Difference of the two systems in every frame; float64, shape (n_frames,).
    first
        First row of each recording, shape (n_recordings + 1,); lags never cross recordings.

    Returns
    -------
    At least 1, at most a third of the frames or ``3 * sqrt(n_frames)``.

    References
    ----------
    Politis and White (2004), Automatic block-length selection for the dependent bootstrap, with
    the correction by Patton, Politis and White (2009); Lahiri (1999), Theoretical comparisons of
    block bootstrap methods.
    """
    n = len(trace)
    if n < 2:
        return 1
    n_quiet = max(5, int(np.log10(n)))
    covariance = autocovariance(trace, first, n_lags=int(np.ceil(np.sqrt(n))) + n_quiet)
    # the autocorrelation of a constant trace is rounding
    if covariance[0] <= 1e-20 * max(1.0, float(np.abs(trace).max()) ** 2):
        return 1
    n_lags = len(covariance) - 1
    is_quiet = np.abs(covariance[1:] / covariance[0]) < INSIGNIFICANT * np.sqrt(np.log10(n) / n)
    # the last lag after which `n_quiet` lags in a row are quiet
    quiet_before = np.concatenate([[0], np.cumsum(is_quiet)])
    n_runs = max(len(quiet_before) - n_quiet, 0)
    runs = quiet_before[n_quiet:] - quiet_before[:n_runs] == n_quiet
    if runs.any():
        last = int(np.argmax(runs))
    else:
        loud = np.flatnonzero(~is_quiet)
        last = int(loud[-1]) + 1 if len(loud) else 0
    width = min(2 * max(last, 1), n_lags)
    if width < 1:
        return 1
    lag = np.arange(1, width + 1)
    window = np.minimum(1, 2 * (1 - lag / width))
    tapered = window * covariance[1 : width + 1]
    bias = 2 * float((lag * tapered).sum())
    long_run = float(covariance[0] + 2 * tapered.sum())
    most = max(1, int(min(3 * np.sqrt(n), n / 3)))
    if long_run <= 0:
        return most
    best = (bias**2 / long_run**2) ** (1 / 3) * n ** (1 / 3)
    return int(min(max(np.ceil(best), 1), most))


def autocovariance(trace: np.ndarray, first: np.ndarray, *, n_lags: int) -> np.ndarray:
    """Return the autocovariance at lags 0..n_lags within recordings, over the number of all frames.

    There are fewer lags if the longest recording has fewer frames.
    """
    deviation = trace - trace.mean()
    parts: Sequence[np.ndarray] = np.split(deviation, first[1:-1])
    n_lags = min(n_lags, max(len(part) for part in parts) - 1)
    total = np.zeros(n_lags + 1)
    for part in parts:  # a loop over recordings: few where blocks are used
        if len(part):
            products = scipy.signal.correlate(part, part, method="fft")[len(part) - 1 :][
                : n_lags + 1
            ]
            total[: len(products)] += products
    covariance: np.ndarray = total / len(trace)
    return covariance
