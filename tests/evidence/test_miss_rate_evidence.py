"""LAMR with its interval: exact over all, and as the plain way gives it for resamples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import Box, Place, make_dataset, result_of
from curve_scenes import random_boxes
from places import SAMPLE

from nvcore.comparison.compare import compare
from nvcore.evidence.bootstrap import count_units
from nvcore.evidence.miss_rate import (
    _count_up_to,
    _log_average,
    _rates,
    log_average_miss_rate_measure,
)
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.evidence.table import evidence_table
from nvcore.evidence.units import find_units
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.metrics.detection.curves import detection_curve, detection_outcomes
from nvcore.metrics.detection.miss_rate import log_average_miss_rate
from nvcore.settings.protocols import PROTOCOLS


def random_result(seed: int):
    truth, x, places = random_boxes(seed, n_frames=120)
    _, y, _ = random_boxes(seed + 100, n_frames=120)
    return result_of(make_dataset(truth, x, [*y, *x[::2]], places=places))


@pytest.mark.parametrize("protocol", ["all", "reasonable"])
@pytest.mark.parametrize("seed", range(4))
def test_over_all_units_it_is_the_curves_own(seed: int, protocol: str):
    result = random_result(seed)
    measure = log_average_miss_rate_measure(result, find_units(result), PROTOCOLS[protocol])
    for sums, system in ((measure.x, result.x), (measure.y, result.y)):
        curve = detection_curve(result.dataset, system.name, result.params, PROTOCOLS[protocol])
        assert float(_log_average(sums.sum(axis=0))) == pytest.approx(log_average_miss_rate(curve))


def test_resamples_come_near_what_their_own_curve_gives():
    result = compare(load(read_session(SAMPLE)))
    row = judge_row(result)
    assert row["difference"] == pytest.approx(-0.0533, abs=1e-4)
    assert row["low"] < row["difference"] < row["high"]
    assert 0 < row["p"] < row["p_corrected"] <= 1
    units = find_units(result)
    measure = log_average_miss_rate_measure(result, units)
    rng = np.random.default_rng(1)
    for _ in range(5):
        drawn = rng.integers(0, len(units), len(units))
        times = count_units(drawn[None], len(units))[0]
        rate = float(_log_average(times @ measure.x))
        assert rate == pytest.approx(plain_lamr(result, units, times), abs=0.01)


def plain_lamr(result, units, times):
    """LAMR of the recordings, each taken so many times, by plain loops over thresholds."""
    outcomes = detection_outcomes(result.dataset, "FIR", result.params)
    weight = times[units.unit_of_frame]
    w = weight[outcomes.frame_index]
    n_images = weight.sum()
    n_truth = weight[outcomes.truth.truth.frame_index[outcomes.truth.counts]].sum()
    tp, fp = np.cumsum(w * outcomes.is_match), np.cumsum(w * ~outcomes.is_match)
    rates = []
    for exponent in range(9):
        below = np.flatnonzero(fp / n_images <= 10 ** (-2 + exponent / 4))
        rates.append(1 - tp[below[-1]] / n_truth if len(below) else 1.0)
    return float(np.exp(np.mean(np.log(rates))))


@pytest.mark.parametrize("n", [1, 2, 7, 8, 209])
def test_levels_up_to_a_limit_are_counted_as_by_search(n: int):
    rng = np.random.default_rng(n)
    values = np.cumsum(rng.integers(0, 3, (20, n)), axis=1).astype(float)
    limits = rng.integers(-1, n + 2, (20, 9)).astype(float)
    counts = _count_up_to(values, limits)
    plain = [
        np.searchsorted(row, limit, side="right") for row, limit in zip(values, limits, strict=True)
    ]
    assert np.array_equal(counts, plain)


def test_at_references_that_no_level_reaches_everybody_is_missed():
    # 100 images, 10 pedestrians; at two levels 5 and 50 false positives, 3 and 4 matches
    rates = _rates(np.array([100.0, 10, 5, 50, 3, 4]))
    # the references allow 1, 1.8, 3.2, 5.6, 10, 17.8, 31.6, 56.2 and 100 false positives
    assert rates.tolist() == pytest.approx([1, 1, 1, 0.7, 0.7, 0.7, 0.7, 0.6, 0.6])


def test_without_scores_there_is_no_measure_and_the_reason_stands_in_its_place():
    truth, x, places = random_boxes(3)
    constant = [box._replace(score=1) for box in x]
    result = result_of(make_dataset(truth, x, constant, places=places))
    assert log_average_miss_rate_measure(result, find_units(result)) is None
    unscored = [x[0], *(box._replace(score=float("nan")) for box in x[1:])]
    result = result_of(make_dataset(truth, unscored, x, places=places))
    nobody = result_of(make_dataset([], x, x[::2], places=places))
    assert log_average_miss_rate_measure(nobody, find_units(nobody)) is None
    assert log_average_miss_rate_measure(result, find_units(result)) is None
    row = judge_row(result)
    assert np.isnan([row["x"], row["y"], row["difference"], row["p"], row["p_corrected"]]).all()
    assert row["note"].endswith(
        "needs pedestrians that count, and detections with scores that differ"
    )


def test_a_protocol_without_recordings_is_told_in_the_row():
    truth, x, places = random_boxes(5)
    result = result_of(make_dataset(truth, x, x[::2], places=places))
    at_night = replace(PROTOCOLS["reasonable"], tags=("night",))
    row = evidence_table(result, at_night).set_index("figure").loc["log_average_miss_rate"]
    assert row["label"] == "log-average miss rate, reasonable, night"
    assert np.isnan(row["difference"])
    assert "no recording with frames has the tags night" in row["note"]


def test_a_log_average_of_0_and_few_pedestrians_are_told():
    truth = [Box(frame, 10, 10, 20, 50) for frame in range(20)]
    x = [box._replace(score=0.9 - 0.01 * box.frame) for box in truth]
    # Y finds all, but not before a false positive in one of twenty images
    y = [box._replace(score=0.8 if box.frame else 0.1) for box in truth]
    y.append(Box(3, 70, 10, 20, 50, score=0.5))
    row = judge_row(result_of(make_dataset(truth, x, y)))
    assert (row["x"], row["y"]) == (0, 0)
    assert "few pedestrians: 20, a single miss changes" in row["note"]
    assert "log-average miss rate of X: nothing is missed at any of the 9 references" in row["note"]
    # references up to 0.0316 are below 1 / 20
    assert "log-average miss rate of Y: 0 at 6 of 9 references" in row["note"]


def test_without_interval_it_is_told_how_many_recordings_have_pedestrians():
    places = [Place(range(3)) for _ in range(10)]
    truth = [Box(0, 10, 10, 20, 50, recording=0)]
    result = result_of(make_dataset(truth, [truth[0]._replace(score=0.9)], [], places=places))
    row = judge_row(result)
    assert np.isnan(row["low"])
    assert "only 1 of 10 recordings have pedestrians that count" in row["note"]


def judge_row(result):
    return evidence_table(result).set_index("figure").loc["log_average_miss_rate"]


def test_recordings_that_the_protocol_does_not_count_are_no_units():
    truth, x, places = random_boxes(6, n_frames=120)
    n = len(places)
    dataset = make_dataset(truth, x[::2], x, places=places)
    tags = [("night",) if i % 4 else () for i in range(n)]
    dataset = replace(dataset, recordings=dataset.recordings.assign(tags=tags))
    result = result_of(dataset)
    at_night = replace(PROTOCOLS["all"], tags=("night",))
    row = evidence_table(result, at_night).set_index("figure").loc["log_average_miss_rate"]
    groups = subgroup_table(result, ["log_average_miss_rate"]).set_index("group")
    for name in ("x", "y", "n", "low", "high", "p", "effect"):
        assert row[name] == pytest.approx(groups.loc["night", name], nan_ok=True), name
    assert row["n"] < len(find_units(result))
