"""Compute features of all pedestrians in recordings, in one pass over the pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.common.errors import InputError, MediaError
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import MOST_NAMED, count_text, listed, one_line
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_TRACK, integers_of
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.notes import Note, phrase
from nvcore.pictures import Picture, Pictures, RecordingPictures, session_pictures, stretch
from nvcore.pictures.index import is_of_other_shape
from nvcore.pictures.run import PictureRun, speed_text
from nvcore.pictures.stretch import STRETCH
from nvcore.subjects.driver.features import FEATURE_KEYS, features_of
from nvcore.subjects.driver.features.compute import has_colour, luminance_of
from nvcore.subjects.driver.illumination import (
    Light,
    LightSettings,
    LightSource,
    picture_level,
    read_light,
)
from nvcore.subjects.driver.illumination.clock import AdaptationClock, adaptation_clock
from nvcore.subjects.driver.illumination.meter import LEAST_HELD_S
from nvcore.subjects.driver.inputs.fixation import Gaze, read_gaze
from nvcore.subjects.driver.settings import DriverViewSettings

MANY_DARK: Final = 0.1
"""Minimum share of readings below `least_lux` for a warning about the unit. (Our choice.)"""
LEAST_COVERED: Final = 0.9
"""Minimum share of a recording that readings should cover on the same clock. (Our choice.)"""
MOST_LUX: Final = 200_000.0
"""Largest plausible reading: direct sun has about 130,000 lx. (Our choice.)"""
MOST_OUTSIDE: Final = 0.5
"""Share of gaze points outside the pictures that suggests other pictures. (Our choice.)"""


def picture_notes(recording: DriverRecording, faults: list[str], n_unseen: int) -> list[Note]:
    """Return notes on the pictures that were used, and on their faults.

    Parameters
    ----------
    faults
        Faults of pictures that cannot be read.
    n_unseen
        Pedestrian boxes in frames without a picture.
    """
    notes = []
    if recording.pictures is not None and not recording.is_visible:
        notes.append(Note("driver.own_pictures"))
        notes += [Note("driver.grey_pictures")] if recording.may_be_of_heat else []
    notes += recording.doubts
    if n_unseen:
        why = recording.picture_note or None
        notes.append(Note("driver.boxes_without_picture", n=n_unseen, why=why))
    if faults:
        notes.append(Note("driver.unreadable_pictures", n=len(faults), fault=faults[0]))
    return notes


def other_frames(gaze: Gaze, frames: NDArray[np.int64]) -> Note | None:
    """Return a clause on why no gaze point belongs to any of these frames (n,), or None."""
    if not len(gaze.frame):
        return Note("driver.no_gaze")
    if not len(frames) or not np.isnan(gaze.at(frames)).all():
        return None
    ends = {"gaze_first": gaze.frame[0], "gaze_last": gaze.frame[-1]}
    return Note("driver.gaze_of_other_frames", **ends, first=frames[0], last=frames[-1])


def fixation_notes(recording: DriverRecording) -> tuple[Note, Note | None]:
    """Return a note on the driver's fixation, and a doubt about the gaze file or None."""
    assumed, with_boxes = recording.settings.fixation, recording.with_boxes
    gaze, size_px, n_outside, doubt = recording.gaze, recording.picture_px, 0, None
    if gaze is None:
        return Note("driver.fixation_assumed", x=assumed.x, y=assumed.y), None
    known = with_boxes[~np.isnan(gaze.at(with_boxes)[:, 0])]
    if size_px is not None:
        points = recording.fixations(known, size_px)
        n_outside = int(((points < 0) | (points > size_px)).any(axis=1).sum())
    counts = {"n_outside": n_outside, "n_known": len(known)}
    if n_outside and n_outside >= MOST_OUTSIDE * len(known):
        doubt = Note("driver.gaze_outside", n_outside=n_outside, n=len(known))
    if fault := other_frames(gaze, recording.frame):
        return Note("driver.fixation_unknown", why=fault), doubt
    return Note("driver.fixation", n=len(with_boxes), **counts, size_px=size_px), doubt


def light_note(
    light: Light | None,
    clock: AdaptationClock | None,
    frames: NDArray[np.int64],
    fps: float,
    settings: LightSettings,
) -> Note:
    """Return a note on where the brightness comes from, and how often it became dark.

    Parameters
    ----------
    light, clock
        None: the light is unknown.
    frames
        Numbers of the recording's frames, ascending.
    """
    is_empty = light is not None and not len(light.time_s)
    if light is None or is_empty or clock is None or not len(frames):
        return Note("driver.no_light", is_empty=is_empty)
    begin_s, end_s = float(frames[0]) / fps, float(frames[-1] + 1) / fps
    first_s, is_meter = light.time_s[0], light.source is LightSource.METER
    ends_s = {"first": first_s, "last": light.time_s[-1], "begin": begin_s, "end": end_s}
    times = Note("driver.light_times", **{name: _amount(of) for name, of in ends_s.items()})
    if is_meter and (first_s >= end_s or light.end_s < begin_s):
        return Note("driver.no_light", is_empty=False, times=times)
    is_short = first_s > begin_s + LEAST_HELD_S or light.end_s < frames[-1] / fps
    n_dark = int(np.count_nonzero(light.level < settings.least_lux))
    return Note(
        "driver.light",
        noun="reading" if is_meter else "picture",
        n_changes=int(np.count_nonzero((clock.change_s >= 0) & (clock.change_s < end_s - begin_s))),
        n_before=int(np.count_nonzero(clock.change_s < 0)),
        every_s=_sparse(light, settings),
        low=_amount(light.level.min()),
        high=_amount(light.level.max()),
        n=len(light.level),
        n_dark=n_dark if n_dark >= MANY_DARK * len(light.level) else 0,
        least_lux=settings.least_lux,
        gaps=_gaps(light, begin_s, end_s, settings),
        times=times if is_short else None,
    )


def light_doubt(
    light: Light | None, frames: NDArray[np.int64], fps: float, settings: LightSettings
) -> Note | None:
    """Return a clause that suggests another unit or clock of the light meter, or None.

    Parameters as for `light_note`.
    """
    if light is None or light.source is LightSource.PICTURE:
        return None
    if not len(light.time_s):
        return Note("driver.light_doubt")
    if not len(frames):
        return None
    highest = float(light.level.max())
    if highest > MOST_LUX:
        return Note("driver.light_doubt", lux=_amount(highest))
    n, n_dark = len(light.level), int(np.count_nonzero(light.level < settings.least_lux))
    if n_dark >= MANY_DARK * n:
        return Note("driver.light_doubt", n_dark=n_dark, n=n, least_lux=settings.least_lux)
    if every_s := _sparse(light, settings):
        return Note("driver.light_doubt", every_s=every_s)
    times_s = frames / fps
    share = float(((times_s >= light.time_s[0]) & (times_s <= light.end_s)).mean())
    return Note("driver.light_doubt", share=share) if share < LEAST_COVERED else None


def _sparse(light: Light, settings: LightSettings) -> str | None:
    """Return the seconds between readings if they could miss a change of light, else None."""
    return _amount(light.step_s) if light.step_s > settings.bright_for_s / 2 else None


def _gaps(light: Light, begin_s: float, end_s: float, settings: LightSettings) -> Note | None:
    """Return a note on gaps in the readings that leave the light unknown, or None.

    Parameters
    ----------
    begin_s, end_s
        Times of the recording, on the clock of the light meter.
    """
    gaps_s = light.gaps_s
    unknown_until_s = gaps_s[:, 1] + settings.bright_for_s
    gaps_s = gaps_s[(gaps_s[:, 0] + light.held_s < end_s) & (unknown_until_s > begin_s)]
    if not len(gaps_s):
        return None
    before_s, after_s = gaps_s[np.diff(gaps_s, axis=1).argmax()]
    of_s = {
        "before": before_s,
        "after": after_s,
        "unknown_from": before_s + light.held_s,
        "unknown_to": after_s + settings.bright_for_s,
        "held": light.held_s,
        "bright_for": settings.bright_for_s,
    }
    noun = "picture" if light.source is LightSource.PICTURE else "reading"
    amounts = {name: _amount(value) for name, value in of_s.items()}
    return Note("driver.light_gaps", n=len(gaps_s), noun=noun, **amounts)


def _amount(value: float) -> str:
    """Format a number with three significant digits, or as a whole number from 100 on."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


BOX_COLUMNS: Final = ("recording", "frame", "track", "x", "y", "w", "h")
FEATURE_COLUMNS: Final = (
    *BOX_COLUMNS,
    *FEATURE_KEYS,
    *("period_s", "illumination", "illumination_by", "picture"),
)
"""Columns of a features file, one row per truth box that is not ignored."""
_LOOKED_AT: Final = (0.5, 0.1, 0.9)
"""Relative positions of the pictures that are checked for colour."""


@dataclass(frozen=True, eq=False, repr=False)
class RecordingFeatures:
    """Features of the pedestrians of one recording.

    Attributes
    ----------
    table
        `FEATURE_COLUMNS`. Features are NaN if the frame has no picture.
    is_light_known
        True if a change of light would be known in the row's frame, bool, shape (n,).
    n_unseen
        Number of pedestrian boxes in frames without a picture.
    notes
        Assumptions and sources as sentences.
    may_be_of_heat
        True if its pictures are grey and not declared as visible light.
    clock
        Light and adaptation in each of its frames. None: the light is unknown.
    picture_px
        Width and height of its pictures, or None without pictures.
    why_missing
        Known reasons why no box has a feature, by the feature's key, as clauses.
    light_doubt
        Signs of another unit or clock of the light meter, as a clause, or empty.
    picture_doubt
        Signs that pictures or gaze belong to another recording, in sentences, or empty.
    """

    name: str
    table: pd.DataFrame
    is_light_known: NDArray[np.bool_]
    n_unseen: int
    notes: tuple[str, ...]
    may_be_of_heat: bool = False
    clock: AdaptationClock | None = None
    name_in_data: str = ""
    picture_px: tuple[int, int] | None = None
    why_missing: Mapping[str, str] = field(default_factory=dict)
    light_doubt: str = ""
    picture_doubt: str = ""


class DriverRecording:
    """Recording with the data on the driver's view. Its frames are the evaluated ones.

    Parameters
    ----------
    number
        Row of the dataset's recordings.
    entry
        Entry of the session on the recording.
    opened
        Pictures of visible light if the session names them, else the recording's own.
    gaze, light
        Gaze points and light readings. None: a fixation is assumed, or there is no light meter.

    Attributes
    ----------
    index
        Picture of each frame, -1 none, int64.
    picture_note
        Reason why frames have no picture, or an empty text.
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
    rows
        Frames whose picture is needed.
    """

    def __init__(
        self,
        number: int,
        entry: RecordingEntry,
        dataset: Dataset,
        opened: RecordingPictures,
        gaze: Gaze | None,
        light: Light | None,
        settings: DriverViewSettings,
    ):
        self.gaze, self.light, self.settings, self.objects = gaze, light, settings, dataset.objects
        self.name, self.name_in_data = str(dataset.recordings["name"].iloc[number]), entry.name
        self.is_visible = entry.visible is not None
        self.has_map = self.is_visible and entry.visible_map is not None
        self.pictures = source = opened.sources.get(number)
        self.picture_px = None if source is None else (source.width, source.height)
        columns, truth = dataset.frame_columns, dataset.truth
        rows = columns.rows_of(number)
        self.frame, self.fps = columns.frame[rows], float(columns.fps[number])
        self.index = opened.indices.get(number, np.full(len(self.frame), -1))
        note = opened.notes.get(number, "No pictures are named for it.")
        self.picture_note = "" if (self.index >= 0).all() else one_line(note)
        self.to_picture = opened.maps.get(number, (1.0, 1.0, 0.0, 0.0))
        self.may_be_of_heat = self.needs_light = False
        self.doubts: tuple[Note, ...] = ()
        if source is not None:
            self.may_be_of_heat = not (self.is_visible or _has_colour(source, self.index))
            self.needs_light = light is None and not self.may_be_of_heat
            self.doubts = _doubts(source, dataset, number, entry, self.has_map)
        boxes = slice(*truth.offsets[[rows.start, rows.stop]].tolist())
        counted = np.flatnonzero(~truth.ignore[boxes]) + boxes.start
        self.box = np.stack(truth.xywh, axis=1)[counted]
        self.track = truth.track[counted]
        self.frame_of_box = truth.frame_index[counted] - rows.start
        self.with_boxes = self.frame[np.unique(self.frame_of_box)]
        self.first = np.searchsorted(self.frame_of_box, np.arange(len(self.frame) + 1))
        is_needed = (np.diff(self.first) > 0) | self.needs_light
        self.rows = np.flatnonzero((self.index >= 0) & is_needed)
        self.features = np.full((len(self.box), len(FEATURE_KEYS)), np.nan)
        self.level = np.full(len(self.frame), np.nan)

    def fixations(self, frames: NDArray[np.int64], size: tuple[int, int]) -> NDArray[np.float64]:
        """Return fixations in these frames, px of the picture, float64, shape (n, 2).

        Parameters
        ----------
        size
            Width and height of the picture.
        """
        if self.gaze is None:
            return np.tile(np.array(self.settings.fixation.in_picture(*size)), (len(frames), 1))
        points = self.gaze.at(frames)
        if self.is_visible:
            return points
        across, down, right, lower = self.to_picture
        return points * [across, down] + [right, lower]

    def features_in(self, run: PictureRun) -> RecordingFeatures:
        """Process all pictures, then the light over time, and return the features."""
        settings, faults = self.settings, list[str]()
        indices = zip(self.rows.tolist(), self.index[self.rows].tolist(), strict=True)
        is_seen = np.zeros(len(self.frame), bool)
        for row in run.over(self.pictures, indices, self._look, self.name, faults):
            is_seen[row] = True
        light, is_bright = self.light, ~np.isnan(self.level)
        if light is None and is_bright.any():
            times_s = self.frame[is_bright] / self.fps
            light = Light(times_s, self.level[is_bright], LightSource.PICTURE)
        clock, is_known = None, np.zeros(len(self.frame), bool)
        if light is not None:
            clock = adaptation_clock(light, self.frame, self.fps, settings.light)
            is_known = clock.is_known
        is_seen = is_seen[self.frame_of_box]
        n_seen, n_unseen = int(is_seen.sum()), int((~is_seen).sum())
        n_outside = int(np.isnan(self.features[is_seen, FEATURE_KEYS.index("width_px")]).sum())
        outside = None
        if n_outside:
            counts = {"n_outside": n_outside, "n": n_seen}
            outside = Note("driver.boxes_outside", has_map=self.has_map, **counts)
        why_missing = {}
        if n_seen and n_outside == n_seen:
            why_missing = dict.fromkeys(FEATURE_KEYS, self._say(outside))
        elif self.gaze and (fault := other_frames(self.gaze, self.frame)):
            why_missing = {"fixation_distance_px": self._say(fault)}
        fixation, doubt = fixation_notes(self)
        notes = [
            *picture_notes(self, faults, n_unseen),
            *([Note("driver.sentence", clause=outside)] if outside else []),
            fixation,
            light_note(light, clock, self.frame, self.fps, settings.light),
        ]
        return RecordingFeatures(
            self.name,
            self._table(clock, is_seen),
            is_known[self.frame_of_box],
            n_unseen,
            tuple(map(self._say, notes)),
            self.may_be_of_heat,
            clock,
            self.name_in_data,
            self.picture_px,
            why_missing,
            self._say(light_doubt(light, self.frame, self.fps, settings.light)),
            self._say(*self.doubts, doubt),
        )

    def _look(self, row: int, picture: Picture) -> int:
        """Compute features and brightness of one picture.

        Threads may do so at once, as different pictures never share rows.
        """
        if picture.dtype != np.uint8:
            picture = stretch(picture, *STRETCH)
        boxes = slice(*self.first[row : row + 2].tolist())
        if boxes.stop > boxes.start:
            point = self.fixations(self.frame[row : row + 1], (picture.shape[1], picture.shape[0]))
            across, down, right, lower = self.to_picture
            in_picture = self.box[boxes] * [across, down, across, down] + [right, lower, 0, 0]
            self.features[boxes] = features_of(picture, in_picture, point, self.settings.features)
        if self.needs_light:
            self.level[row] = picture_level(luminance_of(picture))
        return row

    def _table(self, clock: AdaptationClock | None, is_seen: NDArray[np.bool_]) -> pd.DataFrame:
        frame = self.frame[self.frame_of_box]
        period_s = level = np.full(len(frame), np.nan)
        if clock is not None:
            level, period_s = clock.level[self.frame_of_box], clock.period_s[self.frame_of_box]
        values: dict[str, object] = {
            "recording": pd.Categorical([self.name_in_data] * len(frame)),
            "frame": frame,
            "track": integers_of(self.track, self.track != NO_TRACK),
            **dict(zip("xywh", self.box.T, strict=True)),
            **dict(zip(FEATURE_KEYS, self.features.T, strict=True)),
            "period_s": period_s,
            "illumination": level,
            "illumination_by": "" if clock is None else clock.source.value,
            "picture": np.where(is_seen, "visible" if self.is_visible else "own", ""),
        }
        return pd.DataFrame(values, index=pd.RangeIndex(len(frame)))[[*FEATURE_COLUMNS]]

    def _say(self, *notes: Note | None) -> str:
        return " ".join(phrase(note, self.objects) for note in notes if note is not None)


def open_recordings(
    session: Session, dataset: Dataset, settings: DriverViewSettings
) -> list[DriverRecording]:
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
    recordings = [
        DriverRecording(number, entry, dataset, opened, gaze, light, settings)
        for number, (entry, gaze, light) in enumerate(zip(entries, gazes, lights, strict=True))
        for opened in [visible_pictures if number in visible else own_pictures]
    ]
    if not any((recording.index >= 0).any() for recording in recordings):
        visible_pictures.close()
        own_pictures.close()
        how = 'visible = "drive.mp4", or pictures = "drive.mp4",'
        raise InputError(visible_pictures.why_none(own_pictures, how=how))
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


@dataclass(frozen=True, eq=False, repr=False)
class FeatureRun:
    """Features of the pedestrians in recordings. ``print`` shows the assumptions."""

    recordings: tuple[RecordingFeatures, ...]
    settings: DriverViewSettings
    n_pictures: int
    seconds: float

    @property
    def table(self) -> pd.DataFrame:
        """Rows of all recordings, with the columns `FEATURE_COLUMNS`."""
        tables = [recording.table for recording in self.recordings]
        return pd.concat(tables, ignore_index=True)

    def __repr__(self) -> str:
        return f"<FeatureRun of {self._boxes}>"

    def __str__(self) -> str:
        head = f"{self._boxes}, {speed_text(self.n_pictures, self.seconds)}"
        of_notes: dict[tuple[str, ...], list[str]] = {}
        for recording in self.recordings:
            of_notes.setdefault(recording.notes, []).append(one_line(recording.name))
        parts = [
            f"{listed(names, most=MOST_NAMED)}: {' '.join(notes)}"
            for notes, names in of_notes.items()
        ]
        return "\n".join([head, *parts])

    @property
    def _boxes(self) -> str:
        n_boxes = sum(len(recording.table) for recording in self.recordings)
        return f"{count_text(n_boxes, 'box', 'boxes')} in {count_text(self.n_pictures, 'picture')}"


def run_features(
    dataset: Dataset,
    settings: DriverViewSettings | None = None,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> FeatureRun:
    """Compute features of every pedestrian that is not ignored, in every frame with a picture.

    The table does not depend on the number of threads.

    Parameters
    ----------
    dataset
        Dataset with a `Session` as its settings, which names pictures, gaze and light.
    n_threads, progress
        See `nvcore.pictures.run.PictureRun`.

    Raises
    ------
    InputError
        If a gaze or light file cannot be used, or no evaluated frame has a picture.
    CancelledError
        If `progress` raises it.
    """
    session = dataset.settings
    assert isinstance(session, Session)
    settings = settings or DriverViewSettings()
    recordings = open_recordings(session, dataset, settings)
    try:
        n_pictures = sum(len(recording.rows) for recording in recordings)
        run = PictureRun(n_pictures, progress, n_threads=n_threads)
        parts = [recording.features_in(run) for recording in recordings]
    finally:
        for recording in recordings:
            if recording.pictures is not None:
                recording.pictures.close()
    progress(1.0, "done")
    return FeatureRun(tuple(parts), settings, run.n_done, run.seconds)
