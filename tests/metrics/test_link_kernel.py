"""Linking by optimal assignment; also run with NUMBA_DISABLE_JIT=1 for its coverage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from builders import Box, Place, make_dataset
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import linear_sum_assignment

from nvcore.metrics.link_kernel import assign, link_rows


@st.composite
def gains(draw: st.DrawFn) -> np.ndarray:
    """A matrix as linking makes it: no fewer columns than rows, some pairs not allowed."""
    n = draw(st.integers(1, 6))
    m = draw(st.integers(n, 7))
    value = st.one_of(st.just(0.0), st.floats(0.3, 1.0), st.sampled_from([0.3, 0.5, 1.0]))
    gain: np.ndarray = draw(arrays(np.float64, (n, m), elements=value, fill=st.nothing()))
    return gain


@settings(max_examples=150, deadline=None, derandomize=True)
@given(gains())
def test_the_assignment_has_the_total_gain_of_scipys(gain: np.ndarray) -> None:
    column = assign(gain)
    rows = np.flatnonzero(column >= 0)
    best = gain[linear_sum_assignment(gain, maximize=True)].sum()
    assert gain[rows, column[rows]].sum() == pytest.approx(best)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(gains())
def test_every_row_has_a_column_of_its_own_with_gain_or_none(gain: np.ndarray) -> None:
    column = assign(gain)
    rows = np.flatnonzero(column >= 0)
    assert len(set(column[rows])) == len(rows)
    assert (gain[rows, column[rows]] > 0).all()


def test_the_largest_total_goes_before_the_largest_single_gain() -> None:
    assert assign(np.array([[0.9, 0.8], [0.8, 0.0]])).tolist() == [1, 0]


def test_rows_without_any_gain_stay_apart() -> None:
    assert assign(np.zeros((2, 3))).tolist() == [-1, -1]


def linked(*boxes: Sequence[float], places: Sequence[Place] | None = None) -> list[int]:
    """Track numbers of X's boxes (frame, x, y, w, h)."""
    dataset = make_dataset(x=[Box(*box) for box in boxes], places=places)  # type: ignore[arg-type]
    b, frames = dataset.system("x"), dataset.frame_columns
    track = np.empty(len(b), np.int64)
    n_tracks = link_rows(
        np.arange(len(b)), b.frame_index, frames.recording, b.x, b.y, b.w, b.h, 0.3, 2, track
    )
    assert n_tracks == track.max(initial=-1) + 1
    return track.tolist()


def test_nothing_to_link_makes_no_track() -> None:
    assert linked() == []


def test_boxes_that_share_less_than_a_pixel_are_linked() -> None:
    assert linked((0, 50, 50, 0.8, 0.8), (1, 50, 50, 0.8, 0.8)) == [0, 0]


def test_a_moving_box_keeps_its_track() -> None:
    assert linked((0, 0, 0, 10, 10), (1, 3, 0, 10, 10), (2, 6, 0, 10, 10)) == [0, 0, 0]


def test_an_iou_just_below_the_limit_starts_a_track() -> None:
    # shared 4.6, union 15.4: 0.2987; shared 5, union 15: 0.3333
    assert linked((0, 0, 0, 10, 1), (1, 5.4, 0, 10, 1)) == [0, 1]
    assert linked((0, 0, 0, 10, 1), (1, 5.0, 0, 10, 1)) == [0, 0]


def test_an_iou_of_exactly_the_limit_links() -> None:
    assert linked((0, 0, 0, 10, 10), (1, 0, 0, 10, 3)) == [0, 0]


def test_two_missing_frames_are_bridged_and_three_are_not() -> None:
    assert linked((0, 0, 0, 10, 10), (3, 0, 0, 10, 10)) == [0, 0]
    assert linked((0, 0, 0, 10, 10), (4, 0, 0, 10, 10)) == [0, 1]


def test_the_gap_is_counted_in_listed_frames() -> None:
    sampled = [Place([0, 20, 40, 60, 80])]
    assert linked((0, 0, 0, 10, 10), (60, 0, 0, 10, 10), places=sampled) == [0, 0]
    assert linked((0, 0, 0, 10, 10), (80, 0, 0, 10, 10), places=sampled) == [0, 1]


def test_a_track_never_crosses_recordings() -> None:
    boxes = [Box(0, 0, 0, 10, 10), Box(0, 0, 0, 10, 10, recording=1)]
    assert linked(*boxes, places=[Place([0]), Place([0])]) == [0, 1]


def test_two_boxes_of_one_frame_never_share_a_track() -> None:
    assert linked((0, 0, 0, 10, 10), (1, 0, 0, 10, 10), (1, 1, 0, 10, 10)) == [0, 0, 1]


def test_two_tracks_never_end_in_one_box() -> None:
    assert linked((0, 0, 0, 10, 10), (0, 2, 0, 10, 10), (1, 2, 0, 10, 10)) == [0, 1, 1]


def test_the_largest_total_iou_decides_between_two_that_walk_past_each_other() -> None:
    # greedily the first takes the last (0.82) and two stay apart; the other way gains 0.97
    boxes = [(0, 4, 0, 10, 10), (0, 8, 0, 10, 10), (1, 0, 0, 10, 10), (1, 5, 0, 10, 10)]
    assert linked(*boxes) == [0, 1, 0, 1]


def test_more_than_sixteen_tracks_at_once_are_kept_apart() -> None:
    boxes = [(f, 20 * i + f, 0, 10, 10) for f in range(3) for i in range(25)]
    assert linked(*boxes) == list(range(25)) * 3


def test_tracks_survive_when_more_join_than_there_was_room_for() -> None:
    few = [(0, 20 * i, 0, 10, 10) for i in range(10)]
    many = [(1, 20 * i, 0, 10, 10) for i in range(30)]
    assert linked(*few, *many) == [*range(10), *range(30)]
