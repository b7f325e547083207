"""Data page: what the boxes of files to be opened are of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import streamlit as st

from nvcore.objects import KINDS, PEDESTRIAN, Objects, objects_from
from nvcore.wording import capitalised
from ui.session import state
from ui.widgets.text import plain

OTHER: Final = "something else"


def draw_objects(place: str, changed: Callable[[], None]) -> Objects:
    """Ask what the boxes are of; pedestrians where what is typed is no name.

    Parameters
    ----------
    place
        Part of the page, for the keys of the widgets.
    changed
        Called when the answer changes.
    """
    left, right = st.columns([1, 3])
    names = [*KINDS, OTHER]
    now = state.opened().dataset.objects.singular
    kind = left.selectbox(
        "The boxes are of",
        names,
        index=names.index(now) if now in KINDS else 0,
        format_func=lambda name: capitalised(KINDS[name].plural if name in KINDS else name),
        key=f"objects_{place}",
        on_change=changed,
        help="Decides which classes of a file count, and what the pages call them.",
    )
    if kind in KINDS:
        return KINDS[kind]
    name = right.text_input(
        "One of them, and several",
        key=f"objects_named_{place}",
        on_change=changed,
        placeholder="cyclist, or child, children",
        help="In the singular; the plural after a comma, unless it ends in s.",
    )
    if not name.strip():
        return PEDESTRIAN
    try:
        return objects_from([part.strip() for part in name.split(",")])
    except ValueError as error:
        right.error(f"{plain(capitalised(str(error)))}. Until then: pedestrians.")
        return PEDESTRIAN
