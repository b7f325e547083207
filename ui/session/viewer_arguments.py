"""What the viewer needs to know of a recording, and who is chosen, on whichever page."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import streamlit as st

from nvcore.comparison import Result
from ui.session import state

CHOSEN: Final = "encounters_chosen"
"""Where the chosen encounter is kept: fingerprint of the data, and the encounter's name in an
address, "recording:track": rows depend on which recordings are compared."""


def choose_encounter(result: Result, encounter: int) -> None:
    """Make a row of ``result.encounters`` the chosen one of all pages; others are ignored."""
    if not 0 <= encounter < len(result.encounters):
        return
    recording = result.dataset.recordings["name"].iloc[result.encounters.recording[encounter]]
    name = f"{recording}:{result.encounters.track[encounter]}"
    st.session_state[CHOSEN] = (state.opened().whole.fingerprint, name)


def chosen_name() -> str:
    """Name of the chosen encounter; empty where there is none in what is open."""
    fingerprint, name = st.session_state.get(CHOSEN, ("", ""))
    return name if fingerprint == state.opened().whole.fingerprint else ""


def chosen_encounter(result: Result) -> int | None:
    """Row of the chosen encounter; None where there is none in what is compared."""
    recording, _, track = chosen_name().rpartition(":")
    numbers = result.dataset.recordings["name"].to_numpy()[result.encounters.recording]
    is_it = (numbers == recording) & (result.encounters.track.astype(str) == track)
    return int(is_it.argmax()) if is_it.any() else None


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
