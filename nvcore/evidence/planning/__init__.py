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
from nvcore.evidence.planning.said import facts_for_verdict, facts_of_plan

__all__ = [
    "PLAN_KEYS",
    "NonInferiority",
    "Pilot",
    "Plan",
    "PlanSize",
    "PowerPoint",
    "facts_for_verdict",
    "facts_of_plan",
    "judge_key",
    "judge_noninferiority",
    "make_pilot",
    "plan_key",
    "plan_recordings",
    "worse_at_most",
]
