"""Section on how many recordings would show the differences that these do not."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import pandas as pd

from nvcore.arguments.plan import PlanArguments
from nvcore.comparison import Result
from nvcore.evidence.measures import evidence_of
from nvcore.evidence.operating_points import are_unequal
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.planning.notes import QUESTION
from nvcore.evidence.planning.pilot import MIN_PILOT, PLAN_KEYS
from nvcore.evidence.planning.plan import Plan, PlanSize, plan_recordings
from nvcore.evidence.planning.thresholds import vary_thresholds
from nvcore.evidence.units import WHOLE, find_units
from nvcore.measures.table import doubt_of, evidence_form, measure_of, repeated_by
from nvcore.notes import Note, say
from nvcore.progress import Progress, part_of
from nvcore.protocols import Protocol
from nvcore.report.html import words
from nvcore.report.html.blocks import Block, Section, Sentences, table
from nvcore.wording import UNDEFINED, capitalised, difference, duration_text, percent

HEAD: Final = (
    "Measure",
    "X − Y",
    "Excluded: below",
    "Excluded: above",
    "Recordings",
    "Or rather",
    "Encounters",
    "Time",
)


def plan_measures(
    result: Result, evidence: pd.DataFrame, protocol: Protocol, *, progress: Progress
) -> dict[str, Plan]:
    """A plan for each measure of which no difference is shown, by key; empty without a pilot.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result.
    protocol
        Which pedestrians count in the log-average miss rate.
    """
    if not _has_pilot(evidence):
        return {}
    not_shown = [
        (name, key, row)
        for name, key in PLAN_KEYS.items()
        if (row := evidence_of(evidence, key)) is not None
        and not repeated_by(key)
        and not doubt_of(result, measure_of(key))
        and not row.p_corrected <= SIGNIFICANT
    ]
    n, units = len(not_shown), find_units(result)
    thresholds = vary_thresholds(result, units) if not_shown else {}
    return {
        key: plan_recordings(
            result,
            PlanArguments(name),
            protocol=protocol,
            units=units,
            evidence=row,
            thresholds=thresholds,
            progress=part_of(progress, index / n, (index + 1) / n),
        )
        for index, (name, key, row) in enumerate(not_shown)
    }


def _has_pilot(evidence: pd.DataFrame) -> bool:
    return bool(evidence["unit"].isin(WHOLE).any())


def plan_section(result: Result, evidence: pd.DataFrame, plans: Mapping[str, Plan]) -> Section:
    """A row for each plan, or why there is none.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result.
    plans
        Of `plan_measures`.
    """
    blocks: list[Block]
    if not _has_pilot(evidence):
        why_not = f"There is no plan: it needs a pilot of {MIN_PILOT} recordings or more."
        blocks = [Sentences((why_not,))]
    elif not plans:
        none_left = f"No p is above {SIGNIFICANT:g} after correction: nothing to plan for."
        blocks = [Sentences((none_left,))]
    else:
        share = percent(PlanArguments.power)
        caption = f"Recordings that would show a difference as found, in {share} of studies"
        rows = [_row(plan) for plan in plans.values()]
        reasons = " ".join(
            f"{capitalised(plan.evidence.label)}: {plan.sizes[0].reason}."
            for plan in plans.values()
            if plan.sizes[0].reason
        )
        advice = [Note("plan.optimistic"), Note("plan.fresh")]
        advice += [Note("plan.unequal")] if are_unequal(result) else []
        blocks = [
            table(caption, HEAD, rows, right=range(1, 8), note=reasons),
            Sentences(tuple(say(of, result.objects) for of in advice)),
        ]
    return Section("plan", QUESTION.rstrip("?"), words.PLAN, tuple(blocks))


def _row(plan: Plan) -> tuple[str, ...]:
    key, row, (size,) = plan.evidence.figure, plan.evidence, plan.sizes
    texts = [
        difference(value, 0, evidence_form(key)) for value in (row.difference, row.low, row.high)
    ]
    if size.n_recordings is None:
        return (row.label, *texts, *[UNDEFINED] * 4)
    return (row.label, *texts, *_size(size))


def _size(size: PlanSize) -> tuple[str, ...]:
    return (
        f"{size.n_recordings:,}",
        f"{size.least_recordings:,} to {size.most_recordings:,}",
        f"{size.n_encounters:,}",
        duration_text(size.duration_s),
    )
