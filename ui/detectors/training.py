"""Detectors page: which of the open recordings the detector was trained on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About
from nvcore.dataset.training import part_fingerprint, rows_of_part
from ui.session import state


def trained_frames(dataset: Dataset, about: About) -> NDArray[np.bool_]:
    """Which evaluated frames the detector was trained on, bool, shape (n_frames,).

    As the audit knows them: by the name of the recording, under another name by its ground truth.
    """
    is_trained = np.zeros(len(dataset.frames), dtype=bool)
    number_of = {name: number for number, name in enumerate(dataset.recordings["name"])}
    for part in about.trained_on:
        named = number_of.get(part.recording)
        if named is not None:
            is_trained[rows_of_part(dataset, named, part)] = True
            continue
        for number in number_of.values() if part.fingerprint else ():
            rows = rows_of_part(dataset, number, part)
            if part_fingerprint(dataset, rows) == part.fingerprint:
                is_trained[rows] = True
    return is_trained


def is_trained_frame(about: About) -> bool:
    """Whether the detector was trained on the current frame."""
    return bool(_kept(about)[state.row_in_all()])


def trained_recordings(about: About) -> list[str]:
    """Names of the open recordings that it was trained on, in part at least, in their order."""
    recording = state.opened().dataset.frame_columns.recording
    numbers = np.unique(recording[_kept(about)]).tolist()
    names = state.recording_names()
    return [names[number] for number in numbers]


def _kept(about: About) -> NDArray[np.bool_]:
    dataset = state.opened().dataset
    key = tuple(about.trained_on)
    return state.workspace().cached(
        "detector_trained", key, lambda: trained_frames(dataset, about), most=4
    )
