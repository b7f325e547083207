from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from nvcore.evidence.units import autocovariance, block_length


def walk(seed: int, n: int, memory: float) -> np.ndarray:
    """First-order autoregressive trace."""
    return lfilter([1], [1, -memory], np.random.default_rng(seed).normal(size=n + 500))[500:]


def whole(trace: np.ndarray) -> np.ndarray:
    return np.array([0, len(trace)])


def test_autocovariance_of_a_trace_by_hand() -> None:
    # mean 2.5: -1.5, -0.5, 0.5, 1.5
    by_lag = autocovariance(np.array([1.0, 2, 3, 4]), np.array([0, 4]), n_lags=2)
    assert by_lag.tolist() == pytest.approx([5 / 4, (0.75 - 0.25 + 0.75) / 4, (-0.75 - 0.75) / 4])


def test_lags_never_cross_recordings() -> None:
    # two recordings of two frames, one of none: lag 1 has two products, lag 2 has none
    by_lag = autocovariance(np.array([1.0, 2, 3, 4]), np.array([0, 2, 2, 4]), n_lags=3)
    assert by_lag.tolist() == pytest.approx([5 / 4, (0.75 + 0.75) / 4])


@pytest.mark.parametrize(("memory", "n"), [(0.8, 20_000)])
def test_a_trace_with_memory_gets_the_length_that_theory_gives(memory: float, n: int) -> None:
    # Lahiri (1999) for blocks that do not overlap, with G / g(0) = 2 rho / (1 - rho^2)
    expected = (2 * memory / (1 - memory**2)) ** (2 / 3) * n ** (1 / 3)
    lengths = [block_length(walk(seed, n, memory), np.array([0, n])) for seed in range(5)]
    assert np.median(lengths) == pytest.approx(expected, rel=0.3)


def naive_length(trace: np.ndarray) -> int:
    """Politis and White's recipe, written down step by step."""
    n = len(trace)
    centred = trace - trace.mean()
    covariance = [float(np.sum(centred[k:] * centred[: n - k])) / n for k in range(n)]
    limit = 2 * np.sqrt(np.log10(n) / n)
    quiet = max(5, int(np.log10(n)))
    last = 0
    while any(abs(covariance[last + k] / covariance[0]) >= limit for k in range(1, quiet + 1)):
        last += 1
    width = 2 * max(last, 1)
    long_run, bias = covariance[0], 0.0
    for k in range(1, width + 1):
        share = k / width
        window = 1 if share <= 0.5 else 2 * (1 - share)
        long_run += 2 * window * covariance[k]
        bias += 2 * window * k * covariance[k]
    return int(np.ceil((2 * bias**2 / (2 * long_run**2)) ** (1 / 3) * n ** (1 / 3)))


@pytest.mark.parametrize("memory", [0.3, 0.6, 0.8, -0.5])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_length_is_that_of_the_recipe(memory: float, seed: int) -> None:
    trace = walk(seed, 800, memory)
    assert block_length(trace, whole(trace)) == naive_length(trace)


@pytest.mark.parametrize(
    "trace", [[], [0.3], [0.3] * 50, [1e15 / 7] * 50, [0.1, 0.1], [0.0, 1.0, 0.0]]
)
def test_traces_too_short_or_without_change_have_blocks_of_one_frame(trace: list[float]) -> None:
    values = np.array(trace)
    assert block_length(values, whole(values)) == 1


@pytest.mark.parametrize("n", range(2, 12))
def test_short_traces_have_blocks_within_them(n: int) -> None:
    trace = np.random.default_rng(n).normal(size=n)
    assert 1 <= block_length(trace, whole(trace)) <= max(1, n // 3)


def test_blocks_are_at_most_a_third_of_the_frames() -> None:
    trace = np.linspace(0, 1, 30)
    assert 1 < block_length(trace, whole(trace)) <= 10


def test_recordings_of_a_single_frame_have_no_lags() -> None:
    assert block_length(np.array([0.1, 0.7, 0.3, 0.9]), np.arange(5)) == 1
