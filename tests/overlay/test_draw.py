"""What is drawn, pixel by pixel: colours, dashes, marks of misses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nvcore.dataset.schema import DetectionState, TruthState
from nvcore.figures.overlay import DrawnDetections, DrawnTruth, TruthMark, draw_boxes
from nvcore.figures.overlay.brush import BLANK_RGB, ON_LIGHT, TRUTH_RGB, X_RGB, Y_RGB, drawable
from nvcore.figures.overlay.draw import canvas_size

BOX = (400.0, 300.0, 100.0, 200.0)
MATCHED, MISSED, NOT_JUDGED = TruthState.MATCHED, TruthState.MISSED, TruthState.NOT_JUDGED


def pedestrian(
    x: TruthState = MATCHED,
    y: TruthState = MATCHED,
    *,
    box: tuple[float, ...] = BOX,
    is_relevant: bool = True,
    is_salient_x: bool = False,
) -> DrawnTruth:
    mark = TruthMark(x, y, is_relevant=is_relevant, is_salient_x=is_salient_x)
    return DrawnTruth(np.array([box]), [mark])


def detection(
    state: DetectionState = DetectionState.MATCHED, *, box: tuple[float, ...] = BOX, label: str = ""
) -> DrawnDetections:
    return DrawnDetections(np.array([box]), np.array([state], np.int8), [label] if label else [])


def count(canvas: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int(np.all(np.abs(canvas.astype(int) - colour) < 12, axis=2).sum())


def drawn(**given: Any) -> np.ndarray:
    return draw_boxes(None, 960, 720, **given)


def test_without_a_picture_the_boxes_are_on_a_dark_blank():
    canvas = drawn()
    assert canvas.shape == (720, 960, 3)
    assert count(canvas, BLANK_RGB) == 720 * 960


def test_truth_is_thin_x_twice_as_thick_and_y_dashed():
    truth = count(drawn(truth=pedestrian()), TRUTH_RGB)
    x, y = count(drawn(x=detection()), X_RGB), count(drawn(y=detection()), Y_RGB)
    assert truth == 2 * (100 + 200) - 4
    assert 1.9 * truth < x < 3.1 * truth
    assert 0.4 * x < y < 0.8 * x


def test_boxes_stand_where_they_should():
    canvas = drawn(x=detection())
    rows, columns = np.nonzero(np.any(canvas != BLANK_RGB, axis=2))
    assert (rows.min(), rows.max()) == (pytest.approx(299, abs=2), pytest.approx(500, abs=2))
    assert (columns.min(), columns.max()) == (pytest.approx(399, abs=2), pytest.approx(500, abs=2))


@pytest.mark.parametrize("x", [MATCHED, MISSED])
@pytest.mark.parametrize("y", [MATCHED, MISSED])
def test_a_miss_is_marked_in_the_colour_of_who_misses(x: TruthState, y: TruthState):
    canvas = drawn(truth=pedestrian(x, y))
    marks = (count(canvas, X_RGB), count(canvas, Y_RGB))
    for n_marked, state in zip(marks, (x, y), strict=True):
        assert n_marked > 100 if state == MISSED else n_marked == 0


def test_missed_by_both_is_marked_left_for_x_and_right_for_y():
    canvas = drawn(truth=pedestrian(MISSED, MISSED))[310:490]
    left, right = canvas[:, :450], canvas[:, 450:]
    assert count(left, X_RGB) > 50
    assert count(right, Y_RGB) > 50
    assert count(left, Y_RGB) == count(right, X_RGB) == 0


def test_a_distant_miss_is_marked_less_than_a_relevant_one():
    distant, relevant = (
        count(drawn(truth=pedestrian(MISSED, is_relevant=is_relevant)), X_RGB)
        for is_relevant in (False, True)
    )
    assert 0 < distant < relevant / 3


def test_the_most_salient_miss_has_a_longer_mark():
    plain = drawn(truth=pedestrian(MISSED))
    salient = drawn(truth=pedestrian(MISSED, is_salient_x=True))
    assert np.any(plain != salient)


def test_an_ignore_region_is_dotted_and_never_a_miss():
    canvas = drawn(truth=pedestrian(NOT_JUDGED, NOT_JUDGED, is_relevant=False))
    assert count(canvas, X_RGB) == count(canvas, Y_RGB) == 0
    assert 0 < count(canvas, TRUTH_RGB) < count(drawn(truth=pedestrian()), TRUTH_RGB)


def test_a_false_alarm_is_crossed():
    middle = (slice(380, 420), slice(430, 470))
    assert count(drawn(x=detection())[middle], X_RGB) == 0
    assert count(drawn(x=detection(DetectionState.FALSE_ALARM))[middle], X_RGB) > 10


def test_a_label_is_written_beside_its_box():
    plain, labelled = drawn(x=detection()), drawn(x=detection(label="0.93"))
    rows, columns = np.nonzero(np.any(plain != labelled, axis=2))
    assert columns.max() < 400
    assert rows.min() > 280


def test_a_picture_of_another_size_is_scaled_to_the_recording():
    picture = np.zeros((72, 96), np.uint8)
    picture[:, 48:] = 200
    canvas = draw_boxes(picture, 960, 720, x=detection())
    assert canvas.shape == (720, 960, 3)
    assert canvas[100, 900].tolist() == [200, 200, 200]
    assert canvas[400, 400].tolist() != [0, 0, 0]


def test_the_picture_itself_is_not_drawn_on():
    picture = np.zeros((720, 960, 3), np.uint8)
    draw_boxes(picture, 960, 720, x=detection())
    assert not picture.any()


@pytest.mark.parametrize(
    ("size", "expected"),
    [
        ((640, 480), (1280, 960)),
        ((1242, 375), (1242, 376)),
        ((3840, 2160), (1920, 1080)),
        ((1, 1), (8, 8)),
        ((1241, 375), (1240, 376)),
    ],
)
def test_drawings_are_large_enough_and_of_even_size(size: tuple, expected: tuple):
    assert canvas_size(*size) == expected


@pytest.mark.parametrize(
    "box", [(-1e9, -1e9, 2e9, 2e9), (1e12, 5, 10, 10), (5, 5, 0, 0), (-50, 700, 100, 100)]
)
def test_boxes_far_outside_or_without_area_do_no_harm(box: tuple[float, ...]):
    canvas = drawn(
        truth=pedestrian(MISSED, MISSED, box=box),
        x=detection(DetectionState.FALSE_ALARM, box=box),
        y=detection(box=box),
    )
    assert canvas.shape == (720, 960, 3)


@pytest.mark.parametrize(
    ("text", "expected"), [("Straße 7 – Ö", "Strasse 7 - O"), ("夜\n", "??"), ("a_b", "a_b")]
)
def test_names_are_drawn_in_the_signs_that_the_font_has(text: str, expected: str):
    assert drawable(text) == expected


def test_on_a_light_ground_everything_has_its_darker_colour():
    canvas = drawn(
        truth=pedestrian(MISSED, MISSED), x=detection(DetectionState.FALSE_ALARM), inks=ON_LIGHT
    )
    assert tuple(canvas[5, 5]) == ON_LIGHT.ground
    assert min(count(canvas, colour) for colour in (ON_LIGHT.x, ON_LIGHT.y, ON_LIGHT.truth)) > 50
    assert count(canvas, X_RGB) == count(canvas, Y_RGB) == 0


def test_lines_and_labels_grow_with_the_unit():
    thin, thick = (count(drawn(truth=pedestrian(), unit=unit), TRUTH_RGB) for unit in (1, 3))
    assert thick > 2.5 * thin
    pairs = [[drawn(x=detection(label=text), unit=u) for text in ("0.50", "")] for u in (1, 3)]
    small, large = (np.any(labelled != plain, axis=2).sum() for labelled, plain in pairs)
    assert large > 4 * small > 0  # an area


@pytest.mark.parametrize("grey", [0, 110, 255])
def test_a_label_is_legible_on_any_picture(grey: int):
    picture = np.full((720, 960), grey, np.uint8)
    named, plain = (
        draw_boxes(picture, 960, 720, x=detection(label=label), unit=2) for label in ("0.50", "")
    )
    label = named[np.any(named != plain, axis=2)].astype(float).mean(axis=1)
    assert np.percentile(label, 20) < 70  # its own ground
    assert label.max() - np.percentile(label, 20) > 100
