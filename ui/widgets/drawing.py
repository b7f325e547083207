"""Pictures of the open recordings: their look, thumbnails, and arguments of the viewer."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple

import cv2
import numpy as np
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.figures.overlay.annotate import LAYERS, annotate
from nvcore.metrics.cost_map import CostMap, map_cost
from nvcore.metrics.proximity.borrowing import weighing_truth
from nvcore.pictures.base import Picture, PictureReader
from nvcore.pictures.mapped import MappedPictures
from nvcore.pictures.stretch import STRETCH, jpeg
from nvcore.settings.stages import COST
from ui.session import state, store
from ui.subject import all_sights

NAMES: Final = ("picture", "blend", "seen_s")
"""Address entries of a look."""
CHOICES: Final = ("own", "visible", "blended", "both")
MOST_SECONDS: Final = 10.0
"""Maximum time after a change of light that users can choose."""
CLOCK: Final = "clock"
"""Value instead of seconds: time since the recording's own change of light, frame by frame."""
MOST_THUMBNAILS: Final = 64
HEIGHTS: Final = 2.2
"""Height of a cut-out in multiples of the pedestrian's height."""
LEAST: Final = 0.4
"""Minimum height of a cut-out, as a share of the picture's."""
ASPECT: Final = 1.6
"""Width of a cut-out over its height by default."""
LEAST_STRETCH: Final = 0.1
"""Minimum distance of the two percentiles of the display stretch."""


class VisiblePictures(NamedTuple):
    """Visible-light pictures of a recording, in addition to its own.

    Attributes
    ----------
    area
        x, y, w, h of the area that they show, px of the recording.
    has_picture
        Rows with a visible-light picture, bool, shape (n_rows,).
    seen_s
        Seconds since a change of light at the end of each row, float64, shape (n_rows,). inf: the
        eyes are adapted. NaN: unknown. None: the light is unknown.
    is_simulated
        Rows whose seconds count from a simulated change, bool, shape (n_rows,). None: no row.
    change_s
        Times of real changes, also between rows, on the time axis of the rows, float64, ascending.
        A change simulated by the viewer ends there.
    can_simulate
        Whether the viewer offers to simulate a change of light. False if the page does so.
    """

    area: tuple[float, float, float, float]
    has_picture: np.ndarray
    seen_s: np.ndarray | None = None
    is_simulated: np.ndarray | None = None
    change_s: np.ndarray = np.empty(0)
    can_simulate: bool = True


@dataclass(frozen=True)
class Sight:
    """Simulation of how eyes see the visible-light pictures of a recording.

    Attributes
    ----------
    label, hint
        Label and help text of the viewer's button.
    add_light
        Adds the known light to a recording's `VisiblePictures`.
    trouble
        Returns why the light of a recording is unknown, in a sentence, or "" without a reason.
    show
        Returns a picture as eyes see it some seconds after a change of light. Infinite: adapted.
    """

    label: str
    hint: str
    add_light: Callable[[int, VisiblePictures], VisiblePictures]
    trouble: Callable[[int], str]
    show: Callable[[Picture, float], Picture]


class Look(NamedTuple):
    """Choice of how to show the pictures of a recording.

    Attributes
    ----------
    picture
        "own", "visible", "blended" or "both" (side by side). Without visible-light pictures, the
        recording's own are shown.
    blend
        Share of visible light in a blended picture, 0..1.
    seen_s
        Seconds after a change of light for which visible light is shown as eyes see it. `CLOCK`:
        those of the recording at each frame. None: unchanged pictures.
    """

    picture: str = "own"
    blend: float = 0.5
    seen_s: float | Literal["clock"] | None = None


OWN_PICTURES: Final = Look()


def look() -> Look:
    """Return the look in this browser session: as chosen, or else as in the address."""
    known = store.LOOK.get()
    if known is None:
        known = from_address(st.query_params.to_dict()) or OWN_PICTURES
        store.LOOK.set(known)
    return known


def keep_look(chosen: Look) -> None:
    """Use this look from now on, and write it to the page's address."""
    store.LOOK.set(chosen)
    state.write_address(to_address(chosen), NAMES)


def to_address(chosen: Look) -> dict[str, str]:
    """Return a look as query parameters, without defaults.

    Examples
    --------
    >>> to_address(Look("visible", seen_s=1.5))
    {'picture': 'visible', 'seen_s': '1.5'}
    >>> to_address(Look("visible", seen_s=CLOCK))
    {'picture': 'visible', 'seen_s': 'clock'}
    >>> to_address(Look())
    {}
    """
    entries = {}
    if chosen.picture != OWN_PICTURES.picture:
        entries["picture"] = chosen.picture
    if chosen.picture == "blended":
        entries["blend"] = f"{chosen.blend:g}"
    if chosen.seen_s is not None:
        seen_s = chosen.seen_s
        entries["seen_s"] = seen_s if isinstance(seen_s, str) else f"{seen_s:g}"
    return entries


def from_address(query: Mapping[str, str]) -> Look | None:
    """Parse a look from query parameters. Return None if there is no valid one."""
    sent = {name: query[name] for name in NAMES if name in query}
    if not sent:
        return None
    numbers = {name: _sent(text) for name, text in sent.items() if name in NAMES[1:]}
    return read_look({"picture": sent.get("picture", OWN_PICTURES.picture), **numbers})


def read_look(sent: Any) -> Look | None:
    """Parse a look from a browser message or an address. Return None if there is no valid one."""
    if not isinstance(sent, Mapping) or sent.get("picture") not in CHOICES:
        return None
    blend = _within(sent.get("blend"), 1.0)
    seen_s: float | Literal["clock"] | None = _within(sent.get("seen_s"), MOST_SECONDS)
    if sent.get("seen_s") == CLOCK:
        seen_s = CLOCK
    return Look(sent["picture"], OWN_PICTURES.blend if blend is None else blend, seen_s)


def _within(value: Any, greatest: float) -> float | None:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None
    return float(value) if math.isfinite(value) and 0 <= value <= greatest else None


def _sent(text: str) -> float | str | None:
    if text == CLOCK:
        return text
    try:
        return float(text)
    except ValueError:
        return None


def cost_map_of(recording: int) -> CostMap:
    """Return the cost map of a recording with the current parameters."""
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
    """Return a cached picture of a frame, or part of it, with its boxes."""
    # a new version of the pictures invalidates all
    key = (state.workspace().version, stretch(), what)
    return state.cached("thumbnails", key, draw, most=MOST_THUMBNAILS)


def part_of_frame(
    result: Result,
    row: int,
    xywh: np.ndarray | None,
    *,
    labels: bool,
    layers: Sequence[str] = LAYERS,
    aspect: float = ASPECT,
    is_visible: bool = False,
) -> np.ndarray:
    """Return the part of a frame around a box (px), with the boxes of truth, X and Y.

    Without a box it is the whole frame. Without pictures, the boxes are on a blank area.

    Parameters
    ----------
    layers
        See `nvcore.figures.overlay.annotate`.
    aspect
        Width over height.
    is_visible
        Use visible light, which requires `has_visible`.
    """
    recording, in_recording = state.place_of(row)
    pictures: PictureReader | None
    pictures, picture = state.workspace().picture_of(recording, in_recording)
    lo, hi = stretch()
    if is_visible:
        pictures, picture = _visible_in_place(result, recording, in_recording)
        lo, hi = 0.0, 100.0
    annotated = annotate(
        result, pictures, picture, row, lo=lo, hi=hi, layers=layers, labels=labels, caption=False
    )
    return annotated if xywh is None else cut_scaled(result, recording, annotated, xywh, aspect)


def cut_scaled(
    result: Result, recording: int, drawn: np.ndarray, xywh: np.ndarray, aspect: float = ASPECT
) -> np.ndarray:
    """Return the part around a box (px of the recording) of a frame drawn at any size."""
    frames = result.dataset.frame_columns
    scale = (drawn.shape[1] / frames.width[recording], drawn.shape[0] / frames.height[recording])
    return np.ascontiguousarray(cut_out(drawn, xywh * np.tile(scale, 2), aspect))


def small_jpeg(part: np.ndarray, most_px: int) -> bytes:
    """Encode a drawing as JPEG, at most so many pixels wide."""
    scale = min(most_px / part.shape[1], 1.0)
    return jpeg(cv2.resize(part, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))


def cut_out(picture: np.ndarray, xywh: np.ndarray, aspect: float = ASPECT) -> np.ndarray:
    """Return the part of a picture around a box, wide enough to show where it is."""
    x, y, w, h = xywh
    n_rows, n_columns = picture.shape[:2]
    high = int(min(n_rows, max(HEIGHTS * h, LEAST * n_rows)))
    wide = int(min(n_columns, aspect * high))
    top = int(np.clip(y + h / 2 - high / 2, 0, n_rows - high))
    left = int(np.clip(x + w / 2 - wide / 2, 0, n_columns - wide))
    return picture[top : top + high, left : left + wide]


def stretch() -> tuple[float, float]:
    """Return the percentiles of the display stretch."""
    lo, hi = store.STRETCH.get() or STRETCH
    lo = min(float(lo), 100 - LEAST_STRETCH)
    return lo, max(float(hi), lo + LEAST_STRETCH)


def viewer_arguments(
    result: Result, recording: int, *, with_visible: bool = True
) -> dict[str, Any]:
    """Return the arguments of `viewer` for pictures, frames and boxes of a recording.

    Parameters
    ----------
    with_visible
        Offer visible-light pictures. Finding the known light takes time.
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
    """Whether a frame has a visible-light picture in addition to its own."""
    recording, in_recording = state.place_of(row)
    visible = state.workspace().visible
    return recording in visible.sources and bool(visible.indices[recording][in_recording] >= 0)


def _visible_in_place(
    result: Result, recording: int, in_recording: int
) -> tuple[PictureReader, int]:
    """Return visible-light pictures cropped to the recording's view, and the index for a frame."""
    visible, frames = state.workspace().visible, result.dataset.frame_columns
    size = float(frames.width[recording]), float(frames.height[recording])
    source = MappedPictures(visible.sources[recording], visible.maps[recording], size)
    return source, int(visible.indices[recording][in_recording])


def visible_of(recording: int) -> VisiblePictures | None:
    """Return the visible-light pictures of a recording, or None if it has none."""
    pictures = state.workspace().visible
    if recording not in pictures.sources:
        return None
    visible = VisiblePictures(pictures.area_of(recording), pictures.indices[recording] >= 0)
    for sight in all_sights():
        visible = sight.add_light(recording, visible)
    return visible
