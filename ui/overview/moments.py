"""Overview page: the worst moments of each system and where the two differ most."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any, Final

import cv2
import streamlit as st

from nvcore.comparison import Result
from nvcore.overlay.annotate import LAYERS, annotate
from nvcore.pictures import Pictures, jpeg
from nvcore.tables.moments import worst_moments
from ui.session import state
from ui.shell.navigate import open_row
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import plain

KINDS: Final = {
    "x": "Worst of X",
    "y": "Worst of Y",
    "x_better": "X better",
    "y_better": "Y better",
}
THUMBNAIL_PX: Final = 640
N_MOMENTS: Final = 4


def draw(result: Result) -> None:
    """A row of moments for each kind; a button opens the frame."""
    st.header("Moments to look at")
    st.caption(
        "The stretches of low similarity that weigh most, and those in which the systems differ "
        "most. The picture is the worst frame: pedestrians white, X solid blue, Y dashed orange."
    )
    kind = choose_side_by_side(
        "Which moments", KINDS, "moments", default="x", label_visibility="collapsed"
    )
    table = worst_moments(result, n=N_MOMENTS)
    moments = table[table["kind"] == kind].to_dict("records")
    if not moments:
        st.info(_none(kind, result.params.low))
    for column, moment in zip(st.columns(N_MOMENTS), moments, strict=False):
        with column:
            _moment(result, kind, KINDS[kind], moment)


def _moment(result: Result, kind: str, title: str, moment: Mapping[Hashable, Any]) -> None:
    row = int(moment["row"])
    recording, in_recording = state.place_of(row)
    picture = _thumbnail(result, recording, in_recording, row)
    if picture is not None:
        st.image(picture, width="stretch", alt=f"{title}: frame {moment['frame']}")
    st.markdown(
        f"**{plain(moment['recording'])}**, {moment['time_s']:.2f} s  \n{plain(moment['reason'])}"
    )
    st.caption(
        f"similarity X {moment['similarity_x']:.2f}, Y {moment['similarity_y']:.2f}; "
        f"{moment['duration_s']:.2f} s"
    )
    if st.button("Open frame", key=f"moment_{kind}_{row}", width="stretch"):
        open_row(row)


def _thumbnail(result: Result, recording: int, in_recording: int, row: int) -> bytes | None:
    pictures, index = state.workspace().picture_of(recording, in_recording)
    if pictures is None or index < 0:
        return None
    return state.thumbnail(row, lambda: _draw(result, pictures, row, index))


def _draw(result: Result, pictures: Pictures, row: int, index: int) -> bytes:
    lo, hi = state.stretch()
    drawing = annotate(
        result, pictures, index, row, lo=lo, hi=hi, layers=LAYERS, labels=False, caption=False
    )
    scale = THUMBNAIL_PX / drawing.shape[1]
    small = cv2.resize(drawing, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return jpeg(small)


def _none(kind: str, low: float) -> str:
    if kind in ("x", "y"):
        return f"{kind.upper()} never falls below a similarity of {low:g}."
    return "There is no such stretch."
