"""Boxes before and after suppression, score maps, running confidence, trees, training."""

from __future__ import annotations

import numpy as np
import pytest
from figure_parts import shape, trace, words

from nvcore.detectors.base import Detections
from nvcore.detectors.figures import (
    boxes_plot,
    confidence_plot,
    pictures_plot,
    score_map_plot,
    traces_plot,
    training_plot,
    tree_plot,
)
from nvcore.detectors.icf.detector import ScoreMap
from nvcore.detectors.icf.displays import MOST_CELLS, CoarseMap, Node, Tree, WindowPath, coarse_map
from nvcore.detectors.icf.pyramid import PyramidLevel
from nvcore.detectors.icf.settings import IcfSettings
from nvcore.figures.style import LOOK, faded
from nvcore.palette import Scheme
from nvcore.schema import DetectionState

GREY = np.full((60, 80), 90, np.uint8)
BOXES = Detections(
    x=np.array([10.0, 12.0, 50.0]),
    y=np.array([5.0, 5.0, 20.0]),
    w=np.array([10.0, 10.0, 8.0]),
    h=np.array([20.0, 20.0, 16.0]),
    score=np.array([0.9, 0.5, 0.1]),
)
NODE = Node("gradient", 2, 4, 8, 10, None, 0.25)
TREE = Tree(NODE, Node("U", 0, 0, 4, 8, ("V", 12, 0, 16, 8), -0.1), NODE, (-0.5, 0.1, 0.2, 1.5))


def test_boxes_that_count_and_those_that_went_are_told_apart():
    counts = np.array([True, False, False])
    figure = boxes_plot(GREY, BOXES, counts, theme="light", threshold=0.4, truth=np.zeros((2, 4)))
    assert trace(figure, "detected").x[:4].tolist() == [10, 20, 20, 10]
    assert trace(figure, "suppressed boxes").x[:2].tolist() == [12, 22]
    assert trace(figure, "counting").customdata.tolist() == [0]
    assert trace(figure, "gone").customdata.tolist() == [1]  # the third is below
    assert "2 boxes before suppression, 1 after; the truth has 2" in words(figure)
    assert trace(figure, "detected").line.color == LOOK["dark"].y
    assert figure.layout.images[0].source.startswith("data:image/jpeg;base64,")


def test_it_is_said_what_the_boxes_are_in_a_comparison():
    states = np.array([DetectionState.MATCHED, DetectionState.FALSE_ALARM, DetectionState.ABSORBED])
    truth = np.array([[10.0, 5, 10, 40], [40, 5, 4, 4], [60, 5, 4, 4]])
    figure = boxes_plot(
        GREY, BOXES, np.ones(3, bool), theme="light", threshold=0, truth=truth,
        ignored=np.array([[50.0, 20, 20, 20]]), states=states.astype(np.int8),
    )  # fmt: skip
    assert "3 after: 1 matched, 1 false, 1 on ignored truth; the truth has 3, 2 missed" in words(
        figure
    )
    assert trace(figure, "counting").text[:2] == (
        "score 0.9, 10 × 20 px, IoU with the truth 0.50: matched",
        "score 0.5, 10 × 20 px, IoU with the truth 0.36: a false alarm",  # 160 of 440
    )
    assert trace(figure, "truth").x[:2].tolist() == [10, 20]
    assert trace(figure, "ignored").x[:2].tolist() == [50, 70]


def test_chosen_detected_and_suppressed_boxes_can_be_told_apart():
    figure = boxes_plot(
        GREY, BOXES, np.array([True, False, False]), theme=Scheme("light", 0, 2), threshold=0.4,
        truth=np.zeros((1, 4)), chosen=0,
    )  # fmt: skip
    chosen, truth, detected = (trace(figure, name) for name in ("chosen", "truth", "detected"))
    assert len({part.line.color for part in (chosen, truth, detected)}) == 3
    assert chosen.fill == "toself"  # not by its colour alone
    assert detected.line.dash is None  # long dashes leave a corner of a small box
    assert trace(figure, "counting").marker.size[0] == 8
    swatch = trace(figure, "suppressed")
    assert swatch.showlegend
    assert swatch.line.color == faded(LOOK[Scheme("dark", 0, 2)].y, 0.7)
    assert not trace(figure, "suppressed boxes").showlegend


def test_boxes_are_drawn_in_pixels_of_the_recording():
    figure = boxes_plot(
        GREY, BOXES, np.ones(3, bool), theme="dark", threshold=0, size=(160.0, 60.0), chosen=2
    )
    assert trace(figure, "chosen").x[:2].tolist() == [100, 116]
    assert tuple(figure.layout.xaxis.range) == (0, 160)
    assert tuple(figure.layout.yaxis.range) == (60, 0)


def test_no_box_is_no_error():
    none = Detections(*np.empty((5, 0)))
    figure = boxes_plot(GREY, none, np.empty(0, bool), theme="light", threshold=0)
    assert "0 boxes before suppression, 0 after" in words(figure)


def of_scale(score: np.ndarray, depth: np.ndarray) -> CoarseMap:
    return coarse_map(ScoreMap(PyramidLevel(2.0, 40, 30, 2.0, 2.0), score, depth))


def test_a_window_stands_at_its_middle_in_the_picture():
    settings = IcfSettings(window_width=16, window_height=24, stride=4, least_area=4,
                           object_width=10, object_height=20)  # fmt: skip
    score = np.array([[np.nan, 1.5, np.nan]])
    depth = np.array([[3, 100, 0]], np.int32)
    figure = score_map_plot(of_scale(score, depth), settings, GREY, theme="light")
    (heat,) = figure.data
    assert heat.x.tolist() == [16, 24, 32]
    assert heat.y.tolist() == [24]
    np.testing.assert_allclose(heat.z[0], [np.log10(3), 2, np.nan])
    assert "scale 2: 2 windows of 32 × 48 px, 1 came through" in words(figure)
    confident = score_map_plot(of_scale(score, depth), settings, GREY, theme="dark",
                               of="confidence")  # fmt: skip
    np.testing.assert_allclose(confident.data[0].z[0], [np.nan, 1.5, np.nan])


def test_of_many_windows_the_highest_of_several_is_shown():
    depth = np.ones((3, 2 * MOST_CELLS + 1), np.int32)
    depth[2, 7] = 1000
    figure = score_map_plot(
        of_scale(np.full(depth.shape, np.nan), depth), IcfSettings(), GREY, theme="light"
    )
    assert figure.data[0].z.shape == (1, 134)
    assert figure.data[0].z[0, 2] == 3


def test_the_line_of_a_rejected_window_goes_on_dotted():
    path = WindowPath(
        np.array([0.5, -1.0, -1.5]), np.array([-0.5, -0.6, -0.7]), 2, np.zeros(3, int)
    )
    figure = confidence_plot(path, theme="light")
    assert trace(figure, "this window").x.tolist() == [1, 2]
    assert trace(figure, "had it not been rejected").x.tolist() == [2, 3]
    assert trace(figure, "rejected below").y.tolist() == [-0.5, -0.6, -0.7]
    assert trace(figure, "rejected").x == (2,)
    assert "rejected after 2 of 3 trees" in words(figure)


@pytest.mark.parametrize("floor", [[-np.inf, -np.inf], [-np.inf, -3.0]])
def test_a_window_that_comes_through_ends_with_its_confidence(floor: list[float]):
    path = WindowPath(np.array([0.5, 2.25]), np.array(floor), None, np.zeros(2, int))
    figure = confidence_plot(path, theme="dark")
    assert "came through all 2 trees with 2.25" in words(figure)
    assert ("least sum of a stage by itself" in words(figure)) == np.isfinite(floor).any()


def test_traces_end_where_their_windows_are_rejected():
    floor, leaf = np.array([-0.5, -0.6, -0.7]), np.zeros(3, int)
    through = WindowPath(np.array([0.5, 1.0, 1.5]), floor, None, leaf)
    rejected = WindowPath(np.array([0.1, -1.0, -1.5]), floor, 2, leaf)
    figure = traces_plot([through, through], [rejected], theme="light")
    np.testing.assert_array_equal(trace(figure, "objects").x, [1, 2, 3, np.nan, 1, 2, 3, np.nan])
    np.testing.assert_array_equal(trace(figure, "background").y, [0.1, -1.0, np.nan])
    assert trace(figure, "background, rejected").x == (2,)
    assert trace(figure, "rejected below").y.tolist() == floor.tolist()
    assert "2 of 2 objects came through; 1 window of background rejected" in words(figure)
    assert "0 of 0 objects" in words(traces_plot([], [], theme="dark"))


def test_each_round_of_training_begins_anew():
    figure = training_plot(np.array([0.3, 0.2, 0.5, 0.4, 0.1]), np.array([2, 5]), theme="light")
    assert trace(figure, "round 1: 2 trees").y.tolist() == [0.3, 0.2]
    assert trace(figure, "round 2: 3 trees").x.tolist() == [1, 2, 3]


def test_a_tree_shows_its_questions_and_the_way_of_the_window():
    figure = tree_plot(TREE, theme="light", window=(16, 32), number=7, leaf=1)
    assert "Tree 7" in words(figure)
    assert "mean of gradient over 6 × 6 px 0.250?" in words(figure)
    assert "mean of U minus that of V (dotted), 4 × 8 px −0.100?" in words(figure)
    assert "<b>+0.100</b>" in words(figure)
    thick = [part for part in figure.data if part.line.width == 3]
    assert [part.name for part in thick] == ["below", "at least"]
    box, window = shape(figure, "subtracted"), figure.layout.shapes
    assert box.line.dash == "dot"
    assert [part.name for part in window].count("window") == 3


def test_pictures_stand_side_by_side_below_their_names():
    figure = pictures_plot(dict.fromkeys("abc", GREY), theme="light", title="Channels",
                           columns=2)  # fmt: skip
    lefts = [image.x for image in figure.layout.images]
    assert lefts[0] == lefts[2] == 0 < lefts[1]
    assert [text.text for text in figure.layout.annotations] == ["a", "b", "c"]
