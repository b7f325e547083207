"""Mistakes of other evaluation tools that must not happen here.

What can only go wrong while reading a file is tested with the readers; curves and the areas under
them have a module of their own beside their tests.
"""

from __future__ import annotations

import pytest
from builders import Box, at, make_dataset, result_of

from nvcore.tables.result import frames_table


def perfect(n: int = 200) -> list[Box]:
    return [at(f, 50, track=1) for f in range(n)]


def test_pedestrians_in_frames_without_detections_are_missed() -> None:
    # a detector silent on half of 200 frames had recall 1.0
    result = result_of(make_dataset(perfect(), [at(f, 50) for f in range(0, 200, 2)]))
    assert result.boxes.x_only == 100
    assert result.boxes.neither == 100
    assert result.x.encounters["coverage"].tolist() == [0.5]
    assert result.x.summary.mean == pytest.approx((100 * 1 + 100 * 0.1) / 200)


@pytest.mark.parametrize("empty", [0, 1, 2])
def test_the_place_of_an_empty_frame_does_not_matter(empty: int) -> None:
    # the result depended on the order of empty pictures
    full = [f for f in range(3) if f != empty]
    x = result_of(make_dataset([at(f, 50, track=1) for f in full], [at(full[0], 50)], n_frames=3)).x
    assert sorted(x.similarity) == pytest.approx([0.1, 1, 1])
    assert x.false_alarm_summary.count == 0


def test_minus_one_never_reads_the_last_element() -> None:
    # index -1 of "nothing found" read the end of the curve
    table = frames_table(result_of(make_dataset([at(2, 50, track=7)], n_frames=3)))
    assert table["salient_track_x"].isna().tolist() == [True, True, False]
    result = result_of(make_dataset([at(0, 50, track=7)], [at(0, 20)], [at(0, 50)]))
    assert result.x.matches.det_truth.tolist() == [-1]
    assert result.x.encounters["matched"].tolist() == [0]


def test_track_0_in_row_0_matched_by_row_0_is_matched() -> None:
    # id 0 meant "unmatched"
    result = result_of(make_dataset([at(0, 50, track=0)], [at(0, 50)], [at(0, 50)]))
    assert result.x.matches.truth_det.tolist() == [0]
    assert result.encounters.track.tolist() == [0]
    assert result.venn.both == 1
    missed = result_of(make_dataset([at(0, 50, track=0)]))
    assert missed.x.events["track"].tolist() == [0]


def test_boxes_reach_from_x_to_x_plus_w_without_another_pixel() -> None:
    # inclusive pixels turned an IoU of 0.494 into one of 0.512
    # 8 px of 10 across and 8 of 10 down: 64 / 136 = 0.47; inclusive 81 / 161 = 0.503
    dataset = make_dataset([(0, 0, 0, 10, 10, 1)], [(0, 2, 2, 10, 10)])
    assert not result_of(dataset).x.matches.is_matched.any()
    assert result_of(dataset, iou=0.47).x.matches.is_matched.all()
