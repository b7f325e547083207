"""The pieces in which the compiled loops run; what they compute is held by the oracle."""

from __future__ import annotations

import pytest

from nvcore.metrics import kernels
from nvcore.metrics.kernels import over_ranges


def spans(lo: int, hi: int, n: int) -> tuple[int, int, int]:
    return lo, hi, n


@pytest.mark.parametrize(
    ("n_cores", "n_frames", "pieces"),
    [
        (3, 7, [(0, 2), (2, 4), (4, 7)]),
        (3, 4, [(0, 2), (2, 4)]),
        (3, 3, [(0, 3)]),
        (None, 7, [(0, 7)]),
    ],
)
def test_many_frames_run_in_as_many_pieces_as_there_are_cores(
    n_cores: int | None,
    n_frames: int,
    pieces: list[tuple[int, int]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(kernels, "MIN_PER_THREAD", 2)
    monkeypatch.setattr(kernels.os, "cpu_count", lambda: n_cores)
    assert over_ranges(spans, n_frames, 0) == [(lo, hi, 0) for lo, hi in pieces]


def test_few_frames_run_in_one_piece() -> None:
    assert over_ranges(spans, 1000, 7) == [(0, 1000, 7)]
