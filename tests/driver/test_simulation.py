"""A simulated change of light: which frames it is of, and what is estimated of them."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from driver_estimators import origin, regression

from nvcore.common.errors import ParameterError
from nvcore.subjects.driver.estimators import Estimator, Quality
from nvcore.subjects.driver.features import FEATURE_KEYS
from nvcore.subjects.driver.running.estimate import simulate_change

END_S = np.array([1.0, 2.0, 3.0, 8.0])


ESTIMATOR = Estimator(
    "test",
    np.array([0.5, 4.5]),
    tuple(regression(0, offset=share) for share in (0.2, 0.9, 0.5)),
    (Quality(51, 0.01, 0.5, 0.1),) * 3,
    origin(),
)


def features(period_s: float | list[float]) -> pd.DataFrame:
    table = pd.DataFrame(dict.fromkeys(FEATURE_KEYS, 50.0), index=[3, 4, 5, 6])
    return table.assign(period_s=period_s)


def test_from_the_change_on_the_eyes_adapt_anew():
    table = simulate_change(features(math.nan), END_S, 1.5, ESTIMATOR)
    np.testing.assert_array_equal(table["period_s"], [math.nan, 0.5, 1.5, 6.5])
    assert table["detectability"].tolist() == pytest.approx([0.9, 0.2, 0.2, 0.9])
    assert table["is_simulated"].tolist() == [False, True, True, True]
    assert table.index.tolist() == [3, 4, 5, 6]


def test_a_real_change_before_it_holds_until_it_and_one_after_it_from_then_on():
    table = simulate_change(features([0.4, 1.4, 2.4, 0.3]), END_S, 1.5, ESTIMATOR)
    np.testing.assert_allclose(table["period_s"], [0.4, 0.5, 1.5, 0.3])
    assert table["is_simulated"].tolist() == [False, True, True, False]


def test_it_does_not_come_back_where_the_light_is_back_after_a_real_change():
    periods = [math.nan, math.nan, 0.6, math.nan]  # a real change at 2.4 s, which is over at 8 s
    table = simulate_change(features(periods), END_S, 1.5, ESTIMATOR)
    np.testing.assert_allclose(table["period_s"], [math.nan, 0.5, 0.6, math.nan])
    assert table["is_simulated"].tolist() == [False, True, False, False]


def test_a_real_change_that_begins_and_ends_between_two_rows_can_be_told():
    table = simulate_change(features(math.nan), END_S, 1.5, ESTIMATOR, real_s=np.array([0.5, 3.4]))
    np.testing.assert_allclose(table["period_s"], [math.nan, 0.5, 1.5, math.nan])
    assert table["is_simulated"].tolist() == [False, True, True, False]


def test_the_features_file_stays_as_it_is():
    table = features(math.nan)
    simulate_change(table, END_S, 1.5, ESTIMATOR)
    pd.testing.assert_frame_equal(table, features(math.nan))


def test_a_change_at_no_time_is_refused():
    with pytest.raises(ParameterError, match="seconds from the first frame, found nan"):
        simulate_change(features(math.nan), END_S, math.nan, ESTIMATOR)
