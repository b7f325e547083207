"""Study planning: required number of recordings, power, and non-inferiority."""

from nvcore.evidence.planning.notes import notes_for_verdict, notes_of_plan
from nvcore.evidence.planning.pilot import PLAN_KEYS, Pilot, judge_key, make_pilot, plan_key
from nvcore.evidence.planning.plan import (
    NonInferiority,
    Plan,
    PlanSize,
    judge_noninferiority,
    plan_recordings,
    worse_at_most,
)
from nvcore.evidence.planning.power import PowerPoint

__all__ = [
    "PLAN_KEYS",
    "NonInferiority",
    "Pilot",
    "Plan",
    "PlanSize",
    "PowerPoint",
    "judge_key",
    "judge_noninferiority",
    "make_pilot",
    "notes_for_verdict",
    "notes_of_plan",
    "plan_key",
    "plan_recordings",
    "worse_at_most",
]
