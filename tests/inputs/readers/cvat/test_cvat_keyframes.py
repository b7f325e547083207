"""Frames between the keyframes of a track."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nvcore.inputs.readers.cvat.video import (
    FilledTracks,
    TooManyFramesError,
    fill_between_keyframes,
)


def fill(frames: list[int], *, tracks: list[int] | None = None, step: int = 1) -> FilledTracks:
    n = len(frames)
    return fill_between_keyframes(
        np.array(tracks or [0] * n, dtype=np.int64),
        np.array(frames, dtype=np.int64),
        np.zeros(n, dtype=bool),
        np.ones(n, dtype=bool),
        np.full(n, step, dtype=np.int64),
        limit=1000,
    )


def test_no_rows_stay_no_rows() -> None:
    assert len(fill([])) == 0


def test_frames_are_filled_step_by_step() -> None:
    assert fill([0, 10, 15], step=5).frame.tolist() == [0, 5, 10, 15]


def test_two_rows_of_one_frame_both_stay() -> None:
    assert fill([3, 3]).frame.tolist() == [3, 3]


def test_rows_keep_their_values_where_a_neighbour_has_none() -> None:
    filled = fill([0, 2])
    values = filled.between(np.array([1.0, np.nan]))
    np.testing.assert_array_equal(values, [1, np.nan, np.nan])


def test_more_rows_than_the_limit_are_refused_with_the_longest_gap() -> None:
    with pytest.raises(TooManyFramesError) as caught:
        fill([0, 5, 2000, 2001])
    assert caught.value.row == 1


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 60)), max_size=12, unique=True))
def test_every_frame_between_the_first_and_the_last_of_a_track_is_there_once(
    rows: list[tuple[int, int]],
) -> None:
    tracks, frames = [row[0] for row in rows], [row[1] for row in rows]
    filled = fill(frames, tracks=tracks)
    found = (
        sorted(zip(np.array(tracks)[filled.left].tolist(), filled.frame.tolist(), strict=True))
        if rows
        else []
    )
    expected = []
    for track in sorted(set(tracks)):
        own = [f for t, f in rows if t == track]
        expected += [(track, f) for f in range(min(own), max(own) + 1)]
    assert found == expected


@given(st.lists(st.integers(0, 60), min_size=2, max_size=8, unique=True))
def test_a_quantity_that_is_linear_in_time_stays_so(frames: list[int]) -> None:
    filled = fill(frames)
    values = filled.between(3.0 * np.array(frames) - 7)
    assert values == pytest.approx(3.0 * filled.frame - 7)
