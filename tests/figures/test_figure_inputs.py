"""Figures of scores, false alarms and proximity."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from builders import Place, at, make_dataset
from figure_parts import shape, trace, words

from nvcore.figures.inputs import false_alarm_plot, proximity_plot, score_plot
from nvcore.figures.style import HEADING_PX
from nvcore.settings.params import Params

HISTOGRAM = pd.DataFrame({"low": [0.0, 0.25, 0.5, 0.75], "high": [0.25, 0.5, 0.75, 1.0],
                          "n": [5, 4, 3, 2]})  # fmt: skip
CURVE = pd.DataFrame({"threshold": [0.1, 0.5], "n_kept": [14, 5], "n_false_alarms": [6, 1],
                      "false_alarms_per_frame": [0.6, 0.1],
                      "false_alarms_per_minute": [360.0, 60.0]})  # fmt: skip


def test_scores_below_the_threshold_are_pale() -> None:
    figure = score_plot(HISTOGRAM, letter="x", name="FIR", threshold=0.5, theme="light")
    assert trace(figure, "left out").y.tolist() == [5, 4]
    assert trace(figure, "kept").y.tolist() == [3, 2]
    assert shape(figure, "threshold").x0 == 0.5
    assert "14 detections; pale: left out by the threshold" in words(figure)
    (label,) = figure.layout.annotations
    every = score_plot(HISTOGRAM, letter="y", name="NIR", threshold=None, theme="light")
    assert trace(every, "kept").y.tolist() == [5, 4, 3, 2]
    assert not every.layout.shapes
    assert not every.layout.annotations
    # the label has room where the page takes the heading off, also without a threshold
    for layout in (figure.layout, every.layout):
        assert layout.margin.t - HEADING_PX > 1.4 * label.font.size


def test_a_system_without_scores_says_so() -> None:
    for figure in (
        score_plot(HISTOGRAM[:0], letter="x", name="FIR", threshold=None, theme="light"),
        false_alarm_plot(CURVE[:0], letter="x", name="FIR", threshold=None, theme="light"),
    ):
        assert "no scores" in words(figure)


def test_false_alarms_are_drawn_by_threshold() -> None:
    figure = false_alarm_plot(CURVE, letter="y", name="<NIR>", threshold=0.3, theme="dark")
    line = trace(figure, "Y")
    assert (line.x.tolist(), line.y.tolist()) == ([0.1, 0.5], [360, 60])
    assert figure.layout.yaxis.title.text == "false alarms per minute"
    assert shape(figure, "threshold").x0 == 0.3
    assert "&lt;NIR&gt;" in words(figure)
    assert "6 false alarms at the lowest threshold" in words(figure)


TRUTH = [at(0, 20, h=30, distance_m=40.0), at(0, 50, h=10, distance_m=60.0), at(0, 80, h=10)]


def test_the_sigmoid_is_a_half_at_the_default_midpoint_of_a_tenth_of_the_height() -> None:
    figure = proximity_plot(make_dataset(TRUTH, height=200.0), Params(), theme="light")
    assert trace(figure, "midpoint").x == (20.0,)
    curve = trace(figure, "weight k")
    assert np.interp(20, curve.x, curve.y) == pytest.approx(0.5, abs=0.01)
    assert np.all(np.diff(curve.y) >= 0)


def test_heights_of_the_truth_are_counted_without_ignored_boxes() -> None:
    truth = [*TRUTH, at(0, 60, h=10, ignore=True)]
    figure = proximity_plot(make_dataset(truth), Params(), theme="light")
    bars = trace(figure, "pedestrians")
    assert sorted(bars.customdata[bars.customdata > 0].tolist()) == [1, 2]
    assert bars.y.max() == 1
    assert "3 boxes" in figure.layout.xaxis.title.text


@pytest.mark.parametrize(("params", "depth"), [({}, 40), ({"horizon": 80.0}, 10)])
def test_by_horizon_the_axis_is_the_depth_of_the_foot_point(
    params: dict[str, float], depth: float
) -> None:
    data = make_dataset(TRUTH, horizon=50.0)  # foot points in row 90
    figure = proximity_plot(data, Params(proximity="horizon", **params), theme="light")
    bars = trace(figure, "pedestrians")
    (only,) = np.flatnonzero(bars.customdata)
    assert abs(bars.x[only] - depth) <= bars.width[only]
    assert "foot below horizon (px)" in figure.layout.xaxis.title.text


def test_by_distance_the_weight_falls_with_metres() -> None:
    figure = proximity_plot(make_dataset(TRUTH), Params(proximity="distance"), theme="light")
    assert np.all(np.diff(trace(figure, "weight k").y) <= 0)
    assert trace(figure, "pedestrians").customdata.sum() == 2


def test_without_pedestrians_or_weights_it_says_so() -> None:
    figure = proximity_plot(make_dataset(TRUTH), Params(proximity="none"), theme="light")
    assert "counts the same" in words(figure)
    figure = proximity_plot(make_dataset(n_frames=1), Params(), theme="light")
    assert "no pedestrian" in words(figure)


def test_recordings_of_two_sizes_have_two_sigmoids() -> None:
    places = [Place([0], height=100), Place([0], height=300), Place([0], height=100)]
    figure = proximity_plot(make_dataset(TRUTH, places=places), Params(), theme="light")
    assert [part.x[0] for part in figure.data if part.name == "midpoint"] == [10, 30]
