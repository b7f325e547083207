"""Legend of X and Y in the sidebar of every page, with a button that swaps them."""

from __future__ import annotations

from html import escape

import streamlit as st

from nvcore.common.wording import one_line, shortened
from ui.session import state

MAX_NAME = 24


def draw() -> None:
    """Draw each system's name beside a sample of its line, and the button that swaps them.

    This also sets the systems' colours for tables and tiles of all pages.
    """
    theme, names = state.theme(), state.systems()
    styles = {letter: theme.style(letter) for letter in "xy"}
    colours = "".join(
        f"--nv-{letter}:{style.colour(theme.shade)};--nv-dash-{letter}:{style.css};"
        for letter, style in styles.items()
    )
    st.html(f"<style>:root{{{colours}}}</style>")
    rows = [
        _row(letter.upper(), name, style.colour(theme.shade), style.css)
        for (letter, style), name in zip(styles.items(), names, strict=True)
    ]
    with st.container(horizontal=True, vertical_alignment="center", gap="xsmall", key="systems"):
        st.html(f'<div style="display:flex;flex-direction:column;gap:2px">{"".join(rows)}</div>')
        if names[1] is not None:
            st.button(
                "Swap X and Y",
                key="sidebar_swap",
                icon=":material/swap_vert:",
                type="tertiary",
                help="Swap: X becomes Y and Y becomes X, each with its threshold.",
                on_click=swap,
            )


def _row(letter: str, name: str | None, colour: str, dash: str) -> str:
    label = "no second system" if name is None else one_line(name)
    line = f'<span style="flex:none;width:26px;border-top:3px {dash} {colour}"></span>'
    return (
        f'<div style="display:flex;align-items:center;gap:8px" title="{escape(label, quote=True)}">'
        f"{line}<b>{letter}</b><span>{escape(shortened(label, MAX_NAME))}</span></div>"
    )


def swap() -> None:
    """Swap X and Y. For callbacks."""
    x, y = state.systems()
    if y is not None:
        state.compare_systems(y, x)
