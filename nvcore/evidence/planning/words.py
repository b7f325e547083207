"""What a plan says, in sentences for verdict, page, report and command line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from nvcore.evidence.measures import Evidence
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.planning.noninferiority import NonInferiority
from nvcore.evidence.planning.pilot import MIN_PILOT
from nvcore.evidence.units import RECORDINGS
from nvcore.measures.table import difference_text, evidence_form, size_text
from nvcore.sentences.texts import UNEQUAL_POINTS
from nvcore.wording import capitalised, count_text, difference, duration_text, number, percent

if TYPE_CHECKING:
    from nvcore.evidence.planning.plan import Assumption, Plan, PlanSize

QUESTION: Final = "How much more would it take?"
ASSUMPTIONS: Final[dict[Assumption, str]] = {
    "as found": "difference as found",
    "as named": "difference as named",
    "equal": "X and Y equal",
}
"""What is assumed of the true difference."""
OPTIMISTIC: Final = (
    "A difference that a few recordings happen to show tends to be larger than the true one, and "
    "the study planned for it too small: name the smallest difference that would matter instead."
)
UNEQUAL: Final = (
    f"{UNEQUAL_POINTS}: nothing is claimed from these settings, and equally many false alarms "
    "would give other numbers. Set thresholds that give these first."
)
FRESH: Final = (
    "This is the size of a study of its own, whose end is set before it begins: recordings added "
    "until p is small enough show differences that are not there."
)


def describe_plan(plan: Plan) -> tuple[str, ...]:
    """What these recordings show, what they exclude, and how many would show more."""
    row = plan.evidence
    sentences = [_state(plan)]
    if plan.is_unequal:
        sentences.append(UNEQUAL)
    if plan.noninferiority is not None:
        sentences.append(describe_noninferiority(plan.noninferiority, row))
    sentences.append(describe_excluded(row))
    sentences += [_size(plan, size) for size in plan.sizes]
    if any(size.n_recordings is not None for size in plan.sizes):
        sentences.append(_level(plan))
        if [size.assumption for size in plan.sizes] == ["as found"]:
            sentences.append(OPTIMISTIC)
        sentences.append(FRESH)
    return tuple(sentences)


def plan_sentence(plan: Plan) -> str:
    """The plan for the difference as found, for the verdict; empty if nothing can be said."""
    row, size = plan.evidence, plan.sizes[-1]
    excluded = "" if row.unit != RECORDINGS or math.isnan(row.low) else describe_excluded(row)
    if plan.noninferiority is not None or size.n_recordings is None:
        return excluded
    noun = row.label.partition(", by ")[0]
    sentence = (
        f"About {_extent(size)} would show a difference in the {noun} as large as here "
        f"({difference_text(size.difference, row.figure)}; p at most {SIGNIFICANT:g} by itself) in "
        f"{percent(plan.power)} of studies"
    )
    return f"{sentence}. {excluded}".rstrip()


def describe_excluded(row: Evidence) -> str:
    """Which differences the 95 % interval excludes."""
    if row.unit != RECORDINGS:
        return (
            "No difference can be excluded for other recordings: stretches of these say nothing of "
            "others."
        )
    if math.isnan(row.low):
        return f"No difference can be excluded: {row.note or 'there is no interval'}."
    low, high = (difference_text(end, row.figure) for end in (row.low, row.high))
    # as if it were the only measure, unlike the verdict's own tests
    is_clear = row.low * row.high > 0
    alone = " (of this measure by itself, not corrected for the others)" if is_clear else ""
    return (
        f"These {count_text(row.n, 'recording')} exclude, at 95 %, a difference X - Y below {low} "
        f"or above {high}{alone}."
    )


def describe_noninferiority(answer: NonInferiority, row: Evidence) -> str:
    """Whether the candidate is at most the margin worse, and what the interval says."""
    candidate, other = answer.candidate.upper(), "Y" if answer.candidate == "x" else "X"
    question = (
        f"that {candidate} is at most {size_text(answer.margin, row.figure)} worse than {other}"
    )
    if answer.is_shown is None:
        return f"It cannot be said {question}: {answer.reason}."
    end = answer.worse_at_most
    limit = (
        f"at worst {size_text(end, row.figure)} worse"
        if end > 0
        else f"at least {size_text(end, row.figure)} better"
    )
    outcome = "shown" if answer.is_shown else "not shown"
    return f"It is {outcome} {question}: by the 95 % interval, {candidate} is {limit}."


def _state(plan: Plan) -> str:
    row = plan.evidence
    form = evidence_form(row.figure)
    values = ", ".join(f"{letter.upper()} {number(getattr(row, letter), form)}" for letter in "xy")
    p = f"; p = {row.p:.2g} by itself" if row.unit == RECORDINGS and not math.isnan(row.p) else ""
    few = ""
    if plan.n_differing is not None and plan.n_differing < MIN_PILOT:
        few = (
            f" Only {plan.n_differing} of the recordings tell X and Y apart: all that follows "
            "rests on these."
        )
    return (
        f"{capitalised(row.label)}: {values}, X - Y {difference(row.x, row.y, form)}, in "
        f"{count_text(row.n, row.unit.removesuffix('s'))} with "
        f"{count_text(plan.n_encounters, 'encounter')}{p}.{few}"
    )


def _size(plan: Plan, size: PlanSize) -> str:
    key = plan.evidence.figure
    amount = difference_text(size.difference, key)
    condition = ""
    if plan.noninferiority is not None:
        margin, candidate = plan.noninferiority.margin, plan.noninferiority.candidate.upper()
        condition = (
            "If X and Y are equal: "
            if size.assumption == "equal"
            else f"If the difference is as found here ({amount}): "
        )
        what = f"that {candidate} is at most {size_text(margin, key)} worse"
    elif size.assumption == "as named":
        what = f"a difference of {size_text(size.difference, key)}"
    else:
        what = f"a difference as found here ({amount})"
    if size.n_recordings is None:
        return f"{condition or f'{capitalised(what)}: '}– ({size.reason})."
    about = "about" if condition else "About"
    return (
        f"{condition}{about} {_extent(size)} would show {what} in {percent(plan.power)} of studies "
        f"(simulated: {percent(size.power)}, {percent(size.power_low)} to "
        f"{percent(size.power_high)}). Judged by {count_text(plan.evidence.n, 'recording')}, the "
        f"number itself is uncertain: {size.least_recordings:,} to {size.most_recordings:,}."
    )


def _extent(size: PlanSize) -> str:
    assert size.n_recordings is not None
    assert size.n_encounters is not None
    return (
        f"{count_text(size.n_recordings, 'recording')} like these "
        f"({count_text(size.n_encounters, 'encounter')}, {duration_text(size.duration_s)})"
    )


def _level(plan: Plan) -> str:
    if plan.noninferiority is not None:
        return (
            "A study shows it where the whole 95 % interval is on the better side of the margin: a "
            "one-sided test at 2.5 %."
        )
    if plan.n_tests == 1:
        return (
            "A study shows it where p, of this measure by itself, is at most 0.05: tested beside "
            "others, for which p is corrected, it takes more recordings."
        )
    return (
        f"A study shows it where p, corrected for {plan.n_tests} measures, is at most 0.05 "
        f"({plan.level:.2g} by itself)."
    )
