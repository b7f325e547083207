"""Describe estimators in words: chosen features, and reasons to doubt estimates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.driver.estimators.model import Estimator
from nvcore.driver.features import FEATURE_KEYS, FEATURES
from nvcore.driver.inputs.record import EstimateRecord

LABELS: Final = {feature.key: feature.label for feature in FEATURES}
"""What each feature is called."""


def words_of(keys: Sequence[str]) -> str:
    """Describe a choice of features in words.

    Examples
    --------
    >>> words_of(["width_px", "edge_contrast"])
    'Width + Edge contrast'
    """
    return (
        "all eight" if len(keys) == len(FEATURE_KEYS) else " + ".join(LABELS[key] for key in keys)
    )


def caution_of(estimator: Estimator, *, simulated: str = "") -> str:
    """Return why an estimator is doubtful whatever the pictures, or "" without a reason.

    Parameters
    ----------
    simulated
        As of its origin; empty: nothing is said of it.
    """
    return EstimateRecord(
        simulated=simulated,
        no_better_at_s=estimator.no_better_at_s,
        of_no_use=estimator.is_of_no_use,
        search=estimator.origin.search,
    ).caution
