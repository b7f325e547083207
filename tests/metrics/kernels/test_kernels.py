"""The pieces in which the compiled loops run; what they compute is held by the oracle."""

from __future__ import annotations

import os

import pytest

from nvcore.metrics import kernels
from nvcore.metrics.kernels import over_ranges


def spans(lo: int, hi: int, n: int) -> tuple[int, int, int]:
    return lo, hi, n


@pytest.mark.parametrize(
    ("threads", "n_frames", "pieces"),
    [
        ("3", 7, [(0, 2), (2, 4), (4, 7)]),
        ("3", 4, [(0, 2), (2, 4)]),
        ("3", 3, [(0, 3)]),
        ("0", 7, [(0, 7)]),
    ],
)
def test_many_frames_run_in_as_many_pieces_as_there_are_threads(
    threads: str, n_frames: int, pieces: list[tuple[int, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "MIN_PER_THREAD", 2)
    monkeypatch.setenv("OMP_NUM_THREADS", threads)
    assert over_ranges(spans, n_frames, 0) == [(lo, hi, 0) for lo, hi in pieces]


def test_threads_are_as_many_as_the_cores_that_the_process_may_run_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    cores = os.sched_getaffinity(0)
    assert kernels.thread_count() == len(cores)
    os.sched_setaffinity(0, {min(cores)})
    try:
        assert kernels.thread_count() == 1
    finally:
        os.sched_setaffinity(0, cores)


def test_few_frames_run_in_one_piece() -> None:
    assert over_ranges(spans, 1000, 7) == [(0, 1000, 7)]
