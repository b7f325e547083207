"""Detectors page: which of the open recordings the detector was trained on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import About
from nvcore.detectors.training.overlap import training_overlap
from ui.session import state


def is_trained_frame(about: About) -> bool:
    """Whether the detector was trained on the current frame."""
    return bool(_trained_frames(about)[state.row_in_all()])


def trained_recordings(about: About) -> list[str]:
    """Names of the open recordings that it was trained on, in part at least, in their order."""
    recording = state.opened().dataset.frame_columns.recording
    numbers = np.unique(recording[_trained_frames(about)]).tolist()
    names = state.recording_names()
    return [names[number] for number in numbers]


def _trained_frames(about: About) -> NDArray[np.bool_]:
    dataset = state.opened().dataset
    key = tuple(about.trained_on)
    return state.workspace().cached(
        "detector_trained", key, lambda: training_overlap(dataset, key).is_trained, most=4
    )
