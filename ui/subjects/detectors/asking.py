"""Detectors page: the current frame, and cached answers of the detector."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable
from typing import Any, Final, TypeVar

import numpy as np
import streamlit as st
from numpy.typing import NDArray

from nvcore.common.errors import MediaError
from nvcore.common.palette import Scheme, scheme_for
from nvcore.dataset.provenance import About
from nvcore.figures.style import plain
from nvcore.pictures import Picture
from nvcore.subjects.detectors.base import Detections
from nvcore.subjects.detectors.training.overlap import training_overlap
from ui.session import state
from ui.subjects.detectors.confined import DetectorFacts, DetectorSpec, describe, find, on_model

T = TypeVar("T")

MOST_QUESTIONS: Final = 2
"""Pictures of all visitors that are given to detectors at a time; others wait."""
MOST_KEPT: Final = 16
"""Cached answers of a kind."""
VIEWS_KEPT: Final = 4
"""Cached answers of a function of a model, which may be large."""

_turns = threading.BoundedSemaphore(MOST_QUESTIONS)


def ask(
    kind: str,
    function: Callable[..., T],
    spec: DetectorSpec,
    *arguments: Any,
    key: Any,
    most: int = MOST_KEPT,
) -> T:
    """Return the cached answer of a function of `ui.subjects.detectors.confined` for this `key`.

    Raises
    ------
    NvcoreError
        If the function raises it, or exceeds its allowance.
    """
    space = state.workspace()

    def make() -> T:
        with st.spinner("Running the detector"), _turns:
            return space.model_process.call(function, spec, *arguments, what="running the detector")

    return space.cached(f"detector_{kind}", (spec, key), make, most=most)


def ask_model(function: Callable[..., T], spec: DetectorSpec, *arguments: Any) -> T:
    """Return what a function says of an ICF model and the current frame, as `ask`."""
    key = (place(), *(part for part in arguments if not isinstance(part, np.ndarray)))
    kind = function.__name__
    answer: T = ask(kind, on_model, spec, function, *arguments, key=key, most=VIEWS_KEPT)
    return answer


def described(spec: DetectorSpec) -> DetectorFacts:
    """Describe the detector. Errors are as of `ask`."""
    return ask("about", describe, spec, key=None)


def found(spec: DetectorSpec, picture: Picture) -> Detections:
    """Return all boxes of the detector in the picture of the current frame, as `ask`."""
    return ask("boxes", find, spec, picture, key=place())


def on_frame(about: About) -> str:
    """Return the title of a figure of the detector on the current frame."""
    dataset, row = state.opened().dataset, state.row_in_all()
    frame, name = dataset.frame_columns.frame[row], state.recording_names()[state.recording()]
    return f"{plain(about.name)} on frame {frame} of {plain(name)}"


def theme_of(about: About) -> Scheme:
    """Return the theme in which the detector is Y, as it will be drawn once it is a system."""
    systems, shade = state.opened().dataset.systems, state.theme().shade
    return scheme_for(shade, [*systems, about.name], state.systems()[0], about.name)


def key_of(*parts: object) -> str:
    """Return a short hash, for the keys of widgets."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:12]


def place() -> tuple[int, int]:
    """Return recording and row of the current frame."""
    return state.recording(), state.row()


def truth_in(picture: Picture) -> NDArray[np.float64]:
    """Return the truth's boxes of the current frame in px of its picture, (n, 4)."""
    dataset, recording, row = state.opened().dataset, state.recording(), state.row_in_all()
    frames = dataset.frame_columns
    across = picture.shape[1] / float(frames.width[recording])
    down = picture.shape[0] / float(frames.height[recording])
    x, y, w, h = dataset.truth.of_frames(row, row + 1).xywh
    return np.column_stack([x * across, y * down, w * across, h * down])


def picture() -> tuple[Picture | None, str]:
    """Return the picture of the current frame, or None and why there is none."""
    space = state.workspace()
    pictures, index = space.picture_of(*place())
    if pictures is None or index < 0:
        note = space.pictures.notes.get(state.recording(), "")
        return None, note or "This frame has no picture."
    try:
        return pictures.read(index), ""
    except MediaError as error:
        return None, str(error)


def is_trained_frame(about: About) -> bool:
    """Return whether the detector was trained on the current frame."""
    return bool(_trained_frames(about)[state.row_in_all()])


def trained_recordings(about: About) -> list[str]:
    """Return names of open recordings that it was trained on, at least in part, in their order."""
    recording, names = state.opened().dataset.frame_columns.recording, state.recording_names()
    return [names[number] for number in np.unique(recording[_trained_frames(about)]).tolist()]


def _trained_frames(about: About) -> NDArray[np.bool_]:
    dataset, key = state.opened().dataset, tuple(about.trained_on)
    return state.workspace().cached(
        "detector_trained", key, lambda: training_overlap(dataset, key).is_trained, most=4
    )
