"""Export page: choice of a frame, and that frame as a picture."""

from __future__ import annotations

import re
from typing import Final

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.figures.overlay.annotate import annotate, frame_png
from ui.session import state
from ui.widgets import drawing
from ui.widgets.recording import choose_recording_and_frame

LAYERS: Final = {"truth": "Truth", "x": "X", "y": "Y"}


def choose_frame(result: Result) -> bool:
    """Draw the choice of recording and frame, and return whether there is a frame at all."""
    st.header("Frame as picture")
    if not len(result.dataset.frames):
        st.info("There is no evaluated frame. Check the frame list on the Data page.")
        return False
    choose_recording_and_frame("export_frame")
    return True


@st.fragment
def draw(result: Result) -> None:
    """Draw the current frame with its boxes, and its download."""
    recording, row = state.recording(), state.row_in_all()
    left, right = st.columns([3, 1])
    with right:
        layers = st.pills(
            "Boxes of",
            list(LAYERS),
            selection_mode="multi",
            default=list(LAYERS),
            format_func=LAYERS.__getitem__,
            key="export_layers",
        )
        labels = st.toggle("Track ids and scores", key="export_labels")
        caption = st.toggle("Numbers below the picture", value=True, key="export_caption")
    lo, hi = drawing.stretch()
    pictures, index = state.workspace().picture_of(recording, state.row())
    picture = annotate(
        result, pictures, index, row, lo=lo, hi=hi, layers=layers, labels=labels, caption=caption
    )
    name, frame = state.recording_names()[recording], int(result.dataset.frame_columns.frame[row])
    layer_names = ", ".join(LAYERS[layer] for layer in layers) or "nobody"
    left.image(
        picture,
        caption=f"Frame {frame}, as it will be saved",
        width="stretch",
        alt=f"Frame {frame} of {name} with the boxes of {layer_names}",
    )
    right.download_button(
        "Picture (PNG)",
        lambda: frame_png(picture, result),
        f"{file_stem(name)}-frame-{frame}.png",
        "image/png",
        on_click="ignore",
        width="stretch",
        icon=":material/image:",
        key="export_png",
    )
    right.caption(
        "Parameters, version and fingerprint of the inputs are inside the file. The grey values "
        "are stretched as on the Timeline page."
    )


def file_stem(name: str) -> str:
    """Return a recording's name for use in a file name.

    Examples
    --------
    >>> file_stem("set06/V000")
    'set06_V000'
    """
    return re.sub(r"[^\w.-]+", "_", name).strip("._")[:60] or "recording"
