"""Review page: the numbers without what reviewers found to be wrong."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd
import streamlit as st

from nvcore.common.wording import count_text, difference, minus, number
from nvcore.comparison.compare import Result
from nvcore.evidence.measures import primary_of
from nvcore.subjects.review.cases import CaseList
from nvcore.subjects.review.decisions import LEAVES_OUT, decided, reviewed_rows
from nvcore.subjects.review.robust import Robustness, primary_robustness
from nvcore.tables.scorecard import ScoreRow, pick_rows
from ui.session import state
from ui.session.results import comparison_key
from ui.widgets.html import MeasureRow, measures_html
from ui.widgets.text import UNDEFINED, plain

Rows = list[tuple[ScoreRow, ScoreRow]]


def draw(
    result: Result, cases: CaseList, decisions: pd.DataFrame, draw_more: Callable[[], None]
) -> None:
    """Draw who leads without the cases left out, and what it would take to turn that.

    `draw_more` draws beside the last number.
    """
    states = decided(cases, decisions)
    rows, robust = state.workspace().cached(
        "review_numbers",
        (comparison_key(result), tuple(states["decision"]), tuple(states["is_done"])),
        lambda: (
            reviewed_rows(result, cases, decisions),
            primary_robustness(result, cases, decisions),
        ),
    )
    n_out = int(states["decision"].isin(LEAVES_OUT).sum())
    primary = primary_of(result.dataset).key.removesuffix("_by_unit")
    shown = [(old, new) for old, new in rows if old.key == primary]
    why = "The primary measure is none of the scorecard, which alone is computed again here."
    lead = _lead(result, *shown[0], n_out) if shown else f"Leader {UNDEFINED}"
    with st.container(horizontal=True, vertical_alignment="center", key="review_numbers"):
        st.markdown(lead, help=None if shown else why, width="content")
        n_turn, why = _turns(robust)
        st.markdown(f"Open misses that would turn it: **{n_turn}**", help=why, width="content")
        with st.popover("All measures", type="tertiary"):
            st.html(_table(rows))
        draw_more()


def _lead(result: Result, old: ScoreRow, new: ScoreRow, n_out: int) -> str:
    """Return who leads by the primary measure, before the review as well if it differs."""
    label = plain(pick_rows(result, [new], [new.key])[0].label)
    if not n_out:
        return f"{_leader(old)} · {label}"
    cases, before = count_text(n_out, "case"), _leader(old).replace("*", "")
    return (
        f"Without the {cases} marked as wrong truth or irrelevant: {_leader(new)} · {label}"
        f", before: {before.removeprefix('X leads by ') if new.winner == 'x' else before}"
    )


def _leader(row: ScoreRow) -> str:
    if not row.winner:
        return "**X and Y are level**"
    lead = difference(row.x, row.y, row.form).lstrip("+-−")
    return f"**{row.winner.upper()} leads by {lead}**"


def _turns(robust: Robustness | None) -> tuple[str, str]:
    """Return the number of open misses that would turn the leader, and its explanation."""
    if robust is None:
        why = "Only for means over encounters (severity, detection) in which X and Y differ."
        return UNDEFINED, why
    if robust.turns_sign is None:
        return UNDEFINED, "The leader stays even if all open misses are wrong truth."
    return str(len(robust.turns_sign)), "The fewest that would have to be wrong truth."


def _table(rows: Rows) -> str:
    """Return the table of all measures before and after the review."""
    lines = [
        MeasureRow(
            label=old.label,
            cells=tuple(minus(number(value, old.form)) for value in (old.x, old.y, new.x, new.y)),
            level=old.level,
        )
        for old, new in rows
    ]
    return measures_html(lines, key="reviewed", head=("X", "Y", "X reviewed", "Y reviewed"))
