"""Selectors for the recording and the frame."""

from __future__ import annotations

import numpy as np
import streamlit as st

from nvcore.pictures.index import USUAL
from ui.session import state
from ui.streamlit_inside.types import DeltaGenerator
from ui.widgets.text import plain


def recording_choice() -> None:
    """Draw the recording selector, and the rule that assigns pictures if it is unusual."""
    left, right = st.columns([2, 3], vertical_alignment="bottom")
    _draw_recordings(left, right)


def _draw_recordings(left: DeltaGenerator, right: DeltaGenerator) -> None:
    names = state.recording_names()
    # after a change of tags, the same number means another recording
    key = f"recording_choice_{state.workspace().n_opened}_{len(names)}_{state.recording()}"
    recording = left.selectbox(
        "Recording",
        range(len(names)),
        index=state.recording(),
        format_func=lambda i: names[i],
        key=key,
    )
    if recording != state.recording():
        state.go_to(recording, 0)
        st.rerun()
    note = state.workspace().pictures.notes.get(state.recording())
    if note not in USUAL:
        right.caption(plain(note or "This recording has no pictures: boxes are drawn on a blank."))


def choose_recording_and_frame(key: str) -> None:
    """Draw selectors for the Timeline's current recording and frame. The recording has frames."""
    left, middle, right = st.columns([4, 2, 4], vertical_alignment="bottom")
    _draw_recordings(left, right)
    recording, row = state.recording(), state.row()
    numbers = state.frame_numbers(recording)
    number = middle.number_input(
        "Frame",
        int(numbers[0]),
        int(numbers[-1]),
        int(numbers[row]),
        1,
        key=f"{key}_{recording}_{numbers[row]}",
        help="The frame of the Timeline page. Frames that are not evaluated give the nearest.",
    )
    if number != numbers[row]:
        state.go_to(recording, nearest_row(numbers, number, row))
        st.rerun()


def nearest_row(numbers: np.ndarray, number: int, row: int) -> int:
    """Return the row of the evaluated frame nearest to a number. It always differs from `row`.

    Examples
    --------
    >>> nearest_row(np.array([0, 20, 40]), 21, 1)
    2
    >>> nearest_row(np.array([0, 20, 40]), 38, 0)
    2
    """
    nearest = int(np.abs(numbers - number).argmin())
    if nearest == row:
        nearest += 1 if number > numbers[row] else -1
    return min(max(nearest, 0), len(numbers) - 1)
