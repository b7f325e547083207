"""Pictures, gaze and light of one recording, as the driver saw it."""

from __future__ import annotations

from dataclasses import dataclass
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
from nvcore.pictures import Pictures, session_pictures
from nvcore.pictures.index import is_of_other_shape
from nvcore.wording import one_line

_HOW_TO_NAME: Final = 'visible = "drive.mp4", or pictures = "drive.mp4",'
_LOOKED_AT: Final = (0.5, 0.1, 0.9)
"""Relative positions of the pictures that are checked for colour."""


@dataclass(frozen=True, eq=False)
class DriverRecording:
    """Recording with the data on the driver's view.

    Attributes
    ----------
    number
        Row of the dataset's recordings.
    pictures
        Pictures of visible light if there are any, else the recording's own.
    index
        Picture of each evaluated frame, -1 none, int64.
    picture_note
        Assignment of pictures to frames, or the reason for having none.
    is_visible
        True if the session declares the pictures as visible light.
    to_picture
        (sx, sy, dx, dy): x of the picture is sx x + dx of the recording.
    gaze
        Gaze of the driver. None: a point is assumed.
    light
        Readings of a light meter. None: the pictures may replace them.
    has_map
        True if `to_picture` is a ``visible_map`` of the session, False if it is from the sizes.
    doubts
        Signs that the pictures belong to another recording, in sentences.
    """

    number: int
    name: str
    name_in_data: str
    pictures: Pictures | None
    index: NDArray[np.int64]
    picture_note: str
    is_visible: bool
    has_colour: bool
    to_picture: tuple[float, float, float, float]
    gaze: Gaze | None
    light: Light | None
    has_map: bool
    doubts: tuple[Note, ...]

    @property
    def kind(self) -> str:
        """Kind of the pictures: ``visible`` if the session declares them so, else ``own``."""
        return "visible" if self.is_visible else "own"

    @property
    def picture_px(self) -> tuple[int, int] | None:
        """Width and height of the first picture, or None without pictures."""
        return None if self.pictures is None else (self.pictures.width, self.pictures.height)

    @property
    def may_be_of_heat(self) -> bool:
        """True if the pictures are grey and not declared as visible light."""
        return self.pictures is not None and not (self.is_visible or self.has_colour)

    @property
    def needs_light(self) -> bool:
        """True if the pictures have to replace a light meter."""
        return self.light is None and self.pictures is not None and not self.may_be_of_heat

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

    Parameters
    ----------
    session
        Session with pictures, light and gaze of each recording.
    dataset
        Dataset loaded from the session.

    Returns
    -------
    One entry per recording of the dataset, in its order. It has no pictures if the session does not
    name the recording or its pictures.

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
    columns, recordings = dataset.frame_columns, []
    for number, (name, entry) in enumerate(zip(names, entries, strict=True)):
        is_visible = number in visible
        opened = visible_pictures if is_visible else own_pictures
        source = opened.sources.get(number)
        rows = columns.rows_of(number)
        index = np.full(rows.stop - rows.start, -1) if source is None else opened.indices[number]
        note = opened.notes.get(number, "No pictures are named for it.")
        has_map = is_visible and entry.visible_map is not None
        recordings.append(
            DriverRecording(
                number=number,
                name=name,
                name_in_data=entry.name,
                pictures=source,
                index=index,
                picture_note="" if (index >= 0).all() else one_line(note),
                is_visible=is_visible,
                has_colour=source is not None and _has_colour(source, index),
                to_picture=opened.maps.get(number, (1.0, 1.0, 0.0, 0.0)),
                gaze=gazes[number],
                light=lights[number],
                has_map=has_map,
                doubts=() if source is None else _doubts(source, dataset, number, entry, has_map),
            )
        )
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
    listed = columns.frame[columns.rows_of(number)]
    others = dataset.unlisted_frames(str(dataset.recordings["name"].iloc[number]))
    frames = np.union1d(listed, others)
    if source.numbers is None and not _is_as_long(
        source.n, frames, entry.first_picture, are_selected=len(others) > 0
    ):
        ends = {"first": frames[0], "last": frames[-1]}
        doubts.append(Note("driver.other_length", name=name, n=source.n, **ends))
    return tuple(doubts)


def _is_as_long(
    n_pictures: int, frames: NDArray[np.int64], first_picture: int | None, *, are_selected: bool
) -> bool:
    """Return whether the number of pictures matches the frames.

    It may equal the number of frames, or of frame numbers from `first_picture` on. Frames may count
    from 1, and be a sample at equal steps. If some were selected, only a minimum is known.
    """
    if not len(frames) or n_pictures == len(frames):
        return True
    n = int(frames[-1]) + 1 - (first_picture or 0)
    least = n - 1 if first_picture is None and frames[0] >= 1 else n
    step = int(np.diff(frames).max(initial=1))
    return n_pictures >= least and (are_selected or n_pictures < n + step)


def _has_colour(source: Pictures, index: NDArray[np.int64]) -> bool:
    shown = index[index >= 0]
    for share in _LOOKED_AT if len(shown) else ():
        try:
            if has_colour(source.read(int(shown[int(share * len(shown))]))):
                return True
        except MediaError:  # reported when the recording is processed
            continue
    return False
