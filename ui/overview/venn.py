"""Overview page: the Venn diagram; a click on a region opens its encounters."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison import Result
from nvcore.figures.venn import venn_figure
from ui.session import state
from ui.shell.navigate import open_page
from ui.widgets.charts import clicked_chart


def draw(result: Result) -> None:
    """The diagram, and the same by buttons for those who do not click in pictures."""
    st.header("Who detects whom")
    region = clicked_chart(
        venn_figure(result.venn, (result.x.name, result.y.name), theme=state.theme()),
        "venn",
        alt=_in_words(result),
    )
    if region is not None:
        _open(str(region))
    st.caption("Click a region to see its encounters.")
    counts = result.venn.counts()
    columns = st.columns(4)
    for column, (category, words) in zip(columns, WORDS.items(), strict=True):
        if column.button(f"{words} {counts[category]}", key=f"open_{category}", width="stretch"):
            _open(category)


WORDS = {"both": "Both", "x_only": "Only X", "y_only": "Only Y", "neither": "Neither"}


def _in_words(result: Result) -> str:
    counts = result.venn.counts()
    return "Encounters detected: " + ", ".join(f"{WORDS[c]} {counts[c]}" for c in WORDS)


def _open(category: str) -> None:
    state.choose_category(category)
    open_page("encounters")
