"""What the viewer needs to know of a recording, on whichever page."""

from __future__ import annotations

from typing import Any

import numpy as np

from nvcore.comparison import Result
from ui.session import state


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
