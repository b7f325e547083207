"""Figures of saliency."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import trace, words

from nvcore.comparison.compare import Result
from nvcore.figures.saliency import MANY_RECORDINGS, parts_plot, plane_plot, recency_plot


def missed(**params: object) -> Result:
    """Two recordings of ten frames; X misses frames 2-3 and 8-9 of the second, Y nothing."""
    places = [Place(range(10)), Place(range(10))]
    truth = [at(i, 50, track=3, recording=1) for i in range(10)]
    x = [box for box in truth if box.frame not in (2, 3, 8, 9)]
    return result_of(make_dataset(truth, x, truth, places=places), **params)


@pytest.fixture(scope="module")
def result() -> Result:
    return missed()


def test_events_stand_at_their_end_on_the_curve_of_recency(result: Result) -> None:
    figure = recency_plot(result, theme="light")
    events = trace(figure, "X: x")
    # the most salient first: the later of two equally long ones
    assert events.x == pytest.approx([1.0, 0.4])
    assert events.y == pytest.approx([0.9933, 0.2689], abs=1e-4)
    assert events.customdata.tolist() == [18, 12]
    assert len(trace(figure, "Y: y").x) == 0
    assert "X 2 events, Y 0 events" in words(figure)
    curve = trace(figure, "recency")
    assert curve.y[100] == pytest.approx(0.5)
    assert (curve.x[0], curve.x[-1]) == (0, 1)


def test_marks_of_both_systems_have_one_scale() -> None:
    """X misses a pedestrian for 0.4 s, Y for 0.1 s."""
    truth = [at(i, 50, track=3) for i in range(10)]
    x = [box for box in truth if box.frame < 6]
    y = [box for box in truth if box.frame < 9]
    figure = recency_plot(result_of(make_dataset(truth, x, y)), theme="light")
    assert trace(figure, "X: x").marker.size[0] == pytest.approx(5 + 15)
    assert trace(figure, "Y: y").marker.size[0] == pytest.approx(5 + 15 / 2)


def test_events_of_one_recording_alone_can_be_shown(result: Result) -> None:
    assert len(trace(recency_plot(result, theme="light", recording=0), "X: x").x) == 0
    assert len(trace(recency_plot(result, theme="light", recording=1), "X: x").x) == 2
    assert "No saliency events" in words(parts_plot(result, theme="light", recording=0))
    figure = parts_plot(result, theme="light", recording=1, n=1)
    assert figure.layout.yaxis.ticktext == ("ped 3, from 0.8 s",)  # without the recording's name


def test_an_event_is_taken_apart_into_duration_and_what_recency_leaves(result: Result) -> None:
    figure = parts_plot(result, theme="light")
    pale, solid = (part for part in figure.data if part.name == "X: x" and part.orientation == "h")
    assert pale.x == pytest.approx([0.2, 0.2])
    assert solid.x == pytest.approx([0.2 * 0.99331, 0.2 * 0.26894], abs=1e-5)
    assert solid.customdata.tolist() == [18, 12]
    assert figure.layout.yaxis.ticktext[0] == "r1, ped 3, from 0.8 s"
    assert figure.layout.yaxis.ticklabelstandoff > 0  # bars begin at the axis
    assert figure.layout.xaxis.title.text == "seconds (only the largest counts)"
    assert "pale: duration, solid: × recency" in words(figure)
    # a legend that one side of the plot holds would make Plotly push the plot away from it
    assert (figure.layout.legend.xref, figure.layout.legend.yref) == ("container", "container")


def test_the_events_of_both_systems_stand_in_rows_of_their_own() -> None:
    truth = [at(i, 50, track=3) for i in range(10)]
    found = [box for box in truth if box.frame not in (2, 3, 8, 9)]
    figure = parts_plot(result_of(make_dataset(truth, found, found)), theme="light")
    bars = [bar for bar in figure.data if bar.orientation == "h"]
    assert [bar.y.tolist() for bar in bars] == [[0, 1], [0, 1], [2, 3], [2, 3]]
    assert len(figure.layout.yaxis.ticktext) == 4


def test_every_recording_has_a_mark_for_each_system_and_a_line_between_the_two(
    result: Result,
) -> None:
    figure = plane_plot(result, theme="light")
    x, y = trace(figure, "X: x"), trace(figure, "Y: y")
    # recording 0 is empty; in recording 1 X misses 4 of 10 frames in the middle of the picture
    assert x.x.tolist() == pytest.approx([1, 1 - 0.4 * 0.9])
    assert x.y.tolist() == pytest.approx([0, 0.2 * 0.99331], abs=1e-5)
    assert (y.x.tolist(), y.y.tolist()) == ([1, 1], [0, 0])
    line = trace(figure, "the same recording")
    assert line.x[3:5].tolist() == [x.x[1], y.x[1]]
    assert line.y[3:5].tolist() == [x.y[1], y.y[1]]
    assert np.isnan(line.x[[2, 5]]).all()
    mean = trace(figure, "mean of X")
    assert mean.showlegend is not False  # a mark of its own kind: the legend explains it
    assert (mean.x[0], mean.y[0]) == pytest.approx((np.mean(x.x), np.mean(x.y)))
    assert "2 recordings; best is bottom right; better in both: X in 0, Y in 1" in words(figure)
    # a mark opens the most salient event, else the recording
    assert x.customdata.tolist() == [0, 18]
    assert y.customdata.tolist() == [0, 10]
    assert "r1: X<br>mean similarity 0.640<br>saliency 0.20 s" in x.text
    assert (x.marker.size, x.marker.opacity) == (10, 1)


def test_marks_of_many_recordings_are_small() -> None:
    n = MANY_RECORDINGS + 1
    places = [Place([0])] * n
    truth = [at(0, 50, track=1, recording=i) for i in range(n)]
    figure = plane_plot(result_of(make_dataset(truth, truth, [], places=places)), theme="dark")
    marker = trace(figure, "Y: y").marker
    assert len(trace(figure, "Y: y").x) == n
    assert (marker.size, marker.opacity) == (5, 0.6)


def test_without_frames_there_is_no_plane() -> None:
    figure = plane_plot(result_of(make_dataset(places=[Place([])])), theme="light")
    assert "no recording to compare" in words(figure)


def test_with_risk_and_seconds_marks_axes_and_texts_are_of_these() -> None:
    result = missed(
        saliency_weight="risk", recency_unit="seconds", proximity="none",
        saliency_aggregate="sum", saliency_scope="encounter",
    )  # fmt: skip
    figure = recency_plot(result, theme="light")
    events = trace(figure, "X: x")
    assert events.x.tolist() == pytest.approx([0.0, 0.6])
    assert "larger marks weigh more" in words(figure)
    assert "end of the event to the end of its encounter (s)" in figure.layout.xaxis.title.text
    assert "for 0.20 s, weight 0.20 s<br>0.20 s × recency" in events.text[0]
    parts = parts_plot(result, theme="light")
    assert "pale: weighted distance" in words(parts)
    assert "their sum counts" in parts.layout.xaxis.title.text
