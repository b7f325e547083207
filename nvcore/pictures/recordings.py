"""The pictures that a session names for its recordings, opened."""

from __future__ import annotations

import glob
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path, PurePosixPath
from typing import Any, Final, Literal

import numpy as np

from nvcore.columns import FrameColumns
from nvcore.dataset import Dataset
from nvcore.errors import MediaError
from nvcore.findings import Step
from nvcore.inputs.session import Session
from nvcore.pictures.base import Pictures
from nvcore.pictures.index import FrameMap, NumberingRule, map_frames, map_note, size_note
from nvcore.pictures.open import open_pictures
from nvcore.pictures.stretch import STRETCH
from nvcore.wording import MOST_NAMED, listed, one_line

Source = Literal["pictures", "visible"]
"""Key of a session's ``[[recording]]`` that names pictures."""
NO_PICTURES: Final = "no evaluated frame has a picture"


@dataclass(frozen=True)
class RecordingPictures:
    """Open pictures by recording (row of the recordings table).

    Attributes
    ----------
    sources
        A recording without pictures is absent.
    indices
        Picture of each frame of a recording, -1 none; int64, shape (n_frames_of_recording,).
    stretch
        Percentiles of the grey levels (`nvcore.pictures.stretch`).
    notes
        Which picture shows which frame, in words; without a source, why it cannot be opened.
    frame_maps
        The same as data, of those with a source.
    steps
        Ways on where pictures cannot be opened.
    maps
        (sx, sy, dx, dy) by recording: what is at (x, y) of the recording, px, is at
        (sx x + dx, sy y + dy) of its pictures.
    """

    sources: Mapping[int, Pictures] = field(default_factory=dict)
    indices: Mapping[int, np.ndarray] = field(default_factory=dict)
    stretch: tuple[float, float] = STRETCH
    notes: Mapping[int, str] = field(default_factory=dict)
    frame_maps: Mapping[int, FrameMap] = field(default_factory=dict)
    steps: Mapping[int, tuple[Step, ...]] = field(default_factory=dict)
    maps: Mapping[int, tuple[float, float, float, float]] = field(default_factory=dict)

    def renumbered(self, number_of: Mapping[int, int]) -> RecordingPictures:
        """Those of some recordings under other numbers, by their numbers so far."""

        def of_those(values: Mapping[int, Any]) -> dict[int, Any]:
            return {number_of[old]: value for old, value in values.items() if old in number_of}

        changed: dict[str, Any] = {
            item.name: of_those(getattr(self, item.name))
            for item in fields(self)
            if item.name != "stretch"
        }
        return replace(self, **changed)

    def area_of(self, recording: int) -> tuple[float, float, float, float]:
        """Where its pictures lie: x, y, w, h, px of the recording."""
        across, down, right, lower = self.maps[recording]
        source = self.sources[recording]
        return -right / across, -lower / down, source.width / across, source.height / down

    @property
    def troubles(self) -> dict[int, str]:
        """Why a recording has no pictures although it names some, by recording."""
        return {
            number: note
            for number, note in self.notes.items()
            if number not in self.sources
            or (number in self.frame_maps and self.frame_maps[number].rule is NumberingRule.UNCLEAR)
        }

    def why_none(self, *others: RecordingPictures, how: str) -> str:
        """That no frame has a picture, why, and how pictures are named.

        Parameters
        ----------
        others
            More pictures that were tried.
        how
            To name pictures in the session file, in words.
        """
        troubles: dict[int, str] = {}
        for tried in (self, *others):
            troubles |= tried.troubles
        why = list(dict.fromkeys(map(one_line, troubles.values())))
        cause = [listed(why, most=MOST_NAMED).rstrip(".")] if why else []
        return (
            f"{': '.join([NO_PICTURES, *cause])}; name the pictures of each recording in the "
            f"session file ({how} under [[recording]])"
        )

    def another(self) -> RecordingPictures:
        """The same for another reader; see `Pictures.another`."""
        sources = {number: pictures.another() for number, pictures in self.sources.items()}
        return replace(self, sources=sources)

    def close(self) -> None:
        """Release files and memory."""
        for pictures in self.sources.values():
            pictures.close()


def picture_names(
    frames: FrameColumns, rows: Iterable[int], pictures: RecordingPictures
) -> dict[int, str]:
    """File name of the picture that shows a frame, by the row of the frame.

    Frames without a picture of their own, such as those of a video, are absent.

    Parameters
    ----------
    frames
        Of the dataset.
    rows
        Rows of frames.
    pictures
        Those of the recordings.
    """
    names: dict[int, str] = {}
    every = np.unique(np.asarray([*rows], dtype=np.int64))
    for recording in np.unique(frames.recording[every]):
        if recording not in pictures.sources:
            continue
        mine = every[frames.recording[every] == recording]
        index = pictures.indices[recording][mine - frames.first[recording]]
        mine, index = mine[index >= 0], index[index >= 0]
        try:
            file_names = pictures.sources[recording].file_names([*map(int, index)])
        except MediaError:  # they were there when they were opened
            continue
        names |= zip(map(int, mine), file_names or (), strict=False)
    return names


def session_pictures(
    session: Session,
    dataset: Dataset,
    recordings: Collection[int] | None = None,
    *,
    opener: Callable[[Path], Pictures] | None = None,
    key: Source = "pictures",
) -> RecordingPictures:
    """Open the pictures that a session names; `notes` says what cannot be opened.

    Parameters
    ----------
    session
        Names the pictures.
    dataset
        Its recordings and frames.
    recordings
        Rows of the recordings table whose pictures are needed; None: all.
    opener
        Opens the pictures of a recording, and raises `MediaError` if it cannot; None:
        `open_pictures`.
    key
        Under which the session names them: those of the recording, or those of visible light that
        were taken beside them.
    """
    names = [str(name) for name in dataset.recordings["name"]]
    entries = session.entries(names)
    frames = dataset.frame_columns
    sources: dict[int, Pictures] = {}
    indices: dict[int, np.ndarray] = {}
    notes: dict[int, str] = {}
    maps: dict[int, tuple[float, float, float, float]] = {}
    frame_maps: dict[int, FrameMap] = {}
    steps: dict[int, tuple[Step, ...]] = {}
    for number, name in enumerate(names):
        entry = entries.get(name)
        path = None if entry is None else getattr(entry, key)
        is_needed = recordings is None or number in recordings
        if entry is None or path is None or not is_needed:
            continue
        try:
            pictures = (opener or open_pictures)(session.folder / path)
        except MediaError as error:
            inner = f"{error.file}: " if error.file and error.file not in path else ""
            notes[number] = f"{path}: {inner}{error.message}"
            folder = str(PurePosixPath(path).parent) if glob.has_magic(path) else path.rstrip("/")
            steps[number] = tuple(
                replace(step, value=f"{folder}/{step.value}", subject=name) for step in error.steps
            )
            continue
        listed = frames.frame[frames.rows_of(number)]
        others = dataset.unlisted_frames(name)
        first, fps = entry.first_picture, float(frames.fps[number])
        mapped = map_frames(listed, pictures, first, others=others, fps=fps)
        note = map_note(mapped, listed, pictures, first)
        indices[number], frame_maps[number] = mapped.index, mapped
        other_size = ""
        size = float(frames.width[number]), float(frames.height[number])
        of_size = pictures.width / size[0], pictures.height / size[1], 0.0, 0.0
        maps[number] = (entry.visible_map if key == "visible" else None) or of_size
        if key == "pictures":
            other_size = size_note(pictures, *size)
        sources[number] = pictures
        notes[number] = " ".join(part for part in (note, other_size) if part)
    return RecordingPictures(
        sources, indices, notes=notes, frame_maps=frame_maps, steps=steps, maps=maps
    )
