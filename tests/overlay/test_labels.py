"""Where labels of drawn frames stand."""

from __future__ import annotations

import numpy as np
import pytest

from nvcore.dataset.schema import DetectionState, TruthState
from nvcore.figures.overlay import DrawnDetections, DrawnTruth, TruthMark, draw_boxes
from nvcore.figures.overlay.labels import LabelRoom, overlap, tag_places

SIZE = (40.0, 15.0)
LABEL_WIDTH, LABEL_HEIGHT = SIZE
CROWD = np.array([[300.0 + 22 * i, 300, 20, 60] for i in range(12)])


MISSED_BY_Y = TruthMark(TruthState.MATCHED, TruthState.MISSED, is_relevant=True)
MATCHED = TruthMark(TruthState.MATCHED, TruthState.MATCHED, is_relevant=True)


def pedestrians(xywh: np.ndarray, mark: TruthMark, labels: list[str]) -> DrawnTruth:
    return DrawnTruth(xywh, [mark] * len(xywh), labels)


def matched_detections(xywh: np.ndarray, labels: list[str]) -> DrawnDetections:
    return DrawnDetections(xywh, np.full(len(xywh), DetectionState.MATCHED, np.int8), labels)


def changed(picture: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Where two drawings differ."""
    return np.any(picture != other, axis=2)


def test_the_first_free_place_is_taken():
    room = LabelRoom(200, 100)
    assert room.take(SIZE, [(10, 10), (60, 10)]) == (10, 10, 50, 25)
    assert room.take(SIZE, [(10, 10), (60, 10)]) == (60, 10, 100, 25)
    assert room.take(SIZE, [(10, 10), (60, 10)]) is None


@pytest.mark.parametrize("place", [(-1, 10), (161, 10), (10, -1), (10, 86)])
def test_a_label_never_hangs_over_the_picture_s_edge(place: tuple[float, float]):
    assert LabelRoom(200, 100).take(SIZE, [place]) is None
    left, top, right, bottom = LabelRoom(200, 100).must_take(SIZE, [place])
    assert 0 <= left < right <= 200
    assert 0 <= top < bottom <= 100


def test_a_missed_pedestrian_is_not_covered_but_labelled_even_without_room():
    missed = (50.0, 0.0, 90.0, 100.0)
    room = LabelRoom(200, 100, [missed])
    assert room.take(SIZE, [(60, 40)]) is None
    assert room.must_take(SIZE, [(60, 40), (88, 40)]) == (88, 40, 128, 55)


def test_the_tags_of_a_crowd_lie_beside_each_other():
    crowd = [(300 + 22 * i, 300, 320 + 22 * i, 360) for i in range(8)]
    room = LabelRoom(960, 720, crowd)
    tags = [room.must_take(SIZE, tag_places(box, SIZE)) for box in crowd]
    shared = [overlap(tag, other) for i, tag in enumerate(tags) for other in [*crowd, *tags[:i]]]
    assert max(shared) == 0


def test_in_a_crowd_every_missed_one_keeps_its_label_and_nobody_is_covered():
    names = [str(100 + i) for i in range(len(CROWD))]
    bare = draw_boxes(None, 960, 720, truth=pedestrians(CROWD[:0], MISSED_BY_Y, []))
    drawn = draw_boxes(None, 960, 720, truth=pedestrians(CROWD, MISSED_BY_Y, names))
    unnamed = draw_boxes(None, 960, 720, truth=pedestrians(CROWD, MISSED_BY_Y, []))
    tags = changed(drawn, unnamed)
    assert tags.any()
    assert not tags[297:363, 297:565].any()  # from the first box to the last
    least = LABEL_HEIGHT * 15 * len(names)  # at least the fields that say who misses
    outside = changed(drawn, bare)
    outside[290:370, 290:570] = False
    assert outside.sum() >= least


def test_labels_of_matched_boxes_are_left_out_where_there_is_no_room():
    single = draw_boxes(None, 960, 720, truth=pedestrians(CROWD[:1], MATCHED, ["123"]))
    same = np.repeat(CROWD[:1], 30, axis=0)
    many = draw_boxes(None, 960, 720, truth=pedestrians(same, MATCHED, ["123"] * 30))
    plain = draw_boxes(None, 960, 720, truth=pedestrians(CROWD[:1], MATCHED, []))
    assert changed(single, plain).any()
    assert changed(many, plain).sum() <= 4 * changed(single, plain).sum()


def test_a_score_at_the_left_edge_is_written_inside_the_picture():
    at_edge = np.array([[2.0, 300, 30, 80]])
    plain = draw_boxes(None, 960, 720, y=matched_detections(at_edge, []))
    named = draw_boxes(None, 960, 720, y=matched_detections(at_edge, ["0.01"]))
    columns = np.nonzero(changed(plain, named).any(axis=0))[0]
    assert columns.min() > 33  # on the right of the box, whole
