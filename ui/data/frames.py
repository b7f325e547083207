"""Data page: the list of evaluated frames, where only some frames of a recording were annotated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
import streamlit as st

from ui.confined.reading import frames_confined
from ui.data.file_check import read_unless_known
from ui.widgets.text import plain

FRAMES_LABEL: Final = "Evaluated frames (list, one number a line)"
FRAMES_HELP: Final = (
    "Only for a single recording of which some frames were annotated, and where the ground truth "
    "does not tell which: a text file with the numbers of these frames. Without it every frame "
    "from the first to the last annotated one is evaluated, or every n-th where they lie regularly."
)
MOST_BYTES: Final = 100 << 20
"""Ten million frames with numbers of eight digits."""


@dataclass(frozen=True)
class FrameList:
    """A list of evaluated frames; its path, as a session names it, is None if it cannot be used."""

    path: str | None = None
    summary: str = ""
    trouble: str = ""

    @property
    def stops(self) -> str:
        """Why nothing is opened yet; empty: no reason."""
        if not self.trouble:
            return ""
        return "The list of evaluated frames cannot be used: the reason stands at its field."


def check_frame_list(path: str, folder: Path) -> FrameList:
    """Read a list that a session in `folder` names, unless it was read and has not changed."""
    return read_unless_known(
        "frame_list",
        folder / path,
        lambda: _read_list(path, folder),
        lambda trouble: FrameList(trouble=trouble),
        expected="a text file with one frame number a line",
        most_bytes=MOST_BYTES,
    )


def _read_list(path: str, folder: Path) -> FrameList:
    frames = frames_confined(path, folder)
    steps = np.diff(frames)
    summary = f"{len(frames):,} frames, {frames[0]} to {frames[-1]}"
    if len(steps) and steps[0] > 1 and (steps == steps[0]).all():
        summary += f", {steps[0]} apart"
    return FrameList(path, summary)


def draw_frame_list(frame_list: FrameList, recordings: Sequence[str]) -> FrameList:
    """What the list holds, or why it cannot be used with these recordings of the ground truth."""
    if not frame_list.trouble and len(recordings) > 1:
        frame_list = replace(
            frame_list,
            path=None,
            trouble=f"is of one recording, and the ground truth has {len(recordings):,}: give the "
            "list of each recording in a session file, as frames under its [[recording]]",
        )
    if frame_list.trouble:
        st.error(plain(frame_list.trouble), icon=":material/error:")
    else:
        st.caption(f"Read as {plain(frame_list.summary)}.")
    return frame_list
