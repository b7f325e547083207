"""What an estimate of the Driver page rests on."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from driver_estimators import CONTRAST, estimator

from nvcore.subjects.driver.features import FEATURE_KEYS
from ui.subjects.driver.basis import (
    NO_FEATURE,
    NO_PICTURE,
    NO_VALUE,
    NOT_RUN,
    OF_HEAT,
    outside_words,
    period_words,
    why_unknown,
)


def run_of(*, is_interpolated: bool = False, high: float = 100.0):
    """Of an estimator for 0.5 and 4.5 s; the first was trained on contrasts of 0 to `high`."""
    both = estimator()
    first = replace(both.regressions[0], high=np.array([high]))
    both = replace(both, regressions=(first, *both.regressions[1:]))
    return SimpleNamespace(estimator=both, is_interpolated=is_interpolated)


def features(contrast: float) -> pd.Series:
    values = np.zeros(len(FEATURE_KEYS))
    values[CONTRAST] = contrast
    return pd.Series(values, index=FEATURE_KEYS)


@pytest.mark.parametrize("is_interpolated", [False, True])
@pytest.mark.parametrize("period_s", [0.1, 0.5, 1.0, 2.5, 2.6, 4.5, 9.0, np.nan])
@pytest.mark.parametrize("high", [50.0, 100.0])
def test_a_feature_is_named_exactly_where_the_estimator_calls_it_outside(
    is_interpolated, period_s, high
):
    run = run_of(is_interpolated=is_interpolated, high=high)
    for contrast in (-1.0, 0.0, 50.0, 50.01, 100.0, 101.0):
        own = features(contrast)
        estimates = run.estimator.estimate(own.to_numpy(), period_s, interpolate=is_interpolated)
        assert bool(outside_words(run, own, period_s)) == estimates.is_outside[0]


def test_the_periods_of_the_estimators_that_are_taken_are_named():
    def words(run, *periods_s: float) -> list[str]:
        return [period_words(run, each).replace("\N{NO-BREAK SPACE}", " ") for each in periods_s]

    assert words(run_of(), 0.1, 2.5, 2.6, np.nan) == ["0.5 s"] * 2 + ["4.5 s"] * 2
    assert words(run_of(is_interpolated=True), 0.1, 2.5) == ["0.5 s", "0.5 and 4.5 s"]


def test_a_value_just_outside_has_digits_enough_to_be_told_from_the_range():
    assert outside_words(run_of(high=50.0), features(50.004), 0.5) == [
        "Luminance contrast 50.004, trained on 0.000 to 50.000 grey levels"
    ]
    between = outside_words(run_of(is_interpolated=True), features(101.0), 2.0)
    assert [words.rpartition("levels")[2] for words in between] == [" for 0.5 s", " for 4.5 s"]


def test_why_nothing_is_known_of_a_pedestrian():
    nothing = pd.DataFrame(np.full((2, len(FEATURE_KEYS)), np.nan), columns=FEATURE_KEYS)
    size = nothing.assign(height_px=60.0)
    grey, colour = (SimpleNamespace(may_be_of_heat=is_grey) for is_grey in (True, False))
    assert why_unknown(None, None, has_run=False) == NO_VALUE
    assert why_unknown(None, None, has_run=True) == NOT_RUN
    assert why_unknown(colour, None, has_run=True) == NO_VALUE  # features are of other boxes
    assert why_unknown(grey, size, has_run=True) == OF_HEAT
    assert why_unknown(colour, nothing, has_run=True) == NO_PICTURE
    assert why_unknown(colour, size, has_run=True) == NO_FEATURE
