"""How much more would it take? Power of studies like the recordings at hand, non-inferiority."""

from nvcore.evidence.planning.noninferiority import (
    NonInferiority,
    judge_noninferiority,
    worse_at_most,
)
from nvcore.evidence.planning.pilot import (
    PLAN_KEYS,
    Pilot,
    judge_key,
    make_pilot,
    plan_key,
)
from nvcore.evidence.planning.plan import Plan, PlanSize, plan_recordings
from nvcore.evidence.planning.power import PowerPoint
from nvcore.evidence.planning.words import describe_plan, plan_sentence

__all__ = [
    "PLAN_KEYS",
    "NonInferiority",
    "Pilot",
    "Plan",
    "PlanSize",
    "PowerPoint",
    "describe_plan",
    "judge_key",
    "judge_noninferiority",
    "make_pilot",
    "plan_key",
    "plan_recordings",
    "plan_sentence",
    "worse_at_most",
]
