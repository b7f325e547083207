"""Driver page: data behind an estimate, and conditions unknown to its model."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.wording import listed
from nvcore.subjects.driver.estimators import Estimator
from nvcore.subjects.driver.features import FEATURE_KEYS, FEATURES
from nvcore.subjects.driver.running.estimate import EstimateRun
from nvcore.subjects.driver.running.run import RecordingFeatures

MOST_DIGITS: Final = 6
"""Maximum number of decimals to tell a feature from the end of the range."""
NO_BREAK: Final = "\N{NO-BREAK SPACE}"
NO_VALUE: Final = (
    "neither the ground truth nor the estimates of the session have a value. *Estimate*, above, "
    "computes it from pictures of visible light."
)
NOT_RUN: Final = (
    "this recording was not among those that were estimated. It needs pictures of visible light."
)
OF_HEAT: Final = (
    "the pictures of this recording are grey and may be far infrared, which says nothing about "
    "what eyes see. Where they are of visible light, name them as `visible` in the session."
)
NO_PICTURE: Final = "none of these frames has a picture."
NO_FEATURE: Final = "a feature that the estimator needs is not known in any of these frames."


def why_unknown(
    part: RecordingFeatures | None, features: pd.DataFrame | None, *, has_run: bool
) -> str:
    """Explain why a pedestrian's detectability is unknown in all frames.

    Parameters
    ----------
    part
        Results of the run for the pedestrian's recording. None: there are none.
    features
        Features of the pedestrian, frame by frame. None: unknown.
    has_run
        Whether a run of this session made estimates, for this recording or others.
    """
    if part is None or features is None:
        return NOT_RUN if has_run and part is None else NO_VALUE
    if part.may_be_of_heat:
        return OF_HEAT
    return NO_PICTURE if features[list(FEATURE_KEYS)].isna().all(axis=None) else NO_FEATURE


def period_words(run: EstimateRun, period_s: float) -> str:
    """Format the adaptation periods of the regressions in use, such as "7.5 s" or "3 and 4.5 s".

    Parameters
    ----------
    period_s
        Seconds since the change at the end of the frame. NaN: no known change.
    """
    rows = run.estimator.regression_rows(period_s, interpolate=run.is_interpolated)
    return f"{listed([f'{run.estimator.periods_s[row]:g}' for row in rows])}{NO_BREAK}s"


def longest_words(run: EstimateRun) -> str:
    """Format the longest adaptation period, such as "7.5 s". After it, eyes are adapted."""
    return f"{run.estimator.periods_s[-1]:g}{NO_BREAK}s"


def outside_words(run: EstimateRun, features: pd.Series, period_s: float) -> list[str]:
    """List the features outside of the training range, each with its value and the range.

    Parameters
    ----------
    features
        Features of the pedestrian in the frame, by key.
    period_s
        Same as in `period_words`.
    """
    values = features[list(FEATURE_KEYS)].to_numpy(np.float64)
    rows = run.estimator.regression_rows(period_s, interpolate=run.is_interpolated)
    return [
        f"{FEATURES[column].label} {_range_words(value, low, high)} {FEATURES[column].unit}"
        f"{f' for {run.estimator.periods_s[row]:g} s' if len(rows) > 1 else ''}"
        for row in rows
        for column, value, low, high in _beyond(run.estimator, row, values)
    ]


def _beyond(
    estimator: Estimator, row: int, values: np.ndarray
) -> list[tuple[int, float, float, float]]:
    """Return column, value and range of each feature outside of a regression's training range."""
    taken = estimator.regressions[row]
    is_outside = taken.outside(values[np.newaxis])[0]
    ranges = zip(taken.columns.tolist(), taken.low.tolist(), taken.high.tolist(), strict=True)
    return [
        (column, float(values[column]), low, high)
        for column, low, high in ranges
        if is_outside[column]
    ]


def _range_words(value: float, low: float, high: float) -> str:
    """Format a value and its range, such as "9.6, trained on 12.0 to 80.0".

    The decimals suffice to tell the value from the range.
    """
    bound = low if value < low else high
    digits = 1
    while digits < MOST_DIGITS and f"{value:.{digits}f}" == f"{bound:.{digits}f}":
        digits += 1
    shown, first, last = (f"{number:.{digits}f}" for number in (value, low, high))
    return f"{shown}, trained on {first} to {last}"
