"""Previous, "3 of 57", next: through a list, by buttons and by keys."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import streamlit as st


def draw_steps(
    at: int,
    n: int,
    step: Callable[[int], None],
    *,
    key: str,
    width: Literal["stretch", "content"] = "stretch",
) -> None:
    """Buttons to the neighbours of an entry, with the keys p and n, and which entry it is.

    Parameters
    ----------
    at
        Number of the entry, counted from 0.
    n
        How many there are.
    step
        Called with the number of the entry to go to, before the page is drawn again.
    key
        Begins the names of the widgets.
    width
        Whether they take the whole line.
    """
    with st.container(
        horizontal=True,
        horizontal_alignment="distribute",
        vertical_alignment="center",
        width=width,
    ):
        _step("Previous", "p", at - 1, n, step, key=key, icon=":material/chevron_left:")
        st.markdown(f"**{at + 1:,}** of {n:,}", width="content")
        _step("Next", "n", at + 1, n, step, key=key, icon=":material/chevron_right:")


def _step(
    label: str,
    shortcut: str,
    at: int,
    n: int,
    step: Callable[[int], None],
    *,
    key: str,
    icon: str,
) -> None:
    st.button(
        label,
        key=f"{key}_{label.lower()}",
        shortcut=shortcut,
        icon=icon,
        icon_position="right" if label == "Next" else "left",
        disabled=not 0 <= at < n,
        on_click=step,
        args=(at,),
    )
