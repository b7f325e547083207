"""The compiled loops, driven directly; also run with NUMBA_DISABLE_JIT=1 for their coverage."""

from __future__ import annotations

import numpy as np
import pytest
from builders import NAN, Box, Place, at, make_dataset

from nvcore.dataset import BoxColumns, Dataset
from nvcore.metrics import kernels
from nvcore.metrics.kernels import (
    centre,
    encounter_frames,
    group_rows,
    intersection,
    match_frames,
    maximin_frames,
    maximum_frames,
    nearest_frames,
    over_ranges,
    pair_frames,
)
from nvcore.schema import DetectionState

BELOW, MATCHED, FALSE_ALARM, ABSORBED = DetectionState


def all_true(boxes: BoxColumns) -> np.ndarray:
    return np.ones(len(boxes), dtype=bool)


def matched(
    dataset: Dataset,
    *,
    threshold: float = -np.inf,
    iou: float = 0.5,
    lateral: bool = False,
    tolerance: float = 0.02,
) -> tuple[list[int], list[int], list[int]]:
    """State and pedestrian of every detection of X, and detection of every truth box."""
    g, d, frames = dataset.truth, dataset.system("x"), dataset.frame_columns
    state, det_truth = np.empty(len(d), np.int8), np.empty(len(d), np.int64)
    truth_det = np.empty(len(g), np.int64)
    over_ranges(
        match_frames, len(frames), g.offsets, g.x, g.y, g.w, g.h, g.ignore,
        d.offsets, d.x, d.y, d.w, d.h, d.score, threshold, iou, lateral, tolerance,
        frames.recording, frames.width, state, det_truth, truth_det,
    )  # fmt: skip
    return state.tolist(), det_truth.tolist(), truth_det.tolist()


def nearest(dataset: Dataset, *, ground: bool = False) -> tuple[list[float], list[float]]:
    a, b, frames = dataset.truth, dataset.system("x"), dataset.frame_columns
    near_a, near_b = np.empty(len(a)), np.empty(len(b))
    nearest_frames(
        0, len(frames), a.offsets, a.x, a.y, a.w, a.h, ~a.ignore,
        b.offsets, b.x, b.y, b.w, b.h, all_true(b) & ~(b.score < 0), ground, frames.recording,
        frames.width, near_a, near_b,
    )  # fmt: skip
    return near_a.tolist(), near_b.tolist()


def maximin(
    dataset: Dataset, near: list[float], k: list[float], *, edge_weight: float = 0.0
) -> tuple[list[float], list[int]]:
    a, frames = dataset.truth, dataset.frame_columns
    d, argmax = np.empty(len(frames)), np.empty(len(frames), np.int64)
    maximin_frames(
        0, len(frames), a.offsets, a.x, a.w, np.array(k, float), np.array(near, float), ~a.ignore,
        a.track, edge_weight, frames.recording, frames.width, d, argmax,
    )  # fmt: skip
    return d.tolist(), argmax.tolist()


def paired(dataset: Dataset, iou: float = 0.5) -> list[int]:
    a, b = dataset.system("x"), dataset.system("y")
    partner = np.empty(len(a), np.int64)
    pair_frames(
        0, len(dataset.frames), a.offsets, a.x, a.y, a.w, a.h, ~(a.score < 0),
        b.offsets, b.x, b.y, b.w, b.h, ~(b.score < 0), iou, partner,
    )  # fmt: skip
    return partner.tolist()


def judged(dataset: Dataset, k: list[float], hits: list[bool]) -> list[float]:
    """Relevant, matched, peak k, lag, longest gap, tail (in frames) of the only encounter."""
    truth, frames = dataset.truth, dataset.frame_columns
    counts = np.empty((2, 1), np.int64)
    figures = np.empty((4, 1))
    encounter_frames(
        0, 1, np.array([0, len(truth)]), np.arange(len(truth)), truth.frame_index, frames.frame,
        frames.gap, np.array(k, float), np.array(hits), *counts, *figures,
    )  # fmt: skip
    return [*counts[:, 0].tolist(), *figures[:, 0].tolist()]


@pytest.mark.parametrize(("x", "expected"), [(10, 15), (-20, 0), (-4, 1), (98, 100), (95, 100)])
def test_the_centre_is_clipped_to_the_picture(x: float, expected: float) -> None:
    assert centre(x, 10.0, 100.0) == expected


def test_boxes_that_only_touch_share_nothing() -> None:
    assert intersection(0.0, 0.0, 10.0, 10.0, 10.0, 0.0, 10.0, 10.0) == 0
    assert intersection(0.0, 0.0, 10.0, 10.0, 0.0, 10.0, 10.0, 10.0) == 0
    assert intersection(0.0, 0.0, 10.0, 10.0, 5.0, 7.0, 10.0, 10.0) == 15


def test_the_better_score_takes_the_pedestrian() -> None:
    x = [Box(0, 1, 0, 10, 10, score=0.4), Box(0, 2, 0, 10, 10, score=0.6)]
    dataset = make_dataset([(0, 0, 0, 10, 10, 1)], x)
    assert matched(dataset) == ([FALSE_ALARM, MATCHED], [-1, 0], [1])


def test_equal_scores_go_by_file_order() -> None:
    x = [Box(0, 2, 0, 10, 10, score=0.5), Box(0, 0, 0, 10, 10, score=0.5)]
    assert matched(make_dataset([(0, 0, 0, 10, 10, 1)], x))[0] == [MATCHED, FALSE_ALARM]


def test_missing_scores_come_last_in_file_order() -> None:
    x = [Box(0, 1, 0, 10, 10), Box(0, 2, 0, 10, 10), Box(0, 3, 0, 10, 10, score=-5)]
    truth = [(0, 0, 0, 10, 10, 1)]
    assert matched(make_dataset(truth, x))[0] == [FALSE_ALARM, FALSE_ALARM, MATCHED]
    assert matched(make_dataset(truth, x[:2]))[0] == [MATCHED, FALSE_ALARM]


def test_a_score_at_the_threshold_passes_and_a_missing_one_does() -> None:
    x = [Box(0, 0, 0, 9, 9, score=0.5), Box(0, 0, 0, 9, 9, score=0.49), Box(0, 0, 0, 9, 9)]
    assert matched(make_dataset(x=x), threshold=0.5)[0] == [FALSE_ALARM, BELOW, FALSE_ALARM]


def test_more_than_sixteen_detections_in_a_frame_are_ordered_too() -> None:
    x = [Box(0, i, 0, 10, 10, score=i) for i in range(40)]
    state, _, truth_det = matched(make_dataset([(0, 20, 0, 10, 10, 1)], x))
    assert truth_det == [23]  # the best score with an IoU of at least 0.5
    assert state.count(MATCHED) == 1


def test_a_detection_takes_the_free_pedestrian_of_highest_iou() -> None:
    truth = [(0, 0, 0, 10, 10, 1), (0, 2, 0, 10, 10, 2)]
    x = [Box(0, 2, 0, 10, 10, score=1), Box(0, 2, 0, 10, 10, score=0)]
    assert matched(make_dataset(truth, x))[1] == [1, 0]


def test_no_overlap_is_no_match_however_low_the_limit() -> None:
    dataset = make_dataset([(0, 0, 0, 10, 10, 1)], [(0, 50, 0, 10, 10)])
    assert matched(dataset, iou=1e-9)[2] == [-1]


def test_half_a_detection_on_an_ignore_region_is_absorbed() -> None:
    truth = [Box(0, 0, 0, 50, 50, ignore=True)]
    x = [Box(0, 45, 0, 10, 10), Box(0, 45.1, 0, 10, 10), Box(0, 80, 0, 10, 10)]
    assert matched(make_dataset(truth, x))[0] == [ABSORBED, FALSE_ALARM, FALSE_ALARM]


def test_lateral_matching_takes_the_nearest_free_pedestrian_within_reach() -> None:
    truth = [at(0, 20, w=4), at(0, 30, w=4), at(0, 60, w=20, ignore=True)]
    x = [at(0, 29), at(0, 28), at(0, 22), at(0, 22.1)]
    state, pedestrian, _ = matched(make_dataset(truth, x), lateral=True)
    assert pedestrian == [1, -1, 0, -1]
    assert state == [MATCHED, FALSE_ALARM, MATCHED, FALSE_ALARM]


def test_lateral_distances_leave_out_what_is_no_member() -> None:
    truth = [at(0, 20), at(0, 90), at(0, 41, ignore=True)]
    x = [at(0, 40), at(0, 21, score=-1)]
    assert nearest(make_dataset(truth, x)) == ([20, 50, np.inf], [20, np.inf])


def test_the_nearest_counts_in_whatever_order_they_come() -> None:
    for places in ([24, 40], [40, 24]):
        near, _ = nearest(make_dataset([at(0, 20)], [at(0, c) for c in places]))
        assert near == [4]


def test_ground_distance_is_between_foot_points() -> None:
    dataset = make_dataset([at(0, 20, foot=90)], [at(0, 23, foot=94, h=10)])
    assert nearest(dataset, ground=True) == ([5], [5])


def test_an_empty_set_is_infinitely_far() -> None:
    assert nearest(make_dataset(truth=[at(0, 20)])) == ([np.inf], [])
    assert nearest(make_dataset(x=[at(0, 20)])) == ([], [np.inf])


def test_the_border_holds_where_the_other_set_is_far() -> None:
    dataset = make_dataset([at(0, 10), at(1, 50), at(2, 90)])
    assert maximin(dataset, [np.inf] * 3, [1, 1, 1]) == ([10, 50, 10], [0, 1, 2])
    assert maximin(dataset, [np.inf] * 3, [1, 1, 1], edge_weight=1)[0] == [50, 50, 50]
    assert maximin(dataset, [np.inf] * 3, [1, 1, 1], edge_weight=0.5)[0] == [30, 50, 30]


def test_an_empty_set_has_distance_0_and_nobody_at_whom_it_stands() -> None:
    dataset = make_dataset([at(0, 10, ignore=True)], n_frames=2)
    assert maximin(dataset, [np.inf], [1]) == ([0, 0], [-1, -1])


def test_ties_of_the_maximum_go_to_the_larger_weight() -> None:
    dataset = make_dataset([at(0, 20, track=1), at(0, 40, track=2), at(0, 60, track=3)])
    assert maximin(dataset, [10, 5, 10], [0.5, 1, 0.4]) == ([5], [1])


def test_ties_of_weight_go_to_the_smaller_track() -> None:
    dataset = make_dataset([at(0, 20, track=3), at(0, 40, track=2), at(0, 60, track=9)])
    assert maximin(dataset, [5, 5, 5], [1, 1, 1]) == ([5], [1])


@pytest.mark.parametrize("edge_weight", [0.0, 0.3, 1.0])
def test_the_bare_maximum_is_that_of_the_maximin(edge_weight: float) -> None:
    rng = np.random.default_rng(3)
    boxes = [at(f, c, ignore=c > 70) for f in range(30) for c in rng.uniform(0, 100, f % 4)]
    dataset = make_dataset(boxes, n_frames=31)
    a, frames = dataset.truth, dataset.frame_columns
    near, k = rng.uniform(0, 60, len(a)), rng.uniform(0, 1, len(a))
    d = np.empty(len(frames))
    maximum_frames(
        0, len(frames), a.offsets, a.x, a.w, k, near, ~a.ignore, edge_weight, frames.recording,
        frames.width, d,
    )  # fmt: skip
    assert d.tolist() == maximin(dataset, near.tolist(), k.tolist(), edge_weight=edge_weight)[0]


def test_an_encounter_is_measured_in_frame_numbers() -> None:
    listed = [0, 2, 4, 6, 8, 10, 12]
    dataset = make_dataset([at(f, 50, track=1) for f in listed], frames=listed)
    hits = [False, True, False, False, True, True, False]
    assert judged(dataset, [0.5] * 7, hits) == [7, 3, 0.5, 2, 4, 2]


def test_frames_below_half_weight_are_not_relevant() -> None:
    dataset = make_dataset([at(f, 50, track=1) for f in range(4)])
    assert judged(dataset, [0.4, 0.5, 0.9, 0.49], [True, False, True, False])[:4] == [2, 1, 0.9, 1]


def test_an_encounter_never_matched_has_no_lag_gap_or_tail() -> None:
    dataset = make_dataset([at(0, 50, track=1)])
    figures = judged(dataset, [1], [False])
    assert figures[:3] == [1, 0, 1]
    assert np.isnan(figures[3:]).all()


def test_a_track_given_twice_in_a_frame_counts_once_and_is_matched_by_either_box() -> None:
    dataset = make_dataset([at(0, 50, track=1), at(0, 52, track=1), at(1, 50, track=1)])
    assert judged(dataset, [1, 0.5, 1], [False, True, False]) == [2, 1, 1, 0, 0, 1]


def test_rows_are_grouped_in_their_order_and_those_of_no_group_left_out() -> None:
    code = np.array([1, 0, -1, 1, 0])
    assert group_rows(code, np.array([2, 2]))[:4].tolist() == [1, 4, 0, 3]


def test_pairs_are_made_by_descending_iou() -> None:
    x = [Box(0, 0, 0, 10, 10), Box(0, 3, 0, 10, 10)]
    y = [Box(0, 2, 0, 10, 10), Box(0, 60, 0, 10, 10)]
    assert paired(make_dataset(x=x, y=y)) == [-1, 0]


def test_a_detection_is_in_one_pair_at_most() -> None:
    x = [Box(0, 0, 0, 10, 10), Box(0, 1, 0, 10, 10)]
    y = [Box(0, 0, 0, 10, 10), Box(0, 2, 0, 10, 10), Box(0, 3, 0, 10, 10)]
    assert paired(make_dataset(x=x, y=y)) == [0, 1]


def test_what_is_left_out_is_not_paired() -> None:
    x = [Box(0, 0, 0, 10, 10, score=-1), Box(0, 1, 0, 10, 10)]
    y = [Box(0, 1, 0, 10, 10, score=-1), Box(0, 3, 0, 10, 10)]
    assert paired(make_dataset(x=x, y=y)) == [-1, 1]


def test_more_than_sixteen_boxes_a_frame_are_paired() -> None:
    boxes = [Box(f, 20 * i, 0, 10, 10) for f in range(2) for i in range(30)]
    assert paired(make_dataset(x=boxes, y=boxes)) == list(range(60))


def spans(lo: int, hi: int, n: int) -> tuple[int, int, int]:
    return lo, hi, n


def test_few_frames_run_in_one_piece() -> None:
    assert over_ranges(spans, 1000, 7) == [(0, 1000, 7)]


def test_many_frames_run_in_as_many_pieces_as_there_are_cores(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(kernels, "MIN_PER_THREAD", 2)
    monkeypatch.setattr(kernels.os, "cpu_count", lambda: 3)
    assert over_ranges(spans, 7, 0) == [(0, 2, 0), (2, 4, 0), (4, 7, 0)]
    assert over_ranges(spans, 4, 0) == [(0, 2, 0), (2, 4, 0)]


def test_an_unknown_number_of_cores_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "MIN_PER_THREAD", 1)
    monkeypatch.setattr(kernels.os, "cpu_count", lambda: None)
    assert over_ranges(spans, 5, 0) == [(0, 5, 0)]


def test_matching_in_several_pieces_gives_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = [Box(f, 10 * (f % 3), 0, 10, 10, 1, NAN, f % 5 == 0) for f in range(20)]
    x = [Box(f, 10.0 * (f % 2) + i, 0, 10, 10, score=i) for f in range(20) for i in range(3)]
    dataset = make_dataset(truth, x, places=[Place(range(20))])
    whole = matched(dataset)
    monkeypatch.setattr(kernels, "MIN_PER_THREAD", 1)
    monkeypatch.setattr(kernels.os, "cpu_count", lambda: 7)
    assert matched(dataset) == whole
