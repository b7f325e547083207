"""What a threshold leaves of a system, and thresholds that compare."""

from __future__ import annotations

import numpy as np
import pytest
from builders import NAN, Box, at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import draw_scene

from nvcore.dataset import Dataset
from nvcore.dataset.schema import DetectionState
from nvcore.metrics.detection.operating_point import (
    CURVE_COLUMNS,
    alarms_at_rate,
    false_alarm_curve,
    operating_point,
    point_of_matches,
    round_between,
    same_operating_point,
    score_histogram,
    threshold_for,
)
from nvcore.settings.params import Params

PARAMS = Params(proximity="none")


def alarms(*scores: float) -> list[Box]:
    """A false alarm of each score, one a frame."""
    return [at(f, 10, score=score) for f, score in enumerate(scores)]


def small() -> Dataset:
    """Four frames at 10 fps; X: matches of 0.9, 0.8, 0.4, false alarms of 0.7, 0.4, 0.2."""
    truth = [at(f, 50, track=1) for f in range(4)]
    x = [at(0, 50, score=0.9), at(1, 50, score=0.8), at(2, 50, score=0.4), *alarms(0.7, 0.4, 0.2)]
    return make_dataset(truth, x)


def test_a_threshold_leaves_what_is_at_least_as_high():
    point = operating_point(small(), "x", PARAMS, threshold=0.4)
    assert (point.threshold, point.n_kept, point.n_false_alarms) == (0.4, 5, 2)
    assert point.false_alarms_per_frame == 0.5
    assert point.false_alarms_per_minute == pytest.approx(2 / 0.4 * 60)


def test_a_comparison_has_the_operating_points_of_its_thresholds():
    result = result_of(small(), threshold_x=0.4)
    of_matches = point_of_matches(result.dataset, result.x.matches, result.x.threshold)
    assert of_matches == operating_point(small(), "x", PARAMS, threshold=0.4)


def test_a_rate_of_false_alarms_is_a_number_of_them_in_the_data():
    assert alarms_at_rate(small(), 0.5) == 2
    assert alarms_at_rate(small(), 0) == 0
    assert alarms_at_rate(make_dataset(frames=[]), 100) == 0
    for rate in (-1, NAN, np.inf):
        with pytest.raises(ValueError, match="expected 0 or more"):
            alarms_at_rate(small(), rate)


def test_a_curve_has_a_point_for_every_score():
    curve = false_alarm_curve(small(), "x", PARAMS)
    assert list(curve) == list(CURVE_COLUMNS)
    assert curve["threshold"].tolist() == [0.2, 0.4, 0.7, 0.8, 0.9]
    assert curve["n_kept"].tolist() == [6, 5, 3, 2, 1]
    assert curve["n_false_alarms"].tolist() == [3, 2, 1, 0, 0]
    assert curve["false_alarms_per_frame"].tolist() == [0.75, 0.5, 0.25, 0, 0]


def test_a_curve_of_many_scores_is_thinned_and_keeps_its_ends():
    dataset = make_dataset(x=alarms(*(i / 1000 for i in range(1000))))
    curve = false_alarm_curve(dataset, "x", PARAMS)
    assert len(curve) == 200
    assert curve["threshold"].iloc[[0, -1]].tolist() == [0, 0.999]
    assert curve["n_kept"].iloc[[0, -1]].tolist() == [1000, 1]
    mixed = make_dataset(x=alarms(NAN, *(i / 100 for i in range(100))))
    assert len(false_alarm_curve(mixed, "x", PARAMS)) == 25


@pytest.mark.parametrize("x", [[], [at(0, 50)]])
def test_a_system_without_scores_has_no_curve(x: list[Box]):
    curve = false_alarm_curve(make_dataset([at(0, 50)], x), "x", PARAMS)
    assert len(curve) == 0
    assert list(curve) == list(CURVE_COLUMNS)


@pytest.mark.parametrize(
    ("x", "y", "threshold", "n_alarms"),
    [
        ([0.9, 0.8], [0.6, 0.5, 0.41, 0.2], 0.42, 2),
        ([], [0.9, 0.5], 0.51, 1),  # none would be left above Y's highest
        ([0.9, 0.8], [0.9], None, 1),  # fewer than X: every detection counts
        # equal scores stay or go together, whichever is closer, or the lower number
        ([0.9, 0.8], [0.9, 0.5, 0.5, 0.5, 0.1], 0.51, 1),
        ([0.9, 0.8, 0.7], [0.9, 0.5, 0.5, 0.5, 0.1], 0.11, 4),
        ([0.9, 0.8], [0.9, 0.5, 0.5, 0.1], 0.51, 1),
        ([0.9], [0.5 + 2e-9, 0.5 + 1e-9], 0.5 + 2e-9, 1),  # too close for a round threshold
        ([], [1e300], None, 1),
        ([], [0.7, 0.7], None, 2),  # a constant score is no score
        ([0.9], [NAN, NAN], None, 2),
        ([0.9, 0.8], [NAN, 0.7, 0.5, 0.3], 0.7, 2),  # the closest of its curve
    ],
)
def test_y_gets_as_many_false_alarms_as_x_has(
    x: list[float], y: list[float], threshold: float | None, n_alarms: int
):
    dataset = make_dataset(x=alarms(*x, 0.1), y=alarms(*y))
    same = same_operating_point(dataset, Params(threshold_x=0.5), "x", "y")
    assert same.x.n_false_alarms == len(x)
    assert (same.threshold_y, same.y.n_false_alarms) == (threshold, n_alarms)


def test_the_threshold_gives_away_no_match_between_two_false_alarms():
    truth = [at(f, 50, track=1) for f in range(3)]
    y = [at(0, 50, score=0.6), at(1, 50, score=0.55), *alarms(0.9, 0.5, 0.3)]
    same = same_operating_point(make_dataset(truth, alarms(0.9), y), PARAMS, "x", "y")
    assert same.threshold_y == 0.51
    assert same.y.n_kept == 3


@pytest.mark.parametrize(
    ("scores", "n", "threshold"),
    [
        ([0.9, 0.8, 0.3123, 0.3119, 0.1], 3, 0.312),
        ([0.5, 0.5], 1, None),
        ([0.6, 0.5], 0, None),
        ([0.6, 0.5], 2, None),
    ],
)
def test_a_threshold_between_scores_is_as_round_as_it_can_be(
    scores: list[float], n: int, threshold: float | None
):
    assert threshold_for(np.array(scores), n) == threshold


@pytest.mark.parametrize(
    ("lost", "kept", "threshold"),
    [(0.29, 0.9, 0.3), (0.57, 0.58, 0.58), (-1.5, 2, -1.49), (12, 80, 12.01), (0.2, 0.2, None)],
)
def test_the_lowest_round_threshold_between(lost: float, kept: float, threshold: float | None):
    assert round_between(lost, kept) == threshold


def test_a_histogram_counts_every_finite_score_once():
    dataset = make_dataset(x=alarms(0, 0.1, 0.9, 1, NAN))
    table = score_histogram(dataset, "x", bins=2)
    assert table.to_numpy().tolist() == [[0, 0.5, 2], [0.5, 1, 2]]


@pytest.mark.parametrize("x", [[], [at(0, 50)]])
def test_without_scores_a_histogram_has_no_bins(x: list[Box]):
    table = score_histogram(make_dataset(x=x, n_frames=1), "x")
    assert len(table) == 0
    assert table["n"].dtype == np.int64


def test_without_frames_there_are_no_rates():
    point = operating_point(make_dataset(frames=[]), "x", PARAMS, threshold=None)
    assert np.isnan([point.false_alarms_per_frame, point.false_alarms_per_minute]).all()


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1))
def test_every_point_of_a_curve_is_what_an_analysis_at_that_threshold_finds(seed: int):
    dataset = draw_scene(seed).dataset()
    curve = false_alarm_curve(dataset, "x", PARAMS)
    for threshold, n_kept, n_alarms in curve[[*CURVE_COLUMNS[:3]]].to_numpy():
        x = result_of(dataset, threshold_x=float(threshold)).x
        assert x.false_alarm_summary.count == n_alarms
        assert np.count_nonzero(x.matches.state != DetectionState.BELOW) == n_kept
