"""Proximity by distance where one source has no distances."""

from __future__ import annotations

import pytest
from audit_comparison import codes, dataset, find, truth_walk, walk
from builders import Box

from nvcore.params import Params

BY_DISTANCE = Params(proximity="distance")


NEAR = walk(distance_m=20.0)


@pytest.mark.parametrize(
    ("truth", "x", "y"),
    [
        (truth_walk(distance_m=20.0), NEAR, NEAR),
        (truth_walk(), walk(), walk()),
        (truth_walk(distance_m=20.0), [*walk(stop=30, distance_m=20.0), *walk(first=30)], NEAR),
        (truth_walk(distance_m=20.0), [], NEAR),
    ],
    ids=["everywhere", "nowhere", "a few missing", "no boxes"],
)
def test_distances_are_weighted_alike(truth: list[Box], x: list[Box], y: list[Box]) -> None:
    assert "mixed-weighting" not in codes(dataset(truth, x, y), BY_DISTANCE)


def test_without_proximity_by_distance_it_does_not_matter() -> None:
    made = dataset(truth_walk(distance_m=20.0), walk(), NEAR)
    assert "mixed-weighting" not in codes(made, Params())


def test_a_system_without_distances_beside_one_with_them_is_a_warning() -> None:
    made = dataset(truth_walk(distance_m=20.0), walk(), walk(distance_m=20.0))
    finding = find(made, "mixed-weighting", BY_DISTANCE)
    assert (finding.severity.value, finding.subject, finding.count) == ("warning", "x", 40)
    assert "100% of the boxes have no distance" in finding.message
    assert "the least is 0%" in finding.message
