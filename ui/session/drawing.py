"""What pages draw of the open recordings: pictures, what a miss would cost, and their viewer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import streamlit as st

from nvcore.comparison import Result
from nvcore.metrics.cost_map import CostMap, map_cost
from nvcore.params.metadata import COST
from nvcore.pictures.recordings import STRETCH
from ui.session import state

MOST_THUMBNAILS: Final = 64
LEAST_STRETCH: Final = 0.1
"""Least distance of the two percentiles of the display stretch."""


def cost_map_of(recording: int) -> CostMap:
    """The cost map of a recording with the live parameters."""
    dataset, settings = state.opened().dataset, state.params().only_for(COST)
    return state.cached(
        "cost_map",
        (settings, recording),
        lambda: map_cost(dataset.truth, dataset.frame_columns, settings, recording),
        most=8,
    )


def thumbnail(row_of_all: int, draw: Callable[[], bytes]) -> bytes:
    """A drawn picture, cached while nothing that shows in it changes."""
    key = (state.workspace().version, stretch(), row_of_all)  # other pictures forget all
    return state.cached("thumbnails", key, draw, most=MOST_THUMBNAILS)


def stretch() -> tuple[float, float]:
    """Percentiles of the display stretch."""
    lo, hi = st.session_state.get("stretch", STRETCH)
    lo = min(float(lo), 100 - LEAST_STRETCH)
    return lo, max(float(hi), lo + LEAST_STRETCH)


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
