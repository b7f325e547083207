"""What the viewer needs to know of a recording, on whichever page."""

from __future__ import annotations

from typing import Any

import numpy as np

from nvcore.comparison import Result
from ui.session import state


def viewer_arguments(result: Result, recording: int) -> dict[str, Any]:
    """The arguments of `viewer` that say which pictures, frames and boxes there are."""
    space, frames = state.workspace(), result.dataset.frame_columns
    first, last = int(frames.first[recording]), int(frames.first[recording + 1])
    rows = space.picture_rows.get(recording)
    return {
        "token": space.token,
        "recording": recording,
        "n_rows": last - first,
        "width": float(frames.width[recording]),
        "height": float(frames.height[recording]),
        "fps": float(frames.fps[recording]),
        "frames": frames.frame[first:last],
        "times_s": result.dataset.frames["time_s"].to_numpy()[first:last],
        "has_picture": np.zeros(last - first, dtype=bool) if rows is None else rows >= 0,
        "version": space.version,
        "picture_version": space.pictures_version,
        "theme": state.theme(),
    }
