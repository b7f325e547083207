"""One system against the truth: every metric of it, and what a new setting can reuse."""

from nvcore.scoring.result import SystemResult
from nvcore.scoring.step import (
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
from nvcore.scoring.system import STEPS, score_system

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
