"""Overview page: Venn diagram and worst encounters. Clicks open a list or a frame."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from functools import partial
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.figures.venn import MOST_MARKS, venn_figure
from nvcore.settings.stages import ENCOUNTERS, SALIENT, SEVERITY
from nvcore.tables.encounters.severity import weighed_encounters
from ui.session import state, store
from ui.shell.navigate import open_page, open_row
from ui.widgets.buttons import button
from ui.widgets.charts import clicked_chart, kept_figure
from ui.widgets.table import draw_table
from ui.widgets.table_columns import as_shown, columns_of
from ui.widgets.text import docs_link, plain, short_names

WORDS: Final = {"both": "Both", "x_only": "Only X", "y_only": "Only Y", "neither": "Neither"}
OF_VERSIONS: Final = {
    "x_only": "If Y is the next version of X, it newly misses these.",
    "y_only": "If Y is the next version of X, it mends the misses of these.",
}
"""Meaning of a region when two versions of one system are compared, as in `nvcore gate`."""
N_WORST: Final = 5
WORST_COLUMNS: Final = ("recording", "track", "severity_s_x", "severity_s_y")
SEVERITIES: Final = {"severity_s_x": "X (s)", "severity_s_y": "Y (s)"}
"""Short headings for a table whose title names the measure."""


def draw(result: Result) -> None:
    """Draw the diagram, and buttons as an alternative to clicking in it."""
    names, theme = result.names, state.theme()
    encounters, key = _weighed(result)
    figure = kept_figure(
        "venn",
        (*key, theme),
        lambda: venn_figure(
            result.venn, names, theme=theme, encounters=encounters, objects=result.objects
        ),
    )
    has_marks = len(encounters) <= MOST_MARKS
    help_text = state.say(
        "The seconds are {severity}: what failures weigh, 1 s for each second that {a_one} "
        "straight ahead and near is missed. ",
        severity=docs_link("severity", "severity"),
    ) + (
        "Each mark is an encounter, the larger the heavier its failure; its colour is the "
        "system whose failure is heavier, a square stands for both. Click a mark to see its "
        "moment, or a region to see its encounters."
        if has_marks
        else f"Encounters have marks of their own only up to {MOST_MARKS} of them. "
        "Click a region to see its encounters."
    )
    counts = result.venn.counts()
    names_of = short_names(result)
    words = WORDS | {f"{letter}_only": f"Only {name}" for letter, name in names_of.items()}
    alt = "Encounters detected: " + ", ".join(f"{words[c]} {counts[c]}" for c in words)
    clicked = clicked_chart(figure, "venn", alt=alt, help=help_text)
    if isinstance(clicked, str):
        _open(clicked)
    elif clicked is not None:
        open_row(int(clicked))
    with st.container(key="venn_open"):
        columns = st.columns(4)
    for column, (category, label) in zip(columns, words.items(), strict=True):
        if button(
            f"{plain(label)} {counts[category]}",
            key=f"open_{category}",
            width="stretch",
            help=OF_VERSIONS.get(category),
            at=column,
        ):
            _open(category)


def _weighed(result: Result) -> tuple[pd.DataFrame, tuple[Hashable, ...]]:
    """Return encounters with the severity of their failures, and their cache key."""
    key = (result.params.only_for(ENCOUNTERS, SEVERITY, SALIENT), result.x.name, result.y.name)
    return state.cached("weighed_encounters", key, lambda: weighed_encounters(result)), key


def draw_worst(result: Result) -> None:
    """Draw the encounters with the severest failures. A click opens the frame."""
    row = store.WORST_ROW.pop()
    if row is not None:
        open_row(row)
    encounters, _ = _weighed(result)
    worst = encounters[encounters["severity_s"] > 0].head(N_WORST)
    if worst.empty:
        return
    st.markdown(
        "**Heaviest failures**, by severity",
        help=state.say(
            "Click an encounter to see the frame in which its failure costs most, of those in "
            "which the other system detects the {one}, if there are any."
        ),
    )
    columns = columns_of("encounters.csv", *WORST_COLUMNS)
    draw_table(
        as_shown(worst[[*WORST_COLUMNS]]),
        columns | {name: replace(columns[name], label=to) for name, to in SEVERITIES.items()},
        key="overview_worst",
        name="Heaviest failures",
        on_click=partial(_ask_for_row, worst["shown_row"].tolist()),
    )
    if button(
        f"Review all {len(encounters):,} one by one",
        key="overview_review",
        icon=":material/playlist_play:",
        help="Opens the page Encounters, the heaviest failure first.",
    ):
        open_page("encounters", category=",".join(WORDS))


def _ask_for_row(rows: list[int], row: int, _column: str) -> None:
    store.WORST_ROW.set(rows[row])


def _open(category: str) -> None:
    open_page("encounters", category=category)
