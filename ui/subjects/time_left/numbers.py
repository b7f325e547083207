"""Time left page: encounters confirmed in time, in words and numbers, with uncertainty."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import streamlit as st

from nvcore.common.wording import difference, interval_text, minus, number
from nvcore.common.wording.footnotes import Footnotes
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import evidence_form
from nvcore.evidence.companions import judge_keys
from nvcore.evidence.measures import Evidence
from nvcore.evidence.units import BLOCKS
from nvcore.notes import Note
from nvcore.report.words import WITHIN, WITHIN_NOTE
from nvcore.settings.stages import THRESHOLD
from nvcore.subjects.time_left.by_class import IMPACT, SHARE
from nvcore.subjects.time_left.kinds import TimeLeft, Urgency
from nvcore.subjects.time_left.notes import confirmed, few_urgent, needed, urgent
from nvcore.subjects.time_left.section import by_class
from nvcore.subjects.time_left.settings import TIME_LEFT
from nvcore.subjects.time_left.steps import time_left_in
from nvcore.tables.scorecard import score_rows
from ui.session import state
from ui.session.results import comparison_key
from ui.widgets.html import MeasureRow, measures_html, score_row
from ui.widgets.section import draw_table_of
from ui.widgets.text import UNDEFINED, docs_link, plain, short_names

KEYS: Final = (*(kind.value for kind in TimeLeft), IMPACT, "median_margin_s")
MEANING: Final = """
*In time*: matched in {n:g} of {m:g} frames in a row at some time before the last chance, if lost
again as well. *Late*: only then or later; the car brakes too late and reaches the {one} with the
*impact speed*. *Never*: the car does not brake.

In time means that a warning could have come early enough, not that the driver would have heeded it,
nor that {nobody} is hurt: {many} are taken to go on as they do, the car to drive on at its speed.
Time to contact comes from {source}. Whether a difference is more than chance is tested on the
Overview ({link}).
"""


def draw(result: Result) -> None:
    """Draw the counts, the measures with intervals, and how early a warning must come."""
    with st.container(key="time_left_headline"):
        for fact in confirmed(result):
            st.header(plain(state.say(fact)), anchor=False, help=_meaning(result))
    if not time_left_in(result).is_urgent.any():
        _draw_nobody(result)
        return
    left, right = st.columns([5, 4], gap="large")
    with left:
        _draw_measures(result)
    with right:
        _draw_needed(result)
        st.caption(_urgency(result))


def _urgency(result: Result) -> str:
    note = urgent(result) or Note("time_left.nobody_met")
    return plain(state.say(note))


def _draw_nobody(result: Result) -> None:
    """Draw why no encounter is urgent, and which settings could change that."""
    link = docs_link("Time left", "time-left")
    if not len(result.encounters):
        st.info(
            state.say("The truth has no {many}: there is {nobody} {whom} the car comes near to.")
        )
        return
    n_unknown = time_left_in(result).count_urgency()[Urgency.UNKNOWN]
    if n_unknown == len(result.encounters):
        st.info(f"{_urgency(result)} Nothing can be said of any of them ({link}).")
    else:
        st.info(
            f"{_urgency(result)} So nobody"
            f"{', as far as is known,' if n_unknown else ''} has to be told by a last chance, and "
            "neither system is better in that. A higher speed or a longer reaction time, in the "
            f"sidebar, may make others urgent ({link})."
        )


def _draw_measures(result: Result) -> None:
    evidence = _evidence(result)
    notes = Footnotes()
    rows: list[MeasureRow] = []
    for row in score_rows(result):
        if row.key not in KEYS:
            continue
        shown = score_row(row, is_short=result.is_short)
        rows.append(with_interval(shown, evidence.get(row.key), notes))
        if row.key == TimeLeft.IN_TIME.value and SHARE in evidence:
            rows.append(with_interval(_share(evidence[SHARE]), evidence[SHARE], notes))
    head = (*short_names(result).values(), "X − Y", "95 % interval")
    st.html(measures_html(rows, key="time-left", head=head))
    lines = [plain(line) for line in notes.lines()]
    lines += [state.say(fact) for fact in few_urgent(result)]
    st.caption("  \n".join(lines))


def _evidence(result: Result) -> dict[str, Evidence]:
    """Return the evidence for share in time and impact speed, by key."""
    keys, key = (SHARE, IMPACT), comparison_key(result)
    evidence = state.cached("time_left_evidence", key, lambda: judge_keys(result, keys), most=8)
    return {row.figure: row for row in evidence}


def _share(row: Evidence) -> MeasureRow:
    """Return a table row with the share in time, to be placed below the row of its count."""
    form = evidence_form(row.figure)
    cells = (number(row.x, form), number(row.y, form), minus(difference(row.x, row.y, form)))
    return MeasureRow("as a share", cells, level=1)


def with_interval(row: MeasureRow, of: Evidence | None, notes: Footnotes) -> MeasureRow:
    """Append the interval of the difference to a row, with footnotes on its limits."""
    if of is None or not row.cells:
        return replace(row, cells=(*row.cells, ""))
    form = evidence_form(of.figure)
    of_row = [note for note in of.note.split("; ") if note]
    interval = minus(interval_text(of.low, of.high, form))
    if interval != UNDEFINED and of.unit == BLOCKS:
        interval += f" {WITHIN}"
        notes.mark(WITHIN_NOTE, WITHIN)
        of_row.append(WITHIN_NOTE)
    return replace(row, cells=(*row.cells, interval), marks=notes.of_row(of_row))


def _draw_needed(result: Result) -> None:
    """Draw how early a warning must come for the car to stop."""
    view = time_left_in(result)
    if view.has_assumed_speed.any():
        if view.assumed_speed_kmh is None:
            st.markdown("Where the recordings do not state their speed:")
        st.markdown(plain(state.say(needed(result.params))))
    else:
        st.markdown("The recordings state the speed of the car: the assumed one moves nothing.")


def _meaning(result: Result) -> str:
    """Explain what *in time* means and does not mean."""
    return state.say(
        MEANING,
        n=result.params.confirm_n,
        m=result.params.confirm_m,
        source=_source(result),
        link=docs_link("Time left", "time-left"),
    )


def _source(result: Result) -> str:
    """Describe what the time to contact is derived from: the truth's distances or box heights."""
    has_distance = np.isfinite(result.dataset.truth.distance_m[~result.dataset.truth.ignore])
    if has_distance.all():
        return "the truth's distances"
    if not has_distance.any():
        return "the heights of the truth's boxes"
    return state.say(
        "the truth's distances where {a_one} has one in every frame, else from box heights"
    )


def key_of(result: Result) -> tuple[object, ...]:
    """Return the cache key of urgent encounters. It is valid while the same data are open."""
    settings = result.params.only_for(THRESHOLD, TIME_LEFT)
    return settings, result.x.name, result.y.name


def draw_by_class(result: Result) -> None:
    """Draw a table of time left with a row for each class."""
    key = comparison_key(result)
    table = state.cached("time_left_by_class", key, lambda: by_class(result), most=8)
    if table is None:
        st.caption("No urgent encounter has a class.")
        return
    classes = docs_link("Classes of encounters", "classes-of-encounters")
    draw_table_of(table, key="time-left-by-class", explanation=f"{classes}.")
