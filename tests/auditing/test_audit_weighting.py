"""Proximity by distance where one source has no distances."""

from __future__ import annotations

from audit_comparison import dataset, find, truth_walk, walk

from nvcore.auditing import audit
from nvcore.dataset import Dataset
from nvcore.findings import Finding
from nvcore.params import Params

BY_DISTANCE = Params(proximity="distance")


def mixed(made: Dataset, params: Params = BY_DISTANCE) -> list[Finding]:
    return [one for one in audit(made, params) if one.code == "mixed-weighting"]


def test_a_system_without_distances_beside_one_with_them_is_a_warning() -> None:
    made = dataset(truth_walk(distance_m=20.0), walk(), walk(distance_m=20.0))
    finding = find(made, "mixed-weighting", BY_DISTANCE)
    assert (finding.severity.value, finding.subject, finding.count) == ("warning", "x", 40)
    assert "100% of the boxes have no distance" in finding.message
    assert "the least is 0%" in finding.message


def test_distances_everywhere_or_nowhere_are_weighted_alike() -> None:
    everywhere = walk(distance_m=20.0)
    assert mixed(dataset(truth_walk(distance_m=20.0), everywhere, everywhere)) == []
    assert mixed(dataset()) == []


def test_a_few_missing_distances_are_not_reported() -> None:
    x = [*walk(stop=30, distance_m=20.0), *walk(first=30)]
    assert mixed(dataset(truth_walk(distance_m=20.0), x, walk(distance_m=20.0))) == []


def test_without_proximity_by_distance_it_does_not_matter() -> None:
    made = dataset(truth_walk(distance_m=20.0), walk(), walk(distance_m=20.0))
    assert mixed(made, Params()) == []


def test_a_system_without_boxes_lacks_nothing() -> None:
    assert mixed(dataset(truth_walk(distance_m=20.0), [], walk(distance_m=20.0))) == []
