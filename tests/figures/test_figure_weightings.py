"""The weight of one pedestrian over time, three ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from builders import Box, make_dataset
from figure_parts import trace, words

from nvcore.comparison import compare
from nvcore.figures import weightings_plot
from nvcore.figures.style import LOOK
from nvcore.tables.encounters.weightings import compare_weightings

CURVES = ["by height", "by horizon", "by distance"]


def test_each_known_kind_is_a_curve_of_its_own_and_detections_stand_below() -> None:
    truth = [Box(i, 300, 200, 40, 60, track=1) for i in range(3)]
    result = compare(make_dataset(truth, [truth[1]._replace(track=-1)], width=640, height=480))
    weightings = compare_weightings(result, 0)  # neither horizon nor distance is known
    figure = weightings_plot(result, 0, weightings, theme="light")
    assert [part.name for part in figure.data if part.name.startswith("by ")] == ["by height"]
    lane = trace(figure, "X: x")
    assert np.isclose(lane.x, [0.1]).all()
    assert lane.y[0] < 0
    assert list(lane.text) == ["X detects the pedestrian, frame 1"]
    assert "count from k = 0.5 on" in words(figure)

    known = weightings.curves.assign(k_horizon=[0.1, 0.2, 0.3], k_distance=[0.4, 0.5, 0.6])
    figure = weightings_plot(result, 0, replace(weightings, curves=known), theme="light")
    curves = [trace(figure, name) for name in CURVES]
    assert [list(curve.y) for curve in curves[1:]] == [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]
    assert len({curve.line.dash for curve in curves}) == 3
    assert not {curve.line.color for curve in curves} & {LOOK["light"].x, LOOK["light"].y}
