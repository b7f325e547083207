"""Feet spread over rows against columns: whether the sideways distance tells enough."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Box, Place, make_dataset

from nvcore.auditing.perspective import MIN_BOXES, audit_foot_spread, foot_spread
from nvcore.common.findings import Remedy, Step
from nvcore.dataset import Dataset
from nvcore.settings.params import Params


def standing(rows_px: float, columns_px: float, *, n: int = MIN_BOXES, recording: int = 0) -> list:
    """Boxes whose feet and centres go from side to side and up and down, independently."""
    across, down = np.arange(n) % 2 * 2 - 1, np.arange(n) // 2 % 2 * 2 - 1
    return [
        Box(i, 300 + columns_px * a, 200 + rows_px * d, 20, 60, track=i, recording=recording)
        for i, (a, d) in enumerate(zip(across, down, strict=True))
    ]


def dataset(*parts: list) -> Dataset:
    places = [Place(range(MIN_BOXES), 640, 480)] * len(parts)
    return make_dataset([box for part in parts for box in part], places=places)


def test_the_spread_is_that_of_rows_over_that_of_columns() -> None:
    made = dataset(standing(30, 100), standing(50, 100, recording=1), standing(1, 0, recording=2))
    np.testing.assert_allclose(foot_spread(made), [0.3, 0.5, np.nan])


def test_few_boxes_few_people_and_ignored_ones_do_not_tell() -> None:
    few = standing(50, 100, n=MIN_BOXES - 2)
    ignored = [box._replace(ignore=True) for box in standing(50, 100)]
    assert np.isnan(foot_spread(dataset(few))).all()
    of_four = [box._replace(track=box.track % 4) for box in standing(50, 100)]
    assert np.isnan(foot_spread(dataset(of_four))).all()
    assert np.isnan(foot_spread(dataset(ignored))).all()


def test_feet_all_over_the_picture_are_noted_with_the_recording() -> None:
    made = dataset(standing(30, 100), standing(50, 100, recording=1))
    (finding,) = audit_foot_spread(made, Params())
    assert (finding.severity.value, finding.code, finding.count) == ("note", "foot-spread", 1)
    assert "their spread is 50 % of that sideways): r1" in finding.message
    assert finding.steps == (Step(Remedy.OPTION, "ground", "distance"),)


@pytest.mark.parametrize(
    ("rows_px", "params"),
    [(30, Params()), (50, Params(distance="ground"))],
    ids=["as from a car", "by foot points"],
)
def test_otherwise_there_is_nothing_to_say(rows_px: float, params: Params) -> None:
    assert audit_foot_spread(dataset(standing(rows_px, 100)), params) == []
