"""State lanes."""

from __future__ import annotations

import numpy as np
import pytest
from builders import at, make_dataset, result_of
from figure_parts import shape, trace, words

from nvcore.figures import lanes
from nvcore.figures.lanes import lane_order, lanes_figure
from nvcore.figures.over_time import similarity_plot

TRUTH = [at(i, 50, track=3) for i in range(6)]


Y = [at(i, 50) for i in (0, 1, 4, 5)]


def test_a_run_is_one_bar_from_its_first_frame_to_the_end_of_its_last() -> None:
    figure = lanes_figure(result_of(make_dataset(TRUTH, TRUTH, Y)), 0, theme="light", cursor_row=2)
    # a state that never holds is not in the legend
    assert [part.name for part in figure.data] == ["X matched", "Y matched", "Y missed", "frames"]
    corners = trace(figure, "Y missed").x
    assert corners[:5] == pytest.approx([0.2, 0.4, 0.4, 0.2, 0.2])
    assert np.isnan(corners[5])
    assert len(corners) == 6
    assert len(trace(figure, "Y matched").x) == 12
    assert len(trace(figure, "X matched").x) == 6
    x, y = (np.nanmax(trace(figure, f"{letter} matched").y) for letter in "XY")
    assert x < y  # X stands above Y: the axis runs downwards
    assert figure.layout.yaxis.range[0] > figure.layout.yaxis.range[1]
    assert shape(figure, "cursor").x0 == pytest.approx(0.2)


def test_a_click_in_a_lane_gives_the_row_of_the_frame_and_the_encounter() -> None:
    figure = lanes_figure(result_of(make_dataset(TRUTH, TRUTH, Y)), 0, theme="light")
    frames = trace(figure, "frames")
    assert frames.customdata.tolist() == [[row, 0] for row in range(6)]
    assert frames.y.tolist() == [0] * 6
    assert frames.text[2] == "pedestrian 3, frame 2, 0.20 s<br>X: matched   Y: missed"


def test_lanes_are_named_and_the_most_severe_failure_is_on_top() -> None:
    # as severe: in the order in which they appear; nearer the edge: less severe
    truth = [at(3, 50, track=1), at(0, 50, track=2), at(0, 20, track=3)]
    result = result_of(make_dataset(truth))
    figure = lanes_figure(result, 0, theme="light", chosen=2)
    assert figure.layout.yaxis.ticktext == ("ped 2", "ped 1", "<b>▶ ped 3</b>")
    assert (shape(figure, "chosen").y0, shape(figure, "chosen").y1) == (1.5, 2.5)
    assert "3 pedestrians, most severe on top" in words(figure)
    assert lane_order(result, 0).tolist() == [1, 0, 2]


def test_lanes_can_be_those_with_misses_alone() -> None:
    truth = TRUTH + [at(i, 20, track=12) for i in range(6)]
    detections = [at(i, 50) for i in range(6)]
    result = result_of(make_dataset(truth, detections, detections))
    figure = lanes_figure(result, 0, theme="light", only_missed=True)
    assert figure.layout.yaxis.ticktext == ("ped 12",)
    assert "1 pedestrian with misses" in words(figure)
    all_found = result_of(make_dataset(TRUTH, detections, detections))
    none = lanes_figure(all_found, 0, theme="light", only_missed=True)
    assert "Nobody near enough to count is missed" in words(none)


def test_the_axis_of_time_is_above_the_lanes_and_that_of_the_similarity_over_time() -> None:
    result = result_of(make_dataset(TRUTH, TRUTH, Y))
    over, below = similarity_plot(result, 0, theme="light"), lanes_figure(result, 0, theme="light")
    assert below.layout.xaxis.side == "top"
    for side in "lr":
        assert below.layout.margin[side] == over.layout.margin[side]
    assert below.layout.xaxis.range == over.layout.xaxis.range


def test_a_pedestrian_who_is_far_is_pale_for_both_systems() -> None:
    result = result_of(make_dataset(TRUTH), proximity="height", midpoint=80.0, spread=1.0)
    figure = lanes_figure(result, 0, theme="light")
    assert len(trace(figure, "too far to count").x) == 12
    assert trace(figure, "frames").text[0].endswith("X: too far to count   Y: too far to count")


def test_a_gap_in_a_track_is_not_annotated() -> None:
    truth = [box for box in TRUTH if box.frame != 2]
    figure = lanes_figure(result_of(make_dataset(truth, truth, truth)), 0, theme="light")
    assert trace(figure, "frames").text[2].endswith("X: not annotated   Y: not annotated")


def test_some_of_the_lanes_can_be_drawn() -> None:
    truth = TRUTH + [at(i, 20, track=12) for i in range(6)]
    detections = [at(i, 50) for i in range(6)]
    result = result_of(make_dataset(truth, detections, detections))
    figure = lanes_figure(result, 0, theme="light", most=1)
    assert figure.layout.yaxis.ticktext == ("ped 12",)
    assert "2 pedestrians, most severe on top, 1 to 1 drawn" in words(figure)
    second = lanes_figure(result, 0, theme="light", first=1, most=1)
    assert second.layout.yaxis.ticktext == ("ped 3",)


def test_a_recording_without_pedestrians_says_so() -> None:
    figure = lanes_figure(result_of(make_dataset(n_frames=2)), 0, theme="light")
    assert "no annotated pedestrian" in words(figure)


def test_of_too_many_bars_those_in_one_column_of_pixels_are_drawn_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    y = [at(i, 50) for i in (0, 2, 4)]  # missed in 1, 3, 5: columns of 0.3 s hold 1; 3 and 5
    result = result_of(make_dataset(TRUTH, TRUTH, y))
    monkeypatch.setattr(lanes, "MAX_BARS", 2)
    monkeypatch.setattr(lanes, "PIXELS", 2)
    corners = trace(lanes_figure(result, 0, theme="light"), "Y missed").x
    assert corners[[0, 1, 6, 7]].tolist() == pytest.approx([0.0, 0.3, 0.3, 0.6])
    assert len(corners) == 12


def test_places_to_click_stay_few_with_many_lanes() -> None:
    truth = [at(i, 2 + number / 2, track=number) for number in range(190) for i in range(30)]
    figure = lanes_figure(result_of(make_dataset(truth)), 0, theme="light")
    assert 190 * 20 <= len(trace(figure, "frames").x) <= 4000
