"""Scoring step that judges what the driver sees, and weights of misses from detectability."""

from __future__ import annotations

from typing import Final, cast

import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import Inputs, MissWeights, ScoringStep
from nvcore.metrics.proximity import Weights
from nvcore.subjects.driver.comparison.judging import DriverView, judge_driver, weigh_unseen
from nvcore.subjects.driver.comparison.settings import DRIVER


def _judge(at: Inputs, k_truth: Weights) -> pd.DataFrame:
    return judge_driver(at.dataset.detectability, at.encounters, k_truth.k, at.params)


STEPS: Final = (ScoringStep("detectable", _judge, (DRIVER,), ("k_truth",), of="truth"),)
MISS_WEIGHTS: Final = MissWeights("(1 - detectability)", weigh_unseen)


def driver_view(result: Result) -> DriverView:
    """Combine whom the driver sees with the encounters that X and Y detect."""
    detected = (system.encounters["is_detected"].to_numpy() for _, system in result.sides)
    return DriverView(result.made["detectable"], result.is_near, *detected)


def driver_in(result: Result) -> DriverView:
    """Return the driver's view of a comparison, ``result.of("driver")``, as `DriverView`."""
    return cast("DriverView", result.of("driver"))
