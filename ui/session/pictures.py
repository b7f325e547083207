"""Which picture shows which frame of the open comparison."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from nvcore.dataset import Dataset
from nvcore.errors import MediaError
from nvcore.inputs.session import Session
from nvcore.pictures import Pictures, open_pictures, picture_index, size_note
from ui.session.opening import recording_entry
from ui.session.workspace import Workspace


@dataclass(frozen=True)
class Picturing:
    """Pictures by recording index: open sources, the picture of each frame (-1: none), and why.

    A recording without pictures has no source.
    """

    sources: Mapping[int, Pictures]
    indices: Mapping[int, np.ndarray]
    notes: Mapping[int, str]


def find_pictures(session: Session, dataset: Dataset) -> Picturing:
    """Open the pictures that a session names; what cannot be opened is told in the notes."""
    names = [str(name) for name in dataset.recordings["name"]]
    frames = dataset.frame_columns
    sources: dict[int, Pictures] = {}
    indices: dict[int, np.ndarray] = {}
    notes: dict[int, str] = {}
    for number in range(len(names)):
        entry = recording_entry(session, names, names[number])
        if entry.pictures is None:
            continue
        try:
            pictures = open_pictures(session.folder / entry.pictures)
        except MediaError as error:
            notes[number] = error.message
            continue
        listed = frames.frame[frames.first[number] : frames.first[number + 1]]
        index, note = picture_index(listed, pictures, entry.first_picture)
        other_size = size_note(pictures, float(frames.width[number]), float(frames.height[number]))
        sources[number], indices[number] = pictures, index
        notes[number] = " ".join(part for part in (note, other_size) if part)
    return Picturing(sources, indices, notes)


def picture_of(space: Workspace, recording: int, row: int) -> tuple[Pictures | None, int]:
    """The pictures of a recording, and which of them shows a frame (row within it); -1: none."""
    pictures, indices = space.pictures.get(recording), space.picture_rows.get(recording)
    if pictures is None or indices is None:
        return None, -1
    return pictures, int(indices[row])
