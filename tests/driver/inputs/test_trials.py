"""When a picture of a trial is off time, and when two planned times are the same."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from nvcore.subjects.driver.inputs.study_tables import (
    LATE_S,
    TRIAL_COLUMNS,
    is_off_time,
    is_same_time,
)


@pytest.mark.parametrize("asked_s", [0.0, 1.0, 2.5, 7.0])
def test_what_is_late_by_just_the_limit_is_on_time_whatever_rounding_says(asked_s: float):
    assert not is_off_time(asked_s + LATE_S - asked_s)
    assert not is_off_time(asked_s - LATE_S - asked_s)
    assert is_off_time(asked_s + 1.01 * LATE_S - asked_s)
    assert not is_same_time(asked_s + LATE_S - asked_s)
    assert is_same_time(asked_s + 0.99 * LATE_S - asked_s)


def test_columns_are_taken_as_a_whole_and_what_was_not_measured_is_on_time():
    by_s = pd.Series([0.0, -0.06, np.nan])
    assert is_off_time(by_s).tolist() == [False, True, False]
    assert is_same_time(np.array([0.01, 1.0])).tolist() == [True, False]


def test_a_column_stands_there_once():
    assert len(set(TRIAL_COLUMNS)) == len(TRIAL_COLUMNS) == 13
