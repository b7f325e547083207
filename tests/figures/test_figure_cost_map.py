"""What a miss would cost over the picture, small."""

from __future__ import annotations

import numpy as np
import pytest
from builders import make_dataset
from figure_parts import trace

from nvcore.figures.maps import cost_plot
from nvcore.metrics.cost_map import map_cost
from nvcore.objects import PEDESTRIAN
from nvcore.params import Params


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
