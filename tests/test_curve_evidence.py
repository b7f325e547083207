"""LAMR with its interval: exact over all, and as the plain way gives it for resamples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from builders import compare, make_dataset
from curve_scenes import random_boxes

from nvcore.analysis import analyse
from nvcore.bootstrap import count_units
from nvcore.curve_evidence import _log_average, log_average_miss_rate_figure
from nvcore.curves import detection_curve, detection_outcomes
from nvcore.loading import effective_params, load
from nvcore.miss_rate import log_average_miss_rate
from nvcore.protocols import PROTOCOLS
from nvcore.session_file import read_session
from nvcore.significance import significance_table
from nvcore.units import find_units

SAMPLE = Path(__file__).resolve().parents[1] / "sample_data" / "session.toml"


def random_result(seed: int):
    truth, x, places = random_boxes(seed, n_frames=120)
    _, y, _ = random_boxes(seed + 100, n_frames=120)
    return compare(make_dataset(truth, x, [*y, *x[::2]], places=places))


@pytest.mark.parametrize("protocol", ["all", "reasonable"])
@pytest.mark.parametrize("seed", range(4))
def test_over_all_units_it_is_the_curves_own(seed: int, protocol: str):
    result = random_result(seed)
    figure = log_average_miss_rate_figure(result, find_units(result), PROTOCOLS[protocol])
    for sums, system in ((figure.x, result.x), (figure.y, result.y)):
        curve = detection_curve(result.dataset, system.name, result.params, PROTOCOLS[protocol])
        assert float(_log_average(sums.sum(axis=0))) == pytest.approx(log_average_miss_rate(curve))


def test_resamples_come_near_what_their_own_curve_gives():
    session = read_session(SAMPLE)
    dataset = load(session)
    result = analyse(dataset, effective_params(session, dataset))
    units = find_units(result)
    figure = log_average_miss_rate_figure(result, units)
    rng = np.random.default_rng(1)
    for _ in range(5):
        drawn = rng.integers(0, len(units), len(units))
        times = count_units(drawn[None], len(units))[0]
        found = float(_log_average(times @ figure.x))
        assert found == pytest.approx(plain_lamr(result, units, times), abs=0.01)


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


def test_it_stands_in_the_table_with_interval_and_p():
    session = read_session(SAMPLE)
    dataset = load(session)
    result = analyse(dataset, effective_params(session, dataset))
    units = find_units(result)
    table = significance_table(result, [log_average_miss_rate_figure(result, units)], units=units)
    row = table.set_index("figure").loc["log_average_miss_rate"]
    assert row["difference"] == pytest.approx(-0.0533, abs=1e-4)
    assert row["low"] < row["difference"] < row["high"]
    assert 0 < row["p"] <= 1
    assert row["better"] == "lower"


def test_without_scores_there_is_no_figure():
    truth, x, places = random_boxes(3)
    unscored = [box._replace(score=float("nan")) for box in x]
    result = compare(make_dataset(truth, unscored, x, places=places))
    assert log_average_miss_rate_figure(result, find_units(result)) is None


def test_without_pedestrians_there_is_no_figure():
    _, x, places = random_boxes(4)
    result = compare(make_dataset([], x, x[::2], places=places))
    assert log_average_miss_rate_figure(result, find_units(result)) is None
