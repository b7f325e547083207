"""What the viewer needs to know of a recording, and who is chosen, on whichever page."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import streamlit as st

from nvcore.comparison import Result
from ui.session import state

CHOSEN: Final = "encounters_chosen"
"""Where the chosen encounter is kept: fingerprint of its data, and its row."""


def choose_encounter(encounter: int) -> None:
    """Make this encounter, a row of ``result.encounters``, the chosen one of all pages."""
    st.session_state[CHOSEN] = (state.opened().dataset.fingerprint, encounter)


def chosen_encounter(result: Result) -> int | None:
    """The chosen encounter; None where there is none in what is open."""
    fingerprint, encounter = st.session_state.get(CHOSEN, ("", -1))
    is_known = fingerprint == result.dataset.fingerprint
    return encounter if is_known and 0 <= encounter < len(result.encounters) else None


def viewer_arguments(result: Result, recording: int) -> dict[str, Any]:
    """The arguments of `viewer` that say which pictures, frames and boxes there are."""
    space, frames = state.workspace(), result.dataset.frame_columns
    in_recording = frames.rows_of(recording)
    numbers = frames.frame[in_recording]
    rows = space.picture_rows.get(recording)
    return {
        "token": space.token,
        "recording": recording,
        "n_rows": len(numbers),
        "width": float(frames.width[recording]),
        "height": float(frames.height[recording]),
        "fps": float(frames.fps[recording]),
        "frames": numbers,
        "times_s": result.dataset.frames["time_s"].to_numpy()[in_recording],
        "has_picture": np.zeros(len(numbers), dtype=bool) if rows is None else rows >= 0,
        "version": space.version,
        "picture_version": space.pictures_version,
        "theme": state.theme(),
    }
