"""Maps of settings, and of the cost of a miss over the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import shape, trace, words
from scenes import draw_scene

from nvcore.common.palette import X_COLOUR, Y_COLOUR
from nvcore.comparison.compare import compare
from nvcore.evidence.stability.map import StabilityMap, map_stability
from nvcore.figures.maps import cost_plot, stability_map
from nvcore.metrics.cost_map import map_cost
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params


@pytest.fixture(scope="module")
def stability() -> StabilityMap:
    """A map on which either system is better somewhere."""
    result = compare(draw_scene(44).dataset(), Params(midpoint=40.0))
    return map_stability(result, "alpha-midpoint", "similarity", n_points=9)


@pytest.fixture(scope="module")
def figure(stability: StabilityMap) -> go.Figure:
    return stability_map(stability, theme="light")


def test_the_map_has_the_differences_in_the_systems_colours(
    stability: StabilityMap, figure: go.Figure
) -> None:
    heat = trace(figure, "difference")
    assert np.array_equal(heat.z, stability.difference.T)
    assert "equal false alarms per frame" not in [part.name for part in figure.data]
    assert heat.x.tolist() == stability.axes[0].values.tolist()
    assert heat.y.tolist() == stability.axes[1].values.tolist()
    assert heat.zmax == -heat.zmin == np.abs(stability.difference).max()
    ends = (heat.colorscale[0][1], heat.colorscale[-1][1])
    assert ends == (Y_COLOUR["light"], X_COLOUR["light"])
    assert figure.layout.xaxis.title.text == "Misses against false alarms (alpha)"
    start = stability.axes[1].values[0]
    assert figure.layout.yaxis.title.text == f"Counts half at (midpoint, px), from {start:.2g}"


def test_a_click_gives_the_cell(stability: StabilityMap, figure: go.Figure) -> None:
    clicks = trace(figure, "settings")
    assert clicks.customdata.tolist() == list(range(stability.difference.size))
    for cell in (0, 13, stability.difference.size - 1):
        settings = stability.settings(cell)
        assert (clicks.x[cell], clicks.y[cell]) == (settings["alpha"], settings["midpoint"])
        assert f"alpha {settings['alpha']:.4g}" in clicks.text[cell]
    assert "X has the higher mean similarity, by" in clicks.text[stability.difference.argmax()]
    assert "Y has the higher mean similarity, by" in clicks.text[stability.difference.argmin()]


def test_the_analysed_setting_and_the_nearest_overturning_one_are_marked(
    stability: StabilityMap, figure: go.Figure
) -> None:
    marker = trace(figure, "as analysed")
    assert (marker.x, marker.y) == ((0.9,), (40.0,))
    assert stability.overturn is not None
    other = trace(figure, "nearest that overturns it")
    assert (other.x[0], other.y[0]) == tuple(stability.overturn.settings.values())
    frame = shape(figure, "plausible range")
    assert (frame.x0, frame.x1) == (0.5, 1.0)
    assert (frame.y0, frame.y1) == stability.axes[1].plausible
    text = words(figure)
    assert f"holds in {100 * stability.share_held:.0f} % of the plausible range" in text
    assert f"{stability.difference.size} settings" in text


def test_the_line_of_no_difference_goes_around_ties(
    stability: StabilityMap, figure: go.Figure
) -> None:
    line = trace(figure, "verdict turns")
    assert (line.contours.start, line.contours.end, line.contours.coloring) == (0, 0, "none")
    assert np.array_equal(line.z, stability.difference.T)
    winner = stability.winner.copy()
    winner[0, 0] = "even"
    line = trace(stability_map(replace(stability, winner=winner), theme="light"), "verdict turns")
    assert (line.contours.start, line.contours.end) == (-0.5, 0.5)
    assert set(np.unique(line.z)) == {-1, 0, 1}


def test_regions_are_named_where_they_are(stability: StabilityMap, figure: go.Figure) -> None:
    names = {"X better": "x", "Y better": "y"}
    assert {note.text for note in figure.layout.annotations} == set(names)
    for note in figure.layout.annotations:
        i = int(np.flatnonzero(stability.axes[0].values == note.x)[0])
        j = int(np.flatnonzero(stability.axes[1].values == note.y)[0])
        assert stability.winner[i, j] == names[note.text]


def test_a_name_stands_above_the_mark_of_the_only_cell_that_it_could_stand_in() -> None:
    boxes = [at(0, 50, track=1)]
    result = result_of(make_dataset(boxes, boxes, []))
    rules = map_stability(result, "saliency-rule", "saliency")
    present = rules.axes[0].present_index, rules.axes[1].present_index
    alone = np.full((2, 2), "y", dtype=object)
    alone[present] = "x"
    figure = stability_map(replace(rules, winner=alone), theme="light")
    names = {name.text: name for name in figure.layout.annotations}
    assert (names["X better"].x, names["X better"].y) == present
    assert names["X better"].yshift > 13 + 6  # half the name and half the mark
    assert names["Y better"].yshift == 0


def test_equal_false_alarms_are_a_dashed_line_over_both_thresholds() -> None:
    # the same boxes with other scores: equal false alarms are equal shares of each system's scores
    boxes = [at(f, c) for f in range(8) for c in (50, 10)]
    x, y = (
        [box._replace(score=(i + 1) / (scale * len(boxes))) for i, box in enumerate(boxes)]
        for scale in (1, 2)
    )
    result = result_of(make_dataset([at(f, 50) for f in range(8)], x, y))
    stability = map_stability(result, "thresholds", "similarity", n_points=9)
    line = trace(stability_map(stability, theme="light"), "equal false alarms per frame")
    assert line.line.dash == "dash"
    assert line.y == pytest.approx(line.x / 2)
    for axis, along in zip(stability.axes, (line.x, line.y), strict=True):
        assert axis.values[0] <= along.min() <= along.max() <= axis.values[-1]


def test_choices_are_named_on_their_axis() -> None:
    data = make_dataset([at(0, 50, w=20.0, track=1)], [at(0, 50, w=4.0)], [])
    figure = stability_map(
        map_stability(result_of(data), "matching", "encounters", n_points=3), theme="light"
    )
    assert figure.layout.yaxis.ticktext == ("overlap<br>of the boxes", "sideways<br>position")
    assert "verdict turns" not in [part.name for part in figure.data]
    frame = shape(figure, "plausible range")
    assert (frame.y0, frame.y1) == (-0.5, 1.5)


def test_one_setting_is_a_curve_filled_on_the_winners_side() -> None:
    data = make_dataset([at(0, 50)], [], [at(0, 50, score=0.9), at(0, 25, score=0.4)])
    stability = map_stability(result_of(data), "alpha-midpoint", "similarity", n_points=5)
    figure = stability_map(stability, theme="light")
    assert trace(figure, "difference").y.tolist() == stability.difference.tolist()
    assert (trace(figure, "X better").y >= 0).all()
    assert (trace(figure, "Y better").y <= 0).all()
    assert trace(figure, "settings").customdata.tolist() == list(range(6))  # 5 and 0.9
    assert trace(figure, "as analysed").x == (0.9,)
    turn = trace(figure, "nearest that overturns it")
    assert (turn.x[0], turn.y) == (pytest.approx(1 / 3), (0,))  # between two points
    assert (shape(figure, "plausible range").x0, shape(figure, "plausible range").x1) == (0.5, 1)
    assert "mean similarity: X better by" in figure.layout.yaxis.title.text


def test_settings_of_each_recordings_own_are_a_line_between_the_ends() -> None:
    places = [Place([0], height=100), Place([0], height=300)]
    truth = [at(0, 50, recording=0), at(0, 50, recording=1)]
    result = compare(make_dataset(truth, truth, [], places=places), Params())
    stability = map_stability(result, "alpha-midpoint", "similarity", n_points=3)
    marker = trace(stability_map(stability, theme="light"), "as analysed")
    assert (marker.x, marker.y, marker.mode) == ((0.9, 0.9), (10, 30), "markers+lines")


def test_an_undefined_map_says_why_and_one_with_undefined_cells_is_drawn(
    stability: StabilityMap,
) -> None:
    partly = np.where(stability.winner == "y", np.nan, stability.difference)
    figure = stability_map(replace(stability, difference=partly), theme="light")
    assert np.array_equal(trace(figure, "difference").z, partly.T, equal_nan=True)
    nothing = map_stability(result_of(make_dataset(n_frames=0)), "edge-weight", "similarity")
    assert "there are no frames" in words(stability_map(nothing, theme="dark"))


def test_costs_lie_where_they_are_in_the_picture_and_its_upper_part_is_empty():
    dataset = make_dataset([], n_frames=1, width=200.0, height=100.0, horizon=50.0)
    settings = Params(proximity="horizon", midpoint=25.0, spread=5.0)
    costs = map_cost(dataset.truth, dataset.frame_columns, settings, 0)
    figure = cost_plot(costs, theme="dark", objects=PEDESTRIAN)
    drawn = trace(figure, "cost")
    assert drawn.z == pytest.approx(costs.cost, nan_ok=True, abs=1e-6)
    assert np.isnan(drawn.z[drawn.y <= 50]).all()
    assert (drawn.zmin, drawn.zmax) == (0, 1)
    assert figure.layout.xaxis.range == pytest.approx((0, 200))
    assert figure.layout.yaxis.range == pytest.approx((100, 0))  # rows are counted downwards
