"""Systems page: every pair in words, with a button that opens it on the Overview."""

from __future__ import annotations

from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.report.matrix import pair_name, pair_text
from ui.session import state
from ui.shell.navigate import ask_for_page, open_page
from ui.widgets.buttons import button
from ui.widgets.text import plain

BETWEEN: Final = " – "


def draw_only_pair(result: Result) -> None:
    """Draw a note that two systems are a single pair, with a link to it."""
    st.info(
        f"There is one pair, {plain(result.x.name)} and {plain(result.y.name)}: the Overview "
        "compares it. With a third system, every pair is compared here."
    )
    if button("Add a system", key="add_system", type="primary", icon=":material/add:"):
        open_page("data")


def draw(table: pd.DataFrame) -> None:
    """Draw a line for each pair, with the button that opens it."""
    st.header("Who is better in what")
    st.caption("A click opens the pair as X and Y on the Overview, with all details.")
    chosen = set(state.systems())
    for number, pair in enumerate(table.to_dict("records")):
        left, right = st.columns([2, 5], vertical_alignment="center")
        left.button(
            plain(pair_name(pair, between=BETWEEN)),
            key=f"pair_{number}",
            icon=":material/open_in_new:",
            width="stretch",
            on_click=_open,
            args=(pair["x"], pair["y"]),
        )
        is_open = {pair["x"], pair["y"]} == chosen
        right.markdown(plain(pair_text(pair)) + (" *(now X and Y)*" if is_open else ""))


def _open(x: str, y: str) -> None:
    """Make these systems X and Y, if necessary, and go to the Overview. For callbacks."""
    if {x, y} != set(state.systems()):
        state.compare_systems(x, y)
    ask_for_page("overview")
