"""Mistakes of other evaluation tools that must not happen here.

The numbers are those of the project's list of peers' bugs, section "Correctness bugs of metrics".
What can only go wrong while reading a file is tested with the readers, curves and areas under them
in test_peer_bugs_curves.py; what concerns classes (45) has no counterpart here.
"""

from __future__ import annotations

import numpy as np
import pytest
from builders import Box, at, make_dataset, result_of

from nvcore.tables.result import frames_table


def perfect(n: int = 200) -> list[Box]:
    return [at(f, 50, track=1) for f in range(n)]


def test_pedestrians_in_frames_without_detections_are_missed() -> None:
    # 29: a detector silent on half of 200 frames had recall 1.0
    result = result_of(make_dataset(perfect(), [at(f, 50) for f in range(0, 200, 2)]))
    assert result.boxes.x_only == 100
    assert result.boxes.neither == 100
    assert result.x.encounters["coverage"].tolist() == [0.5]
    assert result.x.summary.mean == pytest.approx((100 * 1 + 100 * 0.1) / 200)


@pytest.mark.parametrize("empty", [0, 1, 2])
def test_the_place_of_an_empty_frame_does_not_matter(empty: int) -> None:
    # 30: the result depended on the order of empty pictures
    full = [f for f in range(3) if f != empty]
    x = result_of(make_dataset([at(f, 50, track=1) for f in full], [at(full[0], 50)], n_frames=3)).x
    assert sorted(x.similarity) == pytest.approx([0.1, 1, 1])
    assert x.false_alarm_summary.count == 0


def test_minus_one_never_reads_the_last_element() -> None:
    # 31: index -1 of "nothing found" read the end of the curve
    table = frames_table(result_of(make_dataset([at(2, 50, track=7)], n_frames=3)))
    assert table["salient_track_x"].isna().tolist() == [True, True, False]
    result = result_of(make_dataset([at(0, 50, track=7)], [at(0, 20)], [at(0, 50)]))
    assert result.x.matches.det_truth.tolist() == [-1]
    assert result.x.encounters["matched"].tolist() == [0]


def test_track_0_in_row_0_matched_by_row_0_is_matched() -> None:
    # 34: id 0 meant "unmatched"
    result = result_of(make_dataset([at(0, 50, track=0)], [at(0, 50)], [at(0, 50)]))
    assert result.x.matches.truth_det.tolist() == [0]
    assert result.encounters.track.tolist() == [0]
    assert result.venn.both == 1
    missed = result_of(make_dataset([at(0, 50, track=0)]))
    assert missed.x.events["track"].tolist() == [0]


def test_an_ignored_pedestrian_is_no_miss() -> None:
    # 35: ignore flags were overwritten, and what they marked counted as missed
    result = result_of(make_dataset([at(0, 50, track=1, ignore=True)]))
    assert result.x.similarity.tolist() == [1]
    assert result.boxes.neither == 0
    assert result.venn.n_near == 0


def test_both_systems_are_measured_on_the_same_pedestrians() -> None:
    # 37: the number of pedestrians depended on the system
    truth = [*perfect(4), *(Box(f, 60, 0, 40, 40, ignore=True) for f in range(4))]
    x = [at(f, 50) for f in range(4)]
    y = [Box(f, 60 + 8 * i, 5, 10, 10) for f in range(4) for i in range(4)]  # all on the region
    result = result_of(make_dataset(truth, x, y))
    n_relevant = [one.encounters["n_relevant"].tolist() for one in (result.x, result.y)]
    assert n_relevant == [[4], [4]]
    assert result.boxes.both + result.boxes.x_only == 4
    assert result.y.n_det.sum() == 0


def test_what_is_undefined_without_truth_is_nan_not_1() -> None:
    # 38: no pedestrian and false alarms gave a perfect score, or -1 that was averaged in
    result = result_of(make_dataset(x=[at(0, 50)]))
    assert result.x.summary.mean == pytest.approx(0.9)
    assert np.isnan([result.exclusivity.jaccard, result.exclusivity.phi]).all()


def test_frames_without_any_box_are_counted() -> None:
    # 41: frames without any event were left out of the mean
    x = result_of(make_dataset([at(0, 50, track=1)], n_frames=10)).x
    assert x.summary.mean == pytest.approx((0.1 + 9) / 10)
    assert x.false_alarm_summary.per_frame == 0


def test_boxes_reach_from_x_to_x_plus_w_without_another_pixel() -> None:
    # 43: inclusive pixels turned an IoU of 0.494 into one of 0.512
    # 8 px of 10 across and 8 of 10 down: 64 / 136 = 0.47; inclusive 81 / 161 = 0.503
    dataset = make_dataset([(0, 0, 0, 10, 10, 1)], [(0, 2, 2, 10, 10)])
    assert not result_of(dataset).x.matches.is_matched.any()
    assert result_of(dataset, iou=0.47).x.matches.is_matched.all()


def test_a_box_at_the_origin_has_its_centre_at_half_its_width() -> None:
    # 42: the same box lay at 0 or at 1, depending on the library
    result = result_of(make_dataset([(0, 0, 0, 100, 10, 1)], [(0, 40, 0, 20, 10)]), alpha=1.0)
    assert result.x.distances.d_miss.tolist() == [0]
