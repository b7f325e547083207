"""Encounters page: the chosen pedestrian in the picture, with boxes of truth, X and Y."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison import Result
from nvcore.pictures import jpeg
from nvcore.tables.moments import encounter_box
from ui.session import drawing, state


def draw(result: Result, encounter: int, row: int) -> None:
    """The part of a frame around the pedestrian; without pictures, the boxes on a blank."""
    key = (state.workspace().version, drawing.stretch(), row, encounter)
    content = state.cached(
        "encounter_picture",
        key,
        lambda: _picture(result, encounter, row),
        most=drawing.MOST_THUMBNAILS,
    )
    st.image(
        content, width="stretch", alt=state.words("The pedestrian with the boxes of truth, X and Y")
    )


def _picture(result: Result, encounter: int, row: int) -> bytes:
    xywh = encounter_box(result, encounter, row)
    return jpeg(drawing.part_of_frame(result, row, xywh, labels=True))
