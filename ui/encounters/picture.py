"""Encounters page: the chosen pedestrian in the picture, with boxes of truth, X and Y."""

from __future__ import annotations

from typing import Final

import numpy as np
import streamlit as st

from nvcore.comparison import Result
from nvcore.overlay.annotate import LAYERS, annotate
from nvcore.pictures import jpeg
from nvcore.tables.moments import encounter_box
from ui.session import drawing, state

HEIGHTS: Final = 2.2
"""Height of the cut-out in heights of the pedestrian."""
LEAST: Final = 0.4
"""Least height of the cut-out, as a share of the picture's."""
ASPECT: Final = 1.6
"""Width of the cut-out over its height."""


def draw(result: Result, encounter: int, row: int) -> None:
    """The part of a frame around the pedestrian; without pictures, the boxes on a blank."""
    key = (state.workspace().version, drawing.stretch(), row, encounter)
    content = state.cached(
        "encounter_picture",
        key,
        lambda: _picture(result, encounter, row),
        most=drawing.MOST_THUMBNAILS,
    )
    st.image(content, width="stretch", alt="The pedestrian with the boxes of truth, X and Y")


def _picture(result: Result, encounter: int, row: int) -> bytes:
    recording, in_recording = state.place_of(row)
    pictures, picture = state.workspace().picture_of(recording, in_recording)
    lo, hi = drawing.stretch()
    annotated = annotate(
        result, pictures, picture, row, lo=lo, hi=hi, layers=LAYERS, labels=True, caption=False
    )
    frames = result.dataset.frame_columns
    scale = (
        annotated.shape[1] / frames.width[recording],
        annotated.shape[0] / frames.height[recording],
    )
    part = cut_out(annotated, encounter_box(result, encounter, row) * np.tile(scale, 2))
    return jpeg(np.ascontiguousarray(part))


def cut_out(picture: np.ndarray, xywh: np.ndarray) -> np.ndarray:
    """The part of a picture around a box, wide enough to see where it is; inside the picture."""
    x, y, w, h = xywh
    n_rows, n_columns = picture.shape[:2]
    high = int(min(n_rows, max(HEIGHTS * h, LEAST * n_rows)))
    wide = int(min(n_columns, ASPECT * high))
    top = int(np.clip(y + h / 2 - high / 2, 0, n_rows - high))
    left = int(np.clip(x + w / 2 - wide / 2, 0, n_columns - wide))
    return picture[top : top + high, left : left + wide]
