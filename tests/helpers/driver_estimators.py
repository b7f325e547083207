"""Estimators made by hand."""

from __future__ import annotations

import numpy as np

from nvcore.subjects.driver.estimators import Estimator, Origin, Quality, Regression
from nvcore.subjects.driver.estimators.model import SvrSettings

CONTRAST, LAB = 3, 4
"""Columns of the features."""


def regression(
    column: int, *, share: float = 0.0, offset: float = 0.0, high: float = 100.0
) -> Regression:
    """This share of a hundredth of a feature and an offset; trained on features of 0 to `high`."""
    return Regression(
        columns=np.array([column]),
        centre=np.zeros(1),
        scale=np.full(1, 100.0),
        low=np.zeros(1),
        high=np.full(1, high),
        vectors=np.ones((1, 1)),
        weights=np.array([share]),
        offset=offset,
        settings=SvrSettings("linear", 1.0, 0.1, 1.0),
    )


def origin(simulated: str = "no") -> Origin:
    """Of 306 trials of four subjects with 51 pedestrians."""
    return Origin(51, 4, 306, simulated, 200.0, 0.5, 0.5, 0, "ab")


def estimator(column: int = CONTRAST, simulated: str = "no") -> Estimator:
    """Half of the contrast soon after the change, all of it at 4.5 s."""
    return Estimator(
        "test",
        np.array([0.5, 4.5]),
        tuple(regression(column, share=share) for share in (0.5, 1.0, 0.7)),
        tuple(Quality(51, error, 0.5, 0.1) for error in (0.01, 0.04, 0.09)),
        origin(simulated),
    )
