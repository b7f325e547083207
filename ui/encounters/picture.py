"""Encounters page: the chosen pedestrian in the picture, with boxes of truth, X and Y."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.comparison import Result
from nvcore.pictures import jpeg, picture_address
from nvcore.tables.moments import encounter_box
from ui.session import drawing, state, store
from ui.session.look import keep_look, look

OF_VISIBLE: Final = ("visible", "blended")
"""Ways to see the pictures in which the cut-out is of visible light."""


def draw(result: Result, encounter: int, row: int) -> None:
    """The part of a frame around the pedestrian; without pictures, the boxes on a blank.

    Of the recording's own pictures or those of visible light, as chosen here or in a viewer.
    """
    has_visible = drawing.has_visible(row)
    is_visible = has_visible and look().picture in OF_VISIBLE
    key = (state.workspace().version, drawing.stretch(), row, encounter, is_visible)
    content = state.cached(
        "encounter_picture",
        key,
        lambda: _picture(result, encounter, row, is_visible=is_visible),
        most=drawing.MOST_THUMBNAILS,
    )
    st.image(
        picture_address(content),
        width="stretch",
        alt=state.say("The {one} with the boxes of truth, X and Y"),
    )
    if has_visible:
        store.ENCOUNTER_IS_VISIBLE.set(is_visible)
        st.toggle("Visible light", key=store.ENCOUNTER_IS_VISIBLE.key, on_change=_choose)


def _choose() -> None:
    is_visible = store.ENCOUNTER_IS_VISIBLE.get()
    keep_look(look()._replace(picture="visible" if is_visible else "own"))


def _picture(result: Result, encounter: int, row: int, *, is_visible: bool) -> bytes:
    xywh = encounter_box(result, encounter, row)
    return jpeg(drawing.part_of_frame(result, row, xywh, labels=True, is_visible=is_visible))
