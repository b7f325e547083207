"""Stability page: table of all maps, showing which settings the verdict depends on."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.common.progress import Progress
from nvcore.comparison.compare import Result
from nvcore.evidence.stability.notes import CRITERIA, PLANES
from nvcore.evidence.stability.survey import SURVEY_PLANES, SurveyRow, held_text, survey_stability
from ui.jobs.computed import Computation
from ui.jobs.page_run import PageRun
from ui.session import state
from ui.widgets.table import draw_table, own_headings

AT_ONCE: Final = 5_000
"""Frames up to which the table is there within a second or so: it is drawn without asking."""
RUN: Final = PageRun[tuple[SurveyRow, ...]]("stability_survey", "table", "Trying all settings")
THREADS: Final = 2
HELD: Final = {
    "all": " at every setting",
    "none": " as set only",
    "does not depend on them": ", whatever they are",
}
"""How a verdict holds, by `held_text`."""


def draw(result: Result) -> None:
    """Draw the table of all maps, or the button that computes it, or the progress."""
    st.header("Where does the verdict depend on settings?")
    survey = _survey_rows(result)
    if survey is None:
        return
    table = shown_survey(survey)
    draw_table(
        table,
        own_headings(table),
        key="stability_survey_table",
        name="Where the verdict depends on settings",
        is_sortable=False,
    )
    st.caption(
        "Who is better as analysed, and in which share of the plausible range of these settings "
        "that holds, all else as in the sidebar. The maps below show where it turns. That X or Y "
        "is better at many settings is no evidence against chance: the Overview says what is "
        "claimed."
    )


def shown_survey(survey: tuple[SurveyRow, ...]) -> pd.DataFrame:
    """Return a table with a row per combination of settings and a column per criterion."""
    cells = {(row.plane, row.criterion): _cell(row) for row in survey}
    return pd.DataFrame(
        [
            {
                "What is varied": PLANES[plane],
                **{f"by {words}": cells[plane, criterion] for criterion, words in CRITERIA.items()},
            }
            for plane in SURVEY_PLANES
        ]
    )


def _cell(row: SurveyRow) -> str:
    text = held_text(row)
    if row.stability is None or row.stability.verdict == "undefined":
        return text
    winner = (
        "even" if row.stability.verdict == "even" else f"{row.stability.verdict.upper()} better"
    )
    if text.endswith("%"):
        return f"{winner} in {text} of the range"
    return f"{winner}{HELD.get(text, f', {text}')}"


def _survey_rows(result: Result) -> tuple[SurveyRow, ...] | None:
    key = state.workspace().version, result.params
    return Computation(RUN, key, partial(_survey, result)).draw_or_offer(
        "Try all settings",
        "table_chart",
        "It computes all maps: with so many frames up to some minutes.",
        is_quick=len(result.dataset.frames) <= AT_ONCE,
    )


def _survey(result: Result, progress: Progress) -> tuple[SurveyRow, ...]:
    with ThreadPoolExecutor(THREADS) as pool:
        return survey_stability(result, executor=pool, progress=progress)
