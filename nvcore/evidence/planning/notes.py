"""Notes on a plan, for the verdict, the page, the report and the command line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from nvcore.common.wording import difference
from nvcore.comparison.measures.table import evidence_form
from nvcore.evidence.measures import Evidence
from nvcore.evidence.planning.pilot import MIN_PILOT
from nvcore.evidence.units import WHOLE
from nvcore.notes import Note

if TYPE_CHECKING:
    from nvcore.evidence.planning.plan import Assumption, NonInferiority, Plan, PlanSize

QUESTION: Final = "How much more would it take?"
ASSUMPTIONS: Final[dict[Assumption, str]] = {
    "as found": "difference as found",
    "as named": "difference as named",
    "equal": "X and Y equal",
}
"""Labels of the assumptions about the true difference."""


def notes_of_plan(plan: Plan) -> tuple[Note, ...]:
    """Return notes on the difference found, the differences excluded, and study sizes."""
    row, answer = plan.evidence, plan.noninferiority
    form = evidence_form(row.figure)
    has_p = row.unit in WHOLE and not math.isnan(row.p)
    found = Note(
        "plan.found",
        label=row.label,
        x=row.x,
        y=row.y,
        form=form,
        difference=difference(row.x, row.y, form),
        n=row.n,
        units=row.unit,
        n_encounters=plan.n_encounters,
        p=row.p if has_p else None,
    )
    notes = [found]
    if plan.n_differing is not None and plan.n_differing < MIN_PILOT:
        notes.append(Note("plan.few_differ", n=plan.n_differing))
    if plan.is_unequal:
        notes.append(Note("plan.unequal"))
    if answer is not None:
        notes.append(_not_worse(answer, row))
    notes += [excluded(row), *(_size(plan, size) for size in plan.sizes)]
    if any(size.n_recordings is not None for size in plan.sizes):
        notes.append(_level(plan))
        if [size.assumption for size in plan.sizes] == ["as found"]:
            notes.append(Note("plan.optimistic"))
        notes.append(Note("plan.fresh"))
    return tuple(notes)


def notes_for_verdict(plan: Plan) -> tuple[Note, ...]:
    """Return notes on the study size that would show the difference as found, or on having none.

    A plan without a pilot, or for non-inferiority, only says which differences are excluded.
    """
    row, size = plan.evidence, plan.sizes[-1]
    ends = _known_ends(row)
    if plan.noninferiority is not None or plan.n_differing is None:
        return ends
    extent = _extent(size)
    if extent is None:
        return _size(plan, size), *ends
    needed = Note(
        "plan.needed",
        extent=extent,
        noun=row.label.partition(", by ")[0].partition(" (")[0],
        key=row.figure,
        difference=size.difference,
        power=plan.power,
        least=size.least_recordings or 0,
        most=size.most_recordings or 0,
    )
    return needed, *ends


def notes_before_plan(row: Evidence, command: str) -> tuple[Note, ...]:
    """Return notes on excluded differences and on the command that plans, if either is known."""
    can_plan = row.unit in WHOLE and row.n >= MIN_PILOT
    return (*_known_ends(row), *([Note("plan.command", command=command)] if can_plan else []))


def _known_ends(row: Evidence) -> tuple[Note, ...]:
    return () if row.unit not in WHOLE or math.isnan(row.low) else (excluded(row),)


def excluded(row: Evidence) -> Note:
    """Return a note on the differences that a measure's 95 % confidence interval excludes."""
    if row.unit not in WHOLE:
        return Note("plan.blocks")
    if math.isnan(row.low):
        return Note("plan.no_interval", reason=row.note or "there is no interval")
    return Note("plan.excluded", key=row.figure, n=row.n, low=row.low, high=row.high)


def _not_worse(answer: NonInferiority, row: Evidence) -> Note:
    return Note(
        "plan.not_worse",
        key=row.figure,
        candidate=answer.candidate,
        other="y" if answer.candidate == "x" else "x",
        margin=answer.margin,
        is_shown=answer.is_shown,
        end=None if answer.is_shown is None else answer.worse_at_most,
        reason=answer.reason,
    )


def _size(plan: Plan, size: PlanSize) -> Note:
    key, answer, assumed = plan.evidence.figure, plan.noninferiority, None
    if answer is not None:
        of_answer = {"margin": answer.margin, "candidate": answer.candidate}
        sought = Note("plan.within_margin", key=key, **of_answer)
        is_equal = size.assumption == "equal"
        as_found = Note("plan.if_as_found", key=key, difference=size.difference)
        assumed = Note("plan.if_equal") if is_equal else as_found
    elif size.assumption == "as named":
        sought = Note("plan.as_named", key=key, difference=size.difference)
    else:
        sought = Note("plan.as_found", key=key, difference=size.difference)
    extent = _extent(size)
    if extent is None:
        return Note("plan.no_size", about=assumed or sought, reason=size.reason)
    return Note(
        "plan.size",
        assumed=assumed,
        extent=extent,
        sought=sought,
        power=plan.power,
        simulated=size.power,
        n_pilot=plan.evidence.n,
        least=size.least_recordings or 0,
        most=size.most_recordings or 0,
    )


def _level(plan: Plan) -> Note:
    if plan.noninferiority is not None:
        return Note("plan.level_of_margin")
    of = {"has_equal_alarms": plan.has_equal_alarms}
    if plan.n_tests == 1:
        return Note("plan.level_alone", **of)
    return Note("plan.level_corrected", n_tests=plan.n_tests, level=plan.level, **of)


def _extent(size: PlanSize) -> Note | None:
    if size.n_recordings is None or size.n_encounters is None:
        return None
    return Note(
        "plan.extent",
        n_recordings=size.n_recordings,
        n_encounters=size.n_encounters,
        duration_s=size.duration_s,
    )
