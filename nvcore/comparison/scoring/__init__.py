"""Scoring of one system against the truth, reusing results that a new setting does not change."""

from nvcore.comparison.scoring.result import SystemResult
from nvcore.comparison.scoring.step import (
    Inputs,
    Made,
    Memo,
    MissWeights,
    ScoringStep,
    SystemInputs,
    miss_factors,
    steps_of,
    weigh_misses,
)
from nvcore.comparison.scoring.system import STEPS, score_system

__all__ = [
    "STEPS",
    "Inputs",
    "Made",
    "Memo",
    "MissWeights",
    "ScoringStep",
    "SystemInputs",
    "SystemResult",
    "miss_factors",
    "score_system",
    "steps_of",
    "weigh_misses",
]
