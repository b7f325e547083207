"""Who is X and who is Y, in their colours and dashes: the same on every page."""

from __future__ import annotations

from html import escape

import streamlit as st

from nvcore.errors import one_line
from nvcore.palette import X_COLOUR, Y_COLOUR
from ui import state

MAX_NAME = 26


def legend() -> None:
    """Name of each system beside a sample of its line."""
    theme = state.theme()
    rows = [
        _row("X", state.systems()[0], X_COLOUR[theme], "solid"),
        _row("Y", state.systems()[1], Y_COLOUR[theme], "dashed"),
    ]
    st.html(f'<div style="display:flex;flex-direction:column;gap:2px">{"".join(rows)}</div>')


def _row(letter: str, name: str | None, colour: str, dash: str) -> str:
    shown = "no second system" if name is None else one_line(name)
    short = shown if len(shown) <= MAX_NAME else shown[: MAX_NAME - 1] + "…"
    line = f'<span style="width:34px;border-top:3px {dash} {colour}"></span>'
    return (
        f'<div style="display:flex;align-items:center;gap:8px" title="{escape(shown, quote=True)}">'
        f"{line}<b>{letter}</b><span>{escape(short)}</span></div>"
    )
