"""Pictures of the open recordings for the pages: thumbnails, cost maps, arguments of the viewer."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Final

import numpy as np

from nvcore.comparison import Result
from nvcore.metrics.cost_map import CostMap, map_cost
from nvcore.metrics.proximity.borrowing import weighing_truth
from nvcore.overlay.annotate import LAYERS, annotate
from nvcore.pictures.base import PictureReader
from nvcore.pictures.mapped import MappedPictures
from nvcore.pictures.stretch import STRETCH
from nvcore.stages import COST
from ui.session import state, store
from ui.session.look import VisiblePictures
from ui.subjects import contributed

MOST_THUMBNAILS: Final = 64
HEIGHTS: Final = 2.2
"""Height of a cut-out in heights of the pedestrian."""
LEAST: Final = 0.4
"""Least height of a cut-out, as a share of the picture's."""
ASPECT: Final = 1.6
"""Width of a cut-out over its height."""
LEAST_STRETCH: Final = 0.1
"""Least distance of the two percentiles of the display stretch."""


def cost_map_of(recording: int) -> CostMap:
    """The cost map of a recording with the live parameters."""
    dataset, settings = state.opened().dataset, state.params().only_for(COST)
    return state.cached(
        "cost_map",
        (settings, recording),
        lambda: map_cost(
            weighing_truth(dataset, settings), dataset.frame_columns, settings, recording
        ),
        most=8,
    )


def thumbnail(what: Hashable, draw: Callable[[], bytes]) -> bytes:
    """Picture of (part of) a frame with its boxes; cached while nothing in it changes."""
    key = (state.workspace().version, stretch(), what)  # other pictures forget all
    return state.cached("thumbnails", key, draw, most=MOST_THUMBNAILS)


def part_of_frame(
    result: Result,
    row: int,
    xywh: np.ndarray | None,
    *,
    labels: bool,
    is_visible: bool = False,
) -> np.ndarray:
    """The part of a frame around a box (px), with the boxes of truth, X and Y.

    Without a box the whole frame; without pictures the boxes on a blank.

    Parameters
    ----------
    is_visible
        Whether of visible light, which the frame `has_visible`.
    """
    recording, in_recording = state.place_of(row)
    pictures: PictureReader | None
    pictures, picture = state.workspace().picture_of(recording, in_recording)
    lo, hi = stretch()
    if is_visible:
        pictures, picture = _visible_in_place(result, recording, in_recording)
        lo, hi = 0.0, 100.0
    annotated = annotate(
        result, pictures, picture, row, lo=lo, hi=hi, layers=LAYERS, labels=labels, caption=False
    )
    if xywh is None:
        return annotated
    frames = result.dataset.frame_columns
    scale = (
        annotated.shape[1] / frames.width[recording],
        annotated.shape[0] / frames.height[recording],
    )
    return np.ascontiguousarray(cut_out(annotated, xywh * np.tile(scale, 2)))


def cut_out(picture: np.ndarray, xywh: np.ndarray) -> np.ndarray:
    """The part of a picture around a box, wide enough to show where it is."""
    x, y, w, h = xywh
    n_rows, n_columns = picture.shape[:2]
    high = int(min(n_rows, max(HEIGHTS * h, LEAST * n_rows)))
    wide = int(min(n_columns, ASPECT * high))
    top = int(np.clip(y + h / 2 - high / 2, 0, n_rows - high))
    left = int(np.clip(x + w / 2 - wide / 2, 0, n_columns - wide))
    return picture[top : top + high, left : left + wide]


def stretch() -> tuple[float, float]:
    """Percentiles of the display stretch."""
    lo, hi = store.STRETCH.get() or STRETCH
    lo = min(float(lo), 100 - LEAST_STRETCH)
    return lo, max(float(hi), lo + LEAST_STRETCH)


def viewer_arguments(
    result: Result, recording: int, *, with_visible: bool = True
) -> dict[str, Any]:
    """Arguments of `viewer` for the pictures, frames and boxes of a recording.

    Parameters
    ----------
    with_visible
        Whether pictures of visible light may be seen, too: what is known of the light takes time.
    """
    space, frames = state.workspace(), result.dataset.frame_columns
    in_recording = frames.rows_of(recording)
    numbers = frames.frame[in_recording]
    rows = space.pictures.indices.get(recording)
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
        "objects": result.dataset.objects,
        "visible": visible_of(recording) if with_visible else None,
    }


def has_visible(row: int) -> bool:
    """Whether a frame has a picture of visible light besides its own."""
    recording, in_recording = state.place_of(row)
    visible = state.workspace().visible
    return recording in visible.sources and bool(visible.indices[recording][in_recording] >= 0)


def _visible_in_place(
    result: Result, recording: int, in_recording: int
) -> tuple[PictureReader, int]:
    """Visible-light pictures cropped to the recording's view, and the index for that frame."""
    visible, frames = state.workspace().visible, result.dataset.frame_columns
    size = float(frames.width[recording]), float(frames.height[recording])
    source = MappedPictures(visible.sources[recording], visible.maps[recording], size)
    return source, int(visible.indices[recording][in_recording])


def visible_of(recording: int) -> VisiblePictures | None:
    """Visible-light pictures of a recording; None if it has none."""
    pictures = state.workspace().visible
    if recording not in pictures.sources:
        return None
    visible = VisiblePictures(pictures.area_of(recording), pictures.indices[recording] >= 0)
    for sight in contributed("SIGHT"):
        visible = sight.add_light(recording, visible)
    return visible
