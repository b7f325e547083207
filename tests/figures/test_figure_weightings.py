"""The weight of one pedestrian over time, three ways."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Box, make_dataset
from figure_parts import trace, words
from places import SAMPLE

from nvcore.comparison import Result, compare
from nvcore.figures.encounters import weightings_plot
from nvcore.figures.style import LOOK
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from nvcore.tables.encounters.weightings import compare_weightings


@pytest.fixture(scope="module")
def sample() -> Result:
    return compare(load(read_session(SAMPLE)))


def drawn(result: Result, encounter: int = 0):
    weightings = compare_weightings(result, encounter)
    return weightings, weightings_plot(result, encounter, weightings, theme="light")


def test_each_kind_is_a_curve_of_its_own_dash_and_of_no_systems_colour(sample: Result) -> None:
    weightings, figure = drawn(sample)
    curves = [trace(figure, name) for name in ("by height", "by horizon", "by distance")]
    assert len({curve.line.dash for curve in curves}) == 3
    assert not {curve.line.color for curve in curves} & {LOOK["light"].x, LOOK["light"].y}
    for curve, kind in zip(curves, ("height", "horizon", "distance"), strict=True):
        np.testing.assert_array_equal(curve.y, weightings.curves[f"k_{kind}"])
    assert "count from k = 0.5 on" in words(figure)


def test_what_is_not_known_has_no_curve_and_detections_stand_below() -> None:
    truth = [Box(i, 300, 200, 40, 60, track=1) for i in range(3)]
    dataset = make_dataset(truth, [truth[1]._replace(track=-1)], width=640, height=480)
    _, figure = drawn(compare(dataset))
    names = [part.name for part in figure.data]
    assert "by height" in names
    assert not {"by horizon", "by distance"} & {*names}
    lane = trace(figure, "X: x")
    assert np.isclose(lane.x, [0.1]).all()
    assert lane.y[0] < 0
    assert list(lane.text) == ["X detects the pedestrian, frame 1"]
