"""What a plan says, as facts for verdict, page, report and command line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from nvcore.evidence.measures import Evidence
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.planning.noninferiority import NonInferiority
from nvcore.evidence.planning.pilot import MIN_PILOT
from nvcore.evidence.units import WHOLE
from nvcore.measures.table import evidence_form
from nvcore.sentences.facts import Amount, Fact
from nvcore.sentences.planning import (
    Advice,
    Apart,
    Assumed,
    Excluded,
    FewDiffer,
    Found,
    NeededRecordings,
    NotWorse,
    SignificanceLevel,
    Size,
    Sought,
    StudyExtent,
)
from nvcore.wording import difference

if TYPE_CHECKING:
    from nvcore.evidence.planning.plan import Assumption, Plan, PlanSize

QUESTION: Final = "How much more would it take?"
ASSUMPTIONS: Final[dict[Assumption, str]] = {
    "as found": "difference as found",
    "as named": "difference as named",
    "equal": "X and Y equal",
}
"""What is assumed of the true difference."""


def facts_of_plan(plan: Plan) -> tuple[Fact, ...]:
    """What these recordings show, what they exclude, and how many would show more."""
    row, answer = plan.evidence, plan.noninferiority
    form = evidence_form(row.figure)
    has_p = row.unit in WHOLE and not math.isnan(row.p)
    facts: list[Fact] = [
        Found(
            label=row.label,
            x=Amount(row.x, form),
            y=Amount(row.y, form),
            difference=difference(row.x, row.y, form),
            n=row.n,
            unit=row.unit.removesuffix("s"),
            n_encounters=plan.n_encounters,
            p=row.p if has_p else None,
        )
    ]
    if plan.n_differing is not None and plan.n_differing < MIN_PILOT:
        facts.append(FewDiffer(plan.n_differing))
    if plan.is_unequal:
        facts.append(Advice("unequal"))
    if answer is not None:
        facts.append(_not_worse(answer, row))
    facts += [excluded(row), *(_size(plan, size) for size in plan.sizes)]
    if any(size.n_recordings is not None for size in plan.sizes):
        of_difference = SignificanceLevel(
            "alone" if plan.n_tests == 1 else "corrected", plan.n_tests, plan.level
        )
        facts.append(of_difference if answer is None else SignificanceLevel("margin"))
        if [size.assumption for size in plan.sizes] == ["as found"]:
            facts.append(Advice("optimistic"))
        facts.append(Advice("fresh"))
    return tuple(facts)


def facts_for_verdict(plan: Plan) -> tuple[Fact, ...]:
    """The plan for the difference as found; none if nothing can be said."""
    row, size = plan.evidence, plan.sizes[-1]
    ends = () if row.unit not in WHOLE or math.isnan(row.low) else (excluded(row),)
    extent = _extent(size)
    if plan.noninferiority is not None or extent is None:
        return ends
    noun = row.label.partition(", by ")[0].partition(" (")[0]
    apart = Apart(size.difference, row.figure)
    return NeededRecordings(extent, noun, apart, SIGNIFICANT, plan.power), *ends


def excluded(row: Evidence) -> Excluded:
    """Which differences the 95 % interval excludes."""
    if row.unit not in WHOLE:
        return Excluded("blocks")
    if math.isnan(row.low):
        return Excluded("none", reason=row.note or "there is no interval")
    # as if it were the only measure, unlike the verdict's own tests
    ends = Apart(row.low, row.figure), Apart(row.high, row.figure)
    return Excluded("also 0" if row.low * row.high > 0 else "some", row.n, *ends)


def _not_worse(answer: NonInferiority, row: Evidence) -> NotWorse:
    other = "y" if answer.candidate == "x" else "x"
    of = answer.candidate, other, Apart(answer.margin, row.figure)
    if answer.is_shown is None:
        return NotWorse("open", *of, reason=answer.reason)
    end = Apart(answer.worse_at_most, row.figure)
    if answer.is_shown:
        return NotWorse("shown worse" if end.value > 0 else "shown better", *of, end)
    return NotWorse("not shown worse" if end.value > 0 else "not shown better", *of, end)


def _size(plan: Plan, size: PlanSize) -> Size:
    key, answer = plan.evidence.figure, plan.noninferiority
    apart = Apart(size.difference, key)
    assumed = None
    if answer is not None:
        sought = Sought("margin", Apart(answer.margin, key), answer.candidate)
        assumed = Assumed("equal" if size.assumption == "equal" else "found", apart)
    else:
        sought = Sought("named" if size.assumption == "as named" else "found", apart)
    return Size(
        sought=sought,
        assumed=assumed,
        extent=_extent(size),
        power=plan.power,
        simulated=(size.power, size.power_low, size.power_high),
        n_pilot=plan.evidence.n,
        least=size.least_recordings or 0,
        most=size.most_recordings or 0,
        reason=size.reason,
    )


def _extent(size: PlanSize) -> StudyExtent | None:
    if size.n_recordings is None or size.n_encounters is None:
        return None
    return StudyExtent(size.n_recordings, size.n_encounters, size.duration_s)
