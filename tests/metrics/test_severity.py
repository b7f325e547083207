from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.dataset.schema import Category
from nvcore.metrics.proximity import sigmoid


def test_a_miss_straight_ahead_and_near_costs_a_second_each_second() -> None:
    truth = [at(f, 50, track=1) for f in range(10)]
    result = result_of(make_dataset(truth, [at(f, 50) for f in range(4)]))
    (x,), (y,) = (system.failures.to_dict("records") for _, system in result.sides)
    assert x == pytest.approx({"severity_s": 0.6, "peak_cost": 1.0, "peak_row": 4})
    assert y == pytest.approx({"severity_s": 1.0, "peak_cost": 1.0, "peak_row": 0})


def test_half_way_to_the_edge_it_costs_half_in_town_and_all_in_the_country() -> None:
    truth = [at(f, 25, track=1) for f in range(10)]
    dataset = make_dataset(truth)
    assert result_of(dataset).x.failures["severity_s"].tolist() == pytest.approx([0.5])
    rural = result_of(dataset, edge_weight=1.0).x.failures
    assert rural["severity_s"].tolist() == pytest.approx([1.0])


def test_a_recording_says_what_its_traffic_costs_unless_a_value_is_given() -> None:
    places = [Place(range(10), context=context) for context in (0.0, 1.0, 0.5, np.nan)]
    truth = [at(f, 25, track=1, recording=r) for r in range(4) for f in range(10)]
    dataset = make_dataset(truth, places=places)
    by_context = result_of(dataset).x
    assert by_context.failures["severity_s"].tolist() == pytest.approx([0.5, 1.0, 0.75, 0.5])
    assert by_context.distances.d_miss[::10].tolist() == pytest.approx([25, 50, 37.5, 25])
    given = result_of(dataset, edge_weight=0.0).x
    assert given.failures["severity_s"].tolist() == pytest.approx([0.5] * 4)


def test_a_false_alarm_beside_a_missed_pedestrian_makes_his_failure_no_lighter() -> None:
    truth = [at(f, 50, track=1) for f in range(10)]
    beside = [at(f, 53) for f in range(10)]
    result = result_of(make_dataset(truth, beside))
    assert result.x.similarity.mean() > result.y.similarity.mean()
    assert result.x.failures.equals(result.y.failures)


def test_only_relevant_frames_weigh_and_a_distant_encounter_weighs_nothing() -> None:
    truth = [at(f, 50, h=14 if f < 5 else 2, track=1) for f in range(10)]
    truth += [at(f, 50, h=2, track=2) for f in range(10)]
    result = result_of(make_dataset(truth), proximity="height")
    assert result.category.tolist() == [Category.NEITHER, Category.DISTANT]
    k = float(sigmoid(np.array([2.0]))[0])  # 14 px: 2 spreads above the midpoint
    assert result.x.failures["severity_s"].tolist() == pytest.approx([0.5 * k, 0])
    assert result.x.failures["peak_cost"].tolist() == pytest.approx([k, 0])
    assert result.x.failures["peak_row"].tolist() == [0, -1]


def test_a_track_that_occurs_twice_in_a_frame_costs_once_and_the_more() -> None:
    truth = [at(0, centre, track=1) for centre in (50, 25)]
    missed = result_of(make_dataset(truth)).x.failures
    assert missed["severity_s"].tolist() == pytest.approx([0.1])
    matched_once = result_of(make_dataset(truth, [at(0, 25)])).x.failures
    assert matched_once["severity_s"].tolist() == [0]
