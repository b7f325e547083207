"""Boxes before and after suppression, score maps, running confidence, trees, training."""

from __future__ import annotations

import base64

import cv2
import numpy as np
import pytest
from figure_parts import shape, trace, words

from nvcore.common.palette import Scheme
from nvcore.dataset.schema import DetectionState
from nvcore.figures.style import LOOK, faded
from nvcore.subjects.detectors.base import Detections
from nvcore.subjects.detectors.figures import (
    boxes_plot,
    confidence_plot,
    pictures_plot,
    score_map_plot,
    traces_plot,
    training_plot,
    tree_plot,
)
from nvcore.subjects.detectors.icf.channels import PyramidLevel
from nvcore.subjects.detectors.icf.detector import ScoreMap
from nvcore.subjects.detectors.icf.displays import MOST_CELLS, Node, Tree, WindowPath, coarse_map
from nvcore.subjects.detectors.icf.settings import IcfSettings

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
FLOOR = np.array([-0.5, -0.6, -0.7])
REJECTED = WindowPath(np.array([0.5, -1.0, -1.5]), FLOOR, 2, np.zeros(3, int))


def drawn(is_counting=(True, True, True), **more):
    """The boxes of a frame; `more` replaces theme and threshold."""
    settings = {"theme": "light", "threshold": 0, **more}
    return boxes_plot(GREY, BOXES, np.array(is_counting), **settings)


def test_chosen_counting_and_suppressed_boxes_are_told_apart():
    theme, truth = Scheme("light", 0, 2), np.zeros((2, 4))
    figure = drawn((True, False, False), theme=theme, threshold=0.4, truth=truth, chosen=0)
    look = LOOK[Scheme("dark", 0, 2)]
    assert trace(figure, "detected").x[:4].tolist() == [10, 20, 20, 10]
    assert trace(figure, "detected").y[:4].tolist() == [5, 5, 25, 25]
    assert trace(figure, "suppressed boxes").x[:2].tolist() == [12, 22]
    assert trace(figure, "counting").customdata.tolist() == [0]
    assert (*trace(figure, "counting").x, *trace(figure, "counting").y) == (15, 15)  # its middle
    assert trace(figure, "gone").customdata.tolist() == [1]  # the third is below
    assert trace(figure, "gone").text[0].endswith(": suppressed")
    assert "2 boxes before suppression, 1 after; the truth has 2" in words(figure)
    assert figure.layout.images[0].source.startswith("data:image/jpeg;base64,")
    chosen, truth, detected = (trace(figure, name) for name in ("chosen", "truth", "detected"))
    assert len({part.line.color for part in (chosen, truth, detected)}) == 3
    assert detected.line.color == look.y
    assert chosen.fill == "toself"  # not by its colour alone
    assert detected.line.dash is None  # long dashes leave a corner of a small box
    assert trace(figure, "counting").marker.size[0] == 8
    swatch = trace(figure, "suppressed")
    assert swatch.showlegend
    assert swatch.line.color == faded(look.y, 0.7)
    assert not trace(figure, "suppressed boxes").showlegend


def test_it_is_said_what_the_boxes_are_in_a_comparison():
    states = np.array([DetectionState.MATCHED, DetectionState.FALSE_ALARM, DetectionState.ABSORBED])
    truth = np.array([[10.0, 5, 10, 40], [40, 5, 4, 4], [60, 5, 4, 4]])
    figure = drawn(truth=truth, ignored=np.array([[50.0, 20, 20, 20]]), states=states)
    text = "3 after: 1 matched, 1 false, 1 on ignored truth; the truth has 3, 2 missed"
    assert text in words(figure)
    assert trace(figure, "counting").text[:2] == (
        "score 0.9, 10 × 20 px, IoU with the truth 0.50: matched",
        "score 0.5, 10 × 20 px, IoU with the truth 0.36: a false alarm",  # 160 of 440
    )
    assert trace(figure, "truth").x[:2].tolist() == [10, 20]
    assert trace(figure, "ignored").x[:2].tolist() == [50, 70]


def test_boxes_are_drawn_in_pixels_of_the_recording():
    figure = drawn(size=(160.0, 60.0), chosen=2)
    assert trace(figure, "chosen").x[:2].tolist() == [100, 116]
    assert tuple(figure.layout.xaxis.range) == (0, 160)
    assert tuple(figure.layout.yaxis.range) == (60, 0)
    none = Detections(*np.empty((5, 0)))
    empty = boxes_plot(GREY, none, np.empty(0, bool), theme="light", threshold=0)
    assert "0 boxes before suppression, 0 after" in words(empty)


def test_a_window_stands_at_its_middle_in_the_picture():
    settings = IcfSettings(window_width=16, window_height=24, stride=4, least_area=4,
                           object_width=10, object_height=20)  # fmt: skip
    level = PyramidLevel(2.0, 40, 30, 2.0, 2.0)
    score, depth = np.array([[np.nan, 1.5, np.nan]]), np.array([[3, 100, 0]], np.int32)
    windows = coarse_map(ScoreMap(level, score, depth))
    (heat,) = (figure := score_map_plot(windows, settings, GREY, theme="light")).data
    assert heat.x.tolist() == [16, 24, 32]
    assert heat.y.tolist() == [24]
    np.testing.assert_allclose(heat.z[0], [np.log10(3), 2, np.nan])
    assert heat.colorscale[0][1].endswith(",0)")  # the picture is seen where no window got far
    assert "scale 2: 2 windows of 32 × 48 px, 1 came through" in words(figure)
    (heat,) = score_map_plot(windows, settings, GREY, theme="dark", of="confidence").data
    np.testing.assert_allclose(heat.z[0], [np.nan, 1.5, np.nan])

    depth = np.ones((3, 2 * MOST_CELLS + 1), np.int32)
    depth[2, 7] = 1000  # of many windows the highest of several is shown
    many = coarse_map(ScoreMap(level, np.full(depth.shape, np.nan), depth))
    (heat,) = score_map_plot(many, IcfSettings(), GREY, theme="light").data
    assert heat.z.shape == (1, 134)
    assert heat.z[0, 2] == 3


def test_the_line_of_a_rejected_window_goes_on_dotted():
    figure = confidence_plot(REJECTED, theme="light")
    assert trace(figure, "this window").x.tolist() == [1, 2]
    assert trace(figure, "had it not been rejected").x.tolist() == [2, 3]
    assert trace(figure, "rejected below").y.tolist() == FLOOR.tolist()
    assert trace(figure, "rejected").x == (2,)
    assert "rejected after 2 of 3 trees" in words(figure)


@pytest.mark.parametrize("floor", [[-np.inf, -np.inf], [-np.inf, -3.0]])
def test_a_window_that_comes_through_ends_with_its_confidence(floor: list[float]):
    path = WindowPath(np.array([0.5, 2.25]), np.array(floor), None, np.zeros(2, int))
    figure = confidence_plot(path, theme="dark")
    assert "came through all 2 trees with 2.25" in words(figure)
    assert ("least sum of a stage by itself" in words(figure)) == np.isfinite(floor).any()


def test_traces_end_where_their_windows_are_rejected():
    through = WindowPath(np.array([0.5, 1.0, 1.5]), FLOOR, None, np.zeros(3, int))
    figure = traces_plot([through, through], [REJECTED], theme="light")
    np.testing.assert_array_equal(trace(figure, "objects").x, [1, 2, 3, np.nan, 1, 2, 3, np.nan])
    np.testing.assert_array_equal(trace(figure, "background").y, [0.5, -1.0, np.nan])
    assert trace(figure, "background, rejected").x == (2,)
    assert trace(figure, "objects, rejected").x == ()
    assert trace(figure, "rejected below").y.tolist() == FLOOR.tolist()
    assert "2 of 2 objects came through; 1 window of background rejected" in words(figure)
    assert "0 of 0 objects" in words(traces_plot([], [], theme="dark"))


def test_each_round_of_training_begins_anew():
    figure = training_plot(np.array([0.3, 0.2, 0.5, 0.4, 0.1]), np.array([2, 5]), theme="light")
    first, last = trace(figure, "round 1: 2 trees"), trace(figure, "round 2: 3 trees")
    assert first.y.tolist() == [0.3, 0.2]
    assert last.x.tolist() == [1, 2, 3]
    assert (first.line.dash, last.line.dash) == ("dot", "solid")


def test_a_tree_shows_its_questions_and_the_way_of_the_window():
    figure = tree_plot(TREE, theme="light", window=(16, 32), number=7, leaf=1)
    assert "Tree 7" in words(figure)
    assert "mean of gradient over 6 × 6 px 0.250?" in words(figure)
    assert "mean of U minus that of V (dotted), 4 × 8 px −0.100?" in words(figure)
    assert "<b>+0.100</b>" in words(figure)
    below, at_least = figure.layout.annotations[:2]  # beside the middle of their lines
    assert (below.x, below.xanchor, below.xshift) == (3, "right", -12)
    assert (at_least.x, at_least.xanchor, at_least.xshift) == (5, "left", 12)
    assert below.y == pytest.approx((3 + 1.65) / 2)
    thick = [part for part in figure.data if part.line.width == 3]
    assert [part.name for part in thick] == ["below", "at least"]
    box = shape(figure, "subtracted")
    assert box.line.dash == "dot"
    assert [part.name for part in figure.layout.shapes].count("window") == 3
    window, inside = figure.layout.shapes[:2]  # of the first question, from 2, 4 to 8, 10
    across, down = window.x1 - window.x0, window.y0 - window.y1
    assert (down, window.x1) == pytest.approx((0.9, 4 - 0.06))  # left of the text of the question
    assert window.y0 + window.y1 == pytest.approx(2 * 3)
    assert (inside.x0 - window.x0) / across == pytest.approx(2 / 16)
    assert (window.y0 - inside.y1) / down == pytest.approx(10 / 32)


def test_pictures_stand_side_by_side_below_their_names():
    wide = np.tile(GREY, 8)
    figure = pictures_plot(dict.fromkeys("abc", wide), theme="light", title="Steps", columns=2)
    lefts = [image.x for image in figure.layout.images]
    assert lefts[0] == lefts[2] == 0 < lefts[1]
    assert [text.text for text in figure.layout.annotations] == ["a", "b", "c"]
    content = base64.b64decode(figure.layout.images[0].source.partition(",")[2])
    assert cv2.imdecode(np.frombuffer(content, np.uint8), -1).shape == (30, 320)
