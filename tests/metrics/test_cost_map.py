"""What missing a pedestrian would cost over the picture."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Box, Place, at, make_dataset
from hypothesis import given
from hypothesis import strategies as st

from nvcore.common.errors import ParameterError
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.metrics.cost_map import CostMap, fit_line, map_cost
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params


def cost_map(dataset: Dataset, *, recording: int = 0, **params: object) -> CostMap:
    """On a grid of 5 rows and 4 columns."""
    return map_cost(
        dataset.truth, dataset.frame_columns, Params(**params), recording, n_rows=5, n_columns=4
    )


def on_flat_ground(n: int = 12, **more: float) -> Dataset:
    """Boxes half as tall as their feet are below row 40, in a picture of 100 x 100 px."""
    feet = np.linspace(50, 90, n)
    boxes = [at(i, 50, h=0.5 * (foot - 40), foot=foot, **more) for i, foot in enumerate(feet)]
    return make_dataset(boxes)


def test_without_proximity_the_cost_is_the_border_alone():
    costs = cost_map(on_flat_ground(), proximity="none")
    assert costs.basis == "none"
    assert costs.centre_px.tolist() == [12.5, 37.5, 62.5, 87.5]
    assert costs.foot_px.tolist() == [10, 30, 50, 70, 90]
    # 12.5 and 37.5 px from the nearer edge, of a half width of 50 px
    assert costs.cost.tolist() == [[0.25, 0.75, 0.75, 0.25]] * 5


@pytest.mark.parametrize(("rho", "border"), [(1.0, [1, 1]), (0.5, [0.625, 0.875])])
def test_the_traffic_context_lifts_the_edge(rho: float, border: list[float]):
    costs = cost_map(on_flat_ground(), proximity="none", edge_weight=rho)
    assert costs.cost[0, :2].tolist() == border


def test_a_recording_that_states_its_context_has_its_own_map():
    places = [Place(range(3)), Place(range(3), context=1.0, width=200.0, height=50.0)]
    dataset = make_dataset([at(0, 50)], places=places)
    costs = cost_map(dataset, recording=1, proximity="none")
    assert costs.cost.min() == 1
    assert costs.centre_px[-1] == 175
    assert costs.foot_px[-1] == 45


def test_the_height_in_each_row_is_that_of_a_line_through_the_boxes():
    costs = cost_map(on_flat_ground(), midpoint=15.0, spread=5.0)
    assert (costs.basis, costs.n_boxes) == ("height", 12)
    # feet in rows 50, 70, 90: 5, 15, 25 px tall, so z = -2, 0, 2; none stands above row 40
    assert np.isnan(costs.k[:2]).all()
    assert costs.k[2:] == pytest.approx([1 / (1 + np.exp(2)), 0.5, 1 / (1 + np.exp(-2))])
    assert costs.cost[3].tolist() == pytest.approx([0.125, 0.375, 0.375, 0.125])
    assert "12 boxes" in costs.text


def test_at_a_pedestrians_own_place_the_map_has_his_cost():
    """On flat ground the line is exact, and so is the cost of every box of the grid."""
    boxes = [
        at(i, centre, h=0.5 * (foot - 40), foot=foot, w=2)
        for i, (centre, foot) in enumerate([(12.5, 50), (37.5, 70), (62.5, 90)] * 5)
    ]
    result = compare(make_dataset(boxes), Params(midpoint=12.0, spread=4.0))
    costs = cost_map(result.dataset, midpoint=12.0, spread=4.0).cost
    assert result.cost[:3] == pytest.approx([costs[2, 0], costs[3, 1], costs[4, 2]])


def test_boxes_that_the_picture_cuts_and_ignored_ones_are_left_out_of_the_line():
    extra = [Box(0, 40, 30, 8, 70, 9), Box(1, 40, 0, 8, 60, 9), at(2, 50, h=80, ignore=True)]
    feet = np.linspace(50, 90, 12)
    boxes = [at(i, 50, h=0.5 * (foot - 40), foot=foot) for i, foot in enumerate(feet)]
    costs = cost_map(make_dataset([*boxes, *extra]), midpoint=15.0, spread=5.0)
    assert costs.n_boxes == 12
    assert costs.k[3] == pytest.approx(0.5)


def test_by_the_horizon_the_place_itself_says_how_near():
    dataset = make_dataset([], n_frames=2, horizon=30.0)
    costs = cost_map(dataset, proximity="horizon", midpoint=20.0, spread=20.0)
    assert costs.basis == "horizon"
    # depths -20, 0, 20, 40, 60 px
    assert np.isnan(costs.k[:2]).all()
    assert costs.k[2:] == pytest.approx([0.5, 1 / (1 + np.exp(-1)), 1 / (1 + np.exp(-2))])
    with pytest.raises(ParameterError, match="horizon"):
        cost_map(make_dataset([], n_frames=2), proximity="horizon")


def test_by_distance_its_inverse_is_the_line():
    feet = np.linspace(50, 90, 12)
    boxes = [at(i, 50, foot=foot, distance_m=400 / (foot - 40)) for i, foot in enumerate(feet)]
    costs = cost_map(make_dataset(boxes), proximity="distance", midpoint_m=40.0, spread_m=10.0)
    assert (costs.basis, costs.n_boxes) == ("distance", 12)
    # 40, 13.33 and 8 m in rows 50, 70 and 90
    assert np.isnan(costs.k[:2]).all()
    expected = [0.5, 1 / (1 + np.exp(-(40 - 400 / 30) / 10)), 1 / (1 + np.exp(-3.2))]
    assert costs.k[2:] == pytest.approx(expected)
    without = cost_map(on_flat_ground(), proximity="distance", midpoint=15.0, spread=5.0)
    assert without.basis == "height"


def test_without_a_line_the_map_is_that_of_one_height_and_says_so():
    few = cost_map(on_flat_ground(n=9), midpoint=15.0, spread=5.0)
    assert (few.basis, few.n_boxes, few.height_px) == ("one height", 0, pytest.approx(15))
    assert few.k == pytest.approx([0.5] * 5)
    text = PEDESTRIAN.say(few.text)
    assert "by lateral position only, for a pedestrian 15 px tall" in text
    nobody = cost_map(make_dataset([], n_frames=1), midpoint=20.0, spread=5.0)
    assert nobody.height_px == 20
    assert nobody.cost[0].tolist() == [0.125, 0.375, 0.375, 0.125]


def test_no_line_goes_through_feet_in_a_row_nor_where_the_near_are_smaller():
    feet = np.linspace(50, 90, 12)
    assert fit_line(np.full(12, 70.0), feet, height=100) is None
    assert fit_line(feet, -feet, height=100) is None
    line = fit_line(feet, 3 * feet - 7, height=100)
    assert line is not None
    assert tuple(line) == pytest.approx((-7, 3))


@given(st.floats(0, 1), st.floats(1, 90), st.floats(0.5, 30), st.sampled_from(["none", "height"]))
def test_a_cost_is_between_0_and_1_mirrored_and_grows_downwards(rho, midpoint, spread, proximity):
    costs = cost_map(
        on_flat_ground(), edge_weight=rho, midpoint=midpoint, spread=spread, proximity=proximity
    ).cost
    known = costs[np.isfinite(costs).all(axis=1)]
    assert ((known >= 0) & (known <= 1)).all()
    assert known == pytest.approx(known[:, ::-1])
    assert (np.diff(known, axis=0) >= -1e-12).all()
