"""Figures of stability maps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import Place, at, compare, make_dataset
from figure_parts import shape, trace, words
from scenes import draw_scene

from nvcore.analysis import analyse
from nvcore.figures.stability import stability_map
from nvcore.palette import X_COLOUR, Y_COLOUR
from nvcore.params import Params
from nvcore.stability import StabilityMap, map_stability


@pytest.fixture(scope="module")
def found() -> StabilityMap:
    """A map on which either system is better somewhere."""
    result = analyse(draw_scene(44).dataset(), Params(midpoint=40.0))
    return map_stability(result, "alpha-midpoint", "similarity", n_points=9)


def test_the_map_has_the_differences_in_the_systems_colours(found: StabilityMap) -> None:
    heat = trace(stability_map(found, theme="light"), "difference")
    assert np.array_equal(heat.z, found.difference.T)
    assert heat.x.tolist() == found.axes[0].values.tolist()
    assert heat.y.tolist() == found.axes[1].values.tolist()
    assert heat.zmax == -heat.zmin == np.abs(found.difference).max()
    ends = (heat.colorscale[0][1], heat.colorscale[-1][1])
    assert ends == (Y_COLOUR["light"], X_COLOUR["light"])


def test_a_click_gives_the_cell(found: StabilityMap) -> None:
    clicks = trace(stability_map(found, theme="light"), "settings")
    assert clicks.marker.opacity == 0
    assert clicks.customdata.tolist() == list(range(found.difference.size))
    for cell in (0, 13, found.difference.size - 1):
        settings = found.settings(cell)
        assert (clicks.x[cell], clicks.y[cell]) == (settings["alpha"], settings["midpoint"])
        assert f"alpha {settings['alpha']:.4g}" in clicks.text[cell]
    assert "X has the higher mean similarity, by" in " ".join(clicks.text)
    assert "Y has the higher mean similarity, by" in " ".join(clicks.text)


def test_the_analysed_setting_and_the_nearest_overturning_one_are_marked(
    found: StabilityMap,
) -> None:
    figure = stability_map(found, theme="dark")
    marker = trace(figure, "as analysed")
    assert (marker.x, marker.y) == ((0.9,), (40.0,))
    assert found.overturn is not None
    other = trace(figure, "nearest that overturns it")
    assert (other.x[0], other.y[0]) == tuple(found.overturn.settings.values())


def test_the_plausible_range_is_framed_and_its_share_told(found: StabilityMap) -> None:
    figure = stability_map(found, theme="light")
    frame = shape(figure, "plausible range")
    assert (frame.x0, frame.x1) == (0.5, 1.0)
    assert (frame.y0, frame.y1) == found.axes[1].plausible
    said = words(figure)
    assert f"holds in {100 * found.share_held:.0f} % of the plausible range" in said
    assert f"{found.difference.size} settings" in said


def test_regions_are_named_where_they_are(found: StabilityMap) -> None:
    names = {"X better": "x", "Y better": "y"}
    figure = stability_map(found, theme="light")
    assert {one.text for one in figure.layout.annotations} == set(names)
    for one in figure.layout.annotations:
        i = int(np.flatnonzero(found.axes[0].values == one.x)[0])
        j = int(np.flatnonzero(found.axes[1].values == one.y)[0])
        assert found.winner[i, j] == names[one.text]


def test_the_line_of_no_difference_is_drawn(found: StabilityMap) -> None:
    line = trace(stability_map(found, theme="light"), "verdict turns")
    assert (line.contours.start, line.contours.end, line.contours.coloring) == (0, 0, "none")
    assert np.array_equal(line.z, found.difference.T)


def test_where_there_are_ties_the_line_goes_around_them(found: StabilityMap) -> None:
    winner = found.winner.copy()
    winner[0, 0] = "even"
    line = trace(stability_map(replace(found, winner=winner), theme="light"), "verdict turns")
    assert (line.contours.start, line.contours.end) == (-0.5, 0.5)
    assert set(np.unique(line.z)) == {-1, 0, 1}


def test_choices_are_named_on_their_axis() -> None:
    data = make_dataset([at(0, 50, w=20.0, track=1)], [at(0, 50, w=4.0)], [])
    figure = stability_map(map_stability(compare(data), "matching", "encounters"), theme="light")
    assert figure.layout.yaxis.ticktext == ("iou", "lateral")
    assert "verdict turns" not in [one.name for one in figure.data]
    frame = shape(figure, "plausible range")
    assert (frame.y0, frame.y1) == (-0.5, 1.5)


def test_one_setting_is_a_curve_filled_on_the_winners_side() -> None:
    data = make_dataset([at(0, 50)], [], [at(0, 50, score=0.9), at(0, 25, score=0.4)])
    found = map_stability(compare(data), "alpha-midpoint", "similarity", n_points=5)
    figure = stability_map(found, theme="light")
    assert trace(figure, "difference").y.tolist() == found.difference.tolist()
    assert (trace(figure, "X better").y >= 0).all()
    assert (trace(figure, "Y better").y <= 0).all()
    clicks = trace(figure, "settings")
    assert clicks.customdata.tolist() == list(range(6))  # 0.9 has a point of its own
    assert trace(figure, "as analysed").x == (0.9,)
    assert (shape(figure, "plausible range").x0, shape(figure, "plausible range").x1) == (0.5, 1)
    assert "mean similarity, X less Y" in figure.layout.yaxis.title.text


def test_a_setting_that_is_no_one_point_has_no_marker() -> None:
    places = [Place([0], height=100), Place([0], height=300)]
    truth = [at(0, 50, recording=0), at(0, 50, recording=1)]
    result = analyse(make_dataset(truth, truth, [], places=places), Params())
    found = map_stability(result, "alpha-midpoint", "similarity", n_points=5)
    names = [one.name for one in stability_map(found, theme="light").data]
    assert "as analysed" not in names
    assert "difference" in names


def test_an_undefined_map_says_why() -> None:
    found = map_stability(compare(make_dataset(n_frames=0)), "edge-weight", "similarity")
    assert "there are no frames" in words(stability_map(found, theme="dark"))


def test_a_map_without_any_difference_is_drawn() -> None:
    result = compare(make_dataset([at(0, 50)], [at(0, 50)], [at(0, 50)]))
    for plane in ("edge-weight", "edge-weight-alpha"):
        figure = stability_map(map_stability(result, plane, "similarity"), theme="light")
        assert trace(figure, "as analysed").x == (0,)
        assert "holds in 100 % of the plausible range" in words(figure)
