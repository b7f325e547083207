"""Open pictures of the recordings of a session."""

from __future__ import annotations

import glob
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path, PurePosixPath
from typing import Any, Final, Literal

import numpy as np

from nvcore.common.errors import MediaError
from nvcore.common.findings import Step
from nvcore.common.wording import MOST_NAMED, listed, one_line
from nvcore.dataset import Dataset
from nvcore.dataset.columns import FrameColumns
from nvcore.inputs.session import Session
from nvcore.pictures.base import Pictures
from nvcore.pictures.index import FrameMap, NumberingRule, map_frames, size_note
from nvcore.pictures.open import open_pictures
from nvcore.pictures.stretch import STRETCH

Source = Literal["pictures", "visible"]
"""Key of a session's ``[[recording]]`` that names pictures."""
NO_PICTURES: Final = "no evaluated frame has a picture"


@dataclass(frozen=True)
class RecordingPictures:
    """Open pictures by recording (row of the recordings table).

    Attributes
    ----------
    sources
        Pictures. A recording without them is absent.
    indices
        Picture of each frame of a recording, -1 none; int64, shape (n_frames_of_recording,).
    stretch
        Percentiles of the grey levels (`nvcore.pictures.stretch`).
    notes
        Which picture shows which frame, in words, or why there is no source.
    frame_maps
        Which picture shows which frame, if there is a source.
    steps
        Suggested fixes where pictures cannot be opened.
    maps
        (sx, sy, dx, dy): the point (x, y) of the recording, px, is (sx x + dx, sy y + dy) in its
        pictures.
    """

    sources: dict[int, Pictures] = field(default_factory=dict)
    indices: dict[int, np.ndarray] = field(default_factory=dict)
    stretch: tuple[float, float] = STRETCH
    notes: dict[int, str] = field(default_factory=dict)
    frame_maps: dict[int, FrameMap] = field(default_factory=dict)
    steps: dict[int, tuple[Step, ...]] = field(default_factory=dict)
    maps: dict[int, tuple[float, float, float, float]] = field(default_factory=dict)

    def renumbered(self, number_of: Mapping[int, int]) -> RecordingPictures:
        """Return the pictures of some recordings under other numbers, by their numbers so far."""
        by_recording = (item.name for item in fields(self) if item.name != "stretch")
        changed: dict[str, Any] = {
            name: {
                number_of[old]: value
                for old, value in getattr(self, name).items()
                if old in number_of
            }
            for name in by_recording
        }
        return replace(self, **changed)

    def area_of(self, recording: int) -> tuple[float, float, float, float]:
        """Area of the pictures: x, y, w, h, px of the recording."""
        across, down, right, lower = self.maps[recording]
        source = self.sources[recording]
        return -right / across, -lower / down, source.width / across, source.height / down

    @property
    def troubles(self) -> dict[int, str]:
        """Reasons, by recording, for which pictures that are named cannot be shown."""
        return {
            number: note
            for number, note in self.notes.items()
            if number not in self.sources
            or (number in self.frame_maps and self.frame_maps[number].rule is NumberingRule.UNCLEAR)
        }

    def why_none(self, *others: RecordingPictures, how: str) -> str:
        """Say that no frame has a picture, why, and how pictures are named.

        Parameters
        ----------
        others
            More pictures that were tried.
        how
            How pictures are named in the session file, in words.
        """
        troubles = dict(item for tried in (self, *others) for item in tried.troubles.items())
        why = list(dict.fromkeys(map(one_line, troubles.values())))
        cause = [listed(why, most=MOST_NAMED).rstrip(".")] if why else []
        return (
            f"{': '.join([NO_PICTURES, *cause])}; name the pictures of each recording in the "
            f"session file ({how} under [[recording]])"
        )

    def another(self) -> RecordingPictures:
        """Return the same pictures for another reader (`Pictures.another`)."""
        sources = {number: pictures.another() for number, pictures in self.sources.items()}
        return replace(self, sources=sources)

    def close(self) -> None:
        """Release files and memory."""
        for pictures in self.sources.values():
            pictures.close()


def picture_names(
    frames: FrameColumns, rows: Iterable[int], pictures: RecordingPictures
) -> dict[int, str]:
    """Return the file name of the picture that shows a frame, by the row of the frame.

    Frames without a picture file, such as those of a video, are absent.
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
    """Open the pictures that a session names.

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
        Setting of the session that names them: the recording's own pictures, or those of visible
        light that were taken beside them.
    """
    names = [str(name) for name in dataset.recordings["name"]]
    entries, frames, found = session.entries(names), dataset.frame_columns, RecordingPictures()
    for number, name in enumerate(names):
        entry = entries.get(name)
        path = None if entry is None else getattr(entry, key)
        if entry is None or path is None or (recordings is not None and number not in recordings):
            continue
        try:
            pictures = (opener or open_pictures)(session.folder / path)
        except MediaError as error:
            inner = f"{error.file}: " if error.file and error.file not in path else ""
            found.notes[number] = f"{path}: {inner}{error.message}"
            folder = str(PurePosixPath(path).parent) if glob.has_magic(path) else path.rstrip("/")
            found.steps[number] = tuple(
                replace(step, value=f"{folder}/{step.value}", subject=name) for step in error.steps
            )
            continue
        listed, others = frames.frame[frames.rows_of(number)], dataset.unlisted_frames(name)
        first, fps = entry.first_picture, float(frames.fps[number])
        mapped = map_frames(listed, pictures, first, others=others, fps=fps)
        width, height = float(frames.width[number]), float(frames.height[number])
        other_size = size_note(pictures, width, height) if key == "pictures" else ""
        found.sources[number], found.frame_maps[number] = pictures, mapped
        found.indices[number] = mapped.index
        found.notes[number] = f"{mapped.note} {other_size}".rstrip()
        found.maps[number] = (entry.visible_map if key == "visible" else None) or (
            pictures.width / width,
            pictures.height / height,
            0.0,
            0.0,
        )
    return found
