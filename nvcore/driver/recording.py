"""Pictures, gaze and light of one recording, as the driver saw it."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.driver.features.view import has_colour
from nvcore.driver.fixation import FixedPoint, Gaze, read_gaze
from nvcore.driver.illumination import Light, read_light
from nvcore.errors import InputError, MediaError
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.notes import Note
from nvcore.pictures import Pictures, RecordingPictures, session_pictures
from nvcore.pictures.index import is_of_other_shape
from nvcore.wording import one_line

_HOW_TO_NAME: Final = 'visible = "drive.mp4", or pictures = "drive.mp4",'
_LOOKED_AT: Final = (0.5, 0.1, 0.9)
"""Relative positions of the pictures that are checked for colour."""


class DriverRecording:
    """Recording with the data on the driver's view.

    Parameters
    ----------
    number
        Row of the dataset's recordings.
    entry
        Entry of the session on the recording.
    opened
        Pictures of visible light if the session names them, else the recording's own.
    gaze
        Gaze of the driver. None: a point is assumed.
    light
        Readings of a light meter, or None.

    Attributes
    ----------
    index
        Picture of each evaluated frame, -1 none, int64.
    picture_note
        Why frames have no picture, or an empty text.
    is_visible
        True if the session declares the pictures as visible light.
    to_picture
        (sx, sy, dx, dy): x of the picture is sx x + dx of the recording.
    has_map
        True if `to_picture` is a ``visible_map`` of the session, False if it is from the sizes.
    may_be_of_heat
        True if the pictures are grey and not declared as visible light.
    needs_light
        True if the pictures have to replace a light meter.
    doubts
        Signs that the pictures belong to another recording, in sentences.
    """

    def __init__(
        self,
        number: int,
        entry: RecordingEntry,
        dataset: Dataset,
        opened: RecordingPictures,
        gaze: Gaze | None,
        light: Light | None,
    ):
        self.number, self.gaze, self.light = number, gaze, light
        self.name, self.name_in_data = str(dataset.recordings["name"].iloc[number]), entry.name
        self.is_visible = entry.visible is not None
        self.kind = "visible" if self.is_visible else "own"
        self.has_map = self.is_visible and entry.visible_map is not None
        self.pictures = source = opened.sources.get(number)
        self.picture_px = None if source is None else (source.width, source.height)
        rows = dataset.frame_columns.rows_of(number)
        self.index = opened.indices.get(number, np.full(rows.stop - rows.start, -1))
        note = opened.notes.get(number, "No pictures are named for it.")
        self.picture_note = "" if (self.index >= 0).all() else one_line(note)
        self.to_picture = opened.maps.get(number, (1.0, 1.0, 0.0, 0.0))
        self.may_be_of_heat = self.needs_light = False
        self.doubts: tuple[Note, ...] = ()
        if source is not None:
            self.may_be_of_heat = not (self.is_visible or _has_colour(source, self.index))
            self.needs_light = light is None and not self.may_be_of_heat
            self.doubts = _doubts(source, dataset, number, entry, self.has_map)

    def boxes_in_picture(self, boxes: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert boxes (n, 4) x, y, w, h from pixels of the recording to those of the picture."""
        across, down, right, lower = self.to_picture
        scaled: NDArray[np.float64] = boxes * [across, down, across, down] + [right, lower, 0, 0]
        return scaled

    def fixations(
        self, frames: NDArray[np.int64], assumed: FixedPoint, size: tuple[int, int]
    ) -> NDArray[np.float64]:
        """Return fixations in these frames, px of the picture, float64, shape (n, 2).

        Parameters
        ----------
        size
            Width and height of the picture.
        """
        if self.gaze is None:
            return np.tile(np.array(assumed.in_picture(*size)), (len(frames), 1))
        points = self.gaze.at(frames)
        if self.is_visible:
            return points
        across, down, right, lower = self.to_picture
        return points * [across, down] + [right, lower]


def open_recordings(session: Session, dataset: Dataset) -> list[DriverRecording]:
    """Open the recordings of a dataset. The caller closes their pictures.

    A recording has no pictures if the session does not name the recording or its pictures.

    Raises
    ------
    InputError
        If a gaze or light file cannot be used, with file and line, or no evaluated frame has a
        picture.
    """
    names = [str(name) for name in dataset.recordings["name"]]
    named = session.entries(names)
    entries = [named.get(name, RecordingEntry(name)) for name in names]
    gazes = [None if of.gaze is None else read_gaze(session.folder / of.gaze) for of in entries]
    lights = [None if of.light is None else read_light(session.folder / of.light) for of in entries]
    visible = {number for number, entry in enumerate(entries) if entry.visible is not None}
    visible_pictures = session_pictures(session, dataset, visible, key="visible")
    own_pictures = session_pictures(session, dataset, {*range(len(names))} - visible)
    recordings = []
    for number, (entry, gaze, light) in enumerate(zip(entries, gazes, lights, strict=True)):
        opened = visible_pictures if number in visible else own_pictures
        recordings.append(DriverRecording(number, entry, dataset, opened, gaze, light))
    if not any((recording.index >= 0).any() for recording in recordings):
        visible_pictures.close()
        own_pictures.close()
        raise InputError(visible_pictures.why_none(own_pictures, how=_HOW_TO_NAME))
    return recordings


def _doubts(
    source: Pictures, dataset: Dataset, number: int, entry: RecordingEntry, has_map: bool
) -> tuple[Note, ...]:
    """Return notes if shape or number of the pictures do not match the frames."""
    columns, name, doubts = dataset.frame_columns, one_line(source.name), list[Note]()
    of_px = float(columns.width[number]), float(columns.height[number])
    if not has_map and is_of_other_shape(source, *of_px):
        size_px = source.width, source.height
        doubts.append(Note("driver.other_shape", name=name, size_px=size_px, of_px=of_px))
    others = dataset.unlisted_frames(str(dataset.recordings["name"].iloc[number]))
    frames = np.union1d(columns.frame[columns.rows_of(number)], others)
    if source.numbers is None and len(frames) and source.n != len(frames):
        # frames may count from 1, be a sample at equal steps, or be selected from more frames
        first = entry.first_picture
        n = int(frames[-1]) + 1 - (first or 0)
        least = n - 1 if first is None and frames[0] >= 1 else n
        step = int(np.diff(frames).max(initial=1))
        if source.n < least or (not len(others) and source.n >= n + step):
            ends = {"first": frames[0], "last": frames[-1]}
            doubts.append(Note("driver.other_length", name=name, n=source.n, **ends))
    return tuple(doubts)


def _has_colour(source: Pictures, index: NDArray[np.int64]) -> bool:
    shown = index[index >= 0]
    for share in _LOOKED_AT if len(shown) else ():
        try:
            if has_colour(source.read(int(shown[int(share * len(shown))]))):
                return True
        except MediaError:  # reported when the recording is processed
            continue
    return False
