"""State lanes of a recording, and the strip of all recordings."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import shape, trace, words

from nvcore.comparison.compare import Result
from nvcore.figures import lanes
from nvcore.figures.lanes import MAX_STRIP_CLICKS, lane_order, lanes_figure, loss_strip_plot
from nvcore.figures.over_time import similarity_plot
from nvcore.tables.loss_strip import loss_strip

TRUTH = [at(i, 50, track=3) for i in range(6)]
Y = [at(i, 50) for i in (0, 1, 4, 5)]


@pytest.fixture(scope="module")
def result() -> Result:
    """A pedestrian whom Y misses in frames 2 and 3."""
    return result_of(make_dataset(TRUTH, TRUTH, Y))


@pytest.fixture(scope="module")
def two() -> Result:
    """The same pedestrian, matched, and another whom both miss."""
    truth = TRUTH + [at(i, 20, track=12) for i in range(6)]
    return result_of(make_dataset(truth, TRUTH, TRUTH))


def test_a_run_is_one_bar_from_its_first_frame_to_the_end_of_its_last(result: Result) -> None:
    figure = lanes_figure(result, 0, theme="light", cursor_row=2)
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
    frames = trace(figure, "frames")
    assert frames.customdata.tolist() == [[row, 0] for row in range(6)]
    assert frames.y.tolist() == [0] * 6
    assert frames.text[2] == "pedestrian 3, frame 2, 0.20 s<br>X: matched   Y: missed"


def test_the_axis_of_time_is_above_the_lanes_and_that_of_the_similarity_over_time(
    result: Result,
) -> None:
    over, below = similarity_plot(result, 0, theme="light"), lanes_figure(result, 0, theme="light")
    assert below.layout.xaxis.side == "top"
    for side in "lr":
        assert below.layout.margin[side] == over.layout.margin[side]
    assert below.layout.xaxis.range == over.layout.xaxis.range


def test_lanes_are_named_and_the_most_severe_failure_is_on_top() -> None:
    # as severe: in the order in which they appear; nearer the edge: less severe
    truth = [at(3, 50, track=1), at(0, 50, track=2), at(0, 20, track=3)]
    result = result_of(make_dataset(truth))
    figure = lanes_figure(result, 0, theme="light", chosen=2)
    assert figure.layout.yaxis.ticktext == ("ped 2", "ped 1", "<b>▶ ped 3</b>")
    assert (shape(figure, "chosen").y0, shape(figure, "chosen").y1) == (1.5, 2.5)
    assert "3 pedestrians, most severe on top" in words(figure)
    assert lane_order(result, 0).tolist() == [1, 0, 2]


def test_some_of_the_lanes_or_those_with_misses_alone_can_be_drawn(two: Result) -> None:
    for which, labels, told in (
        ({"most": 1}, ("ped 12",), "2 pedestrians, most severe on top, 1 to 1 drawn"),
        ({"first": 1, "most": 1}, ("ped 3",), "2 to 2 drawn"),
        ({"only_missed": True}, ("ped 12",), "1 pedestrian with misses"),
    ):
        figure = lanes_figure(two, 0, theme="light", **which)
        assert figure.layout.yaxis.ticktext == labels
        assert told in words(figure)
    all_found = result_of(make_dataset(TRUTH, TRUTH, TRUTH))
    none = lanes_figure(all_found, 0, theme="light", only_missed=True)
    assert "Nobody near enough to count is missed" in words(none)
    empty = lanes_figure(result_of(make_dataset(n_frames=2)), 0, theme="light")
    assert "no annotated pedestrian" in words(empty)


def test_of_more_lanes_than_usual_it_is_said_how_many_are_drawn_and_all_can_be() -> None:
    crowd = result_of(make_dataset([at(0, 50, track=i) for i in range(201)]))
    assert "201 pedestrians, most severe on top, 1 to 200 drawn" in words(
        lanes_figure(crowd, 0, theme="light")
    )
    assert len(lanes_figure(crowd, 0, theme="light", most=201).layout.yaxis.ticktext) == 201


def test_a_pedestrian_who_is_far_is_pale_and_a_gap_in_a_track_is_not_annotated() -> None:
    truth = [box for box in TRUTH if box.frame != 2]
    far = result_of(make_dataset(truth), proximity="height", midpoint=80.0, spread=1.0)
    figure = lanes_figure(far, 0, theme="light")
    assert len(trace(figure, "too far to count").x) == 4 * 6
    texts = [text.partition("<br>")[2] for text in trace(figure, "frames").text[:3]]
    pale, gap = "too far to count", "not annotated"
    assert texts == [f"X: {words}   Y: {words}" for words in (pale, pale, gap)]


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


def test_places_to_click_stay_few_with_many_lanes(
    two: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lanes, "CLICKS_OF_LANE", (2, 3))
    for most, rows in ((8, [0, 2, 5]), (1, [0, 5])):
        monkeypatch.setattr(lanes, "MAX_CLICKS", most)
        frames = trace(lanes_figure(two, 0, theme="light"), "frames")
        assert [row for row, _ in frames.customdata] == rows * 2


def drives(n_recordings: int, n_frames: int = 40) -> Result:
    """In recording r both systems miss the pedestrian of frame r alone."""
    truth = [at(r, 50, recording=r) for r in range(n_recordings)]
    places = [Place(range(n_frames))] * n_recordings
    return result_of(make_dataset(truth, [], [], places=places))


def test_colours_are_losses_and_a_click_opens_the_frame_that_loses_most() -> None:
    result = drives(3)
    figure = loss_strip_plot(result, loss_strip(result, n_bins=10), theme="light")
    heat, clicks = trace(figure, "loss"), trace(figure, "frames")
    assert heat.z[:, 0] == pytest.approx([0.9] * 3)
    assert heat.zmax == 1
    # four frames a bin; in the third recording frame 2 of the first bin
    worst = next(row for row, y in zip(clicks.customdata, clicks.y, strict=True) if y == 2)
    assert worst == 2 * 40 + 2
    assert clicks.text[20] == "r2, frame 2, 0.20 s<br>similarity X 0.10   Y 0.10"
    assert clicks.x[0] == pytest.approx(0.2)
    assert figure.layout.yaxis.ticktext[2] == "r2"


def test_with_many_recordings_neighbours_share_a_click_and_the_worst_frame_stays() -> None:
    result = drives(50, n_frames=60)
    figure = loss_strip_plot(result, loss_strip(result), theme="dark")
    clicks = trace(figure, "frames")
    assert len(clicks.x) <= MAX_STRIP_CLICKS
    assert set(60 * np.arange(50) + np.arange(50)) <= set(clicks.customdata.tolist())
    assert "50 recordings" in words(figure)
    few = loss_strip_plot(result, loss_strip(result, most=10), theme="dark")
    assert "the 10 in which most is lost drawn" in words(few)


def test_without_frames_the_strip_says_so() -> None:
    result = result_of(make_dataset(places=[Place([])]))
    assert "no evaluated frame" in words(loss_strip_plot(result, loss_strip(result), theme="light"))
