"""Estimators made by hand."""

from __future__ import annotations

import numpy as np

from nvcore.driver.estimators import Estimator, Origin, Quality, Regression
from nvcore.driver.estimators.model import SvrSettings

CONTRAST, LAB = 3, 4
"""Columns of the features."""


def by(column: int, share: float) -> Regression:
    """A regression that gives this share of a hundredth of a feature, trained on 0 to 100."""
    return Regression(
        columns=np.array([column]),
        centre=np.zeros(1),
        scale=np.full(1, 100.0),
        low=np.zeros(1),
        high=np.full(1, 100.0),
        vectors=np.ones((1, 1)),
        weights=np.array([share]),
        offset=0.0,
        settings=SvrSettings("linear", 1.0, 0.1, 1.0),
    )


def estimator(column: int = CONTRAST, simulated: str = "no") -> Estimator:
    """Half of the contrast soon after the change, all of it at 4.5 s."""
    origin = Origin(51, 4, 306, simulated, 200.0, 0.5, 0.5, 0, "ab")
    return Estimator(
        "test",
        np.array([0.5, 4.5]),
        (by(column, 0.5), by(column, 1.0), by(column, 0.7)),
        tuple(Quality(51, error, 0.5, 0.1) for error in (0.01, 0.04, 0.09)),
        origin,
    )
