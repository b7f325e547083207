"""Compute features of all pedestrians in recordings, in one pass over the pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.driver.features import FEATURE_KEYS, features_of
from nvcore.driver.features.view import luminance_of
from nvcore.driver.illumination import Light, LightSource, picture_level
from nvcore.driver.illumination.clock import AdaptationClock, adaptation_clock
from nvcore.driver.recording import DriverRecording, open_recordings
from nvcore.driver.recording_notes import (
    boxes_outside,
    fixation_notes,
    light_doubt,
    light_note,
    other_frames,
    picture_notes,
)
from nvcore.driver.settings import DriverViewSettings
from nvcore.inputs.session import Session
from nvcore.notes import Note, phrase
from nvcore.pictures import Picture, stretch
from nvcore.pictures.run import PictureRun, speed_text
from nvcore.pictures.stretch import STRETCH
from nvcore.progress import Progress, no_progress
from nvcore.schema import NO_TRACK, integers_of
from nvcore.wording import MOST_NAMED, count_text, listed, one_line

BOX_COLUMNS: Final = ("recording", "frame", "track", "x", "y", "w", "h")
FEATURE_COLUMNS: Final = (
    *BOX_COLUMNS,
    *FEATURE_KEYS,
    *("period_s", "illumination", "illumination_by", "picture"),
)
"""Columns of a features file, one row per truth box that is not ignored."""


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
    recordings = open_recordings(session, dataset)
    try:
        views = [_View(recording, dataset, settings) for recording in recordings]
        n_pictures = sum(len(view.rows) for view in views)
        run = PictureRun(n_pictures, progress, n_threads=n_threads)
        parts = [view.features_in(run) for view in views]
    finally:
        for recording in recordings:
            if recording.pictures is not None:
                recording.pictures.close()
    progress(1.0, "done")
    return FeatureRun(tuple(parts), settings, run.n_done, run.seconds)


class _View:
    """The driver's view in one recording. Frames are counted from the first evaluated one."""

    def __init__(self, recording: DriverRecording, dataset: Dataset, settings: DriverViewSettings):
        self.recording, self.settings, self.objects = recording, settings, dataset.objects
        columns, truth = dataset.frame_columns, dataset.truth
        rows = columns.rows_of(recording.number)
        self.frame = columns.frame[rows]
        self.fps = float(columns.fps[recording.number])
        boxes = slice(*truth.offsets[[rows.start, rows.stop]].tolist())
        counted = np.flatnonzero(~truth.ignore[boxes]) + boxes.start
        self.box = np.stack([truth.x, truth.y, truth.w, truth.h], axis=1)[counted]
        self.track = truth.track[counted]
        self.frame_of_box = truth.frame_index[counted] - rows.start
        self.with_boxes = self.frame[np.unique(self.frame_of_box)]
        self.first = np.searchsorted(self.frame_of_box, np.arange(len(self.frame) + 1))
        needed = recording.index >= 0
        if not recording.needs_light:
            needed = needed & (np.diff(self.first) > 0)
        self.rows = np.flatnonzero(needed)
        self.features = np.full((len(self.box), len(FEATURE_KEYS)), np.nan)
        self.level = np.full(len(self.frame), np.nan)
        self.is_seen = np.zeros(len(self.frame), bool)

    def features_in(self, run: PictureRun) -> RecordingFeatures:
        """Process all pictures, then the light over time, and return the features."""
        recording, settings, faults = self.recording, self.settings, list[str]()
        indices = zip(self.rows.tolist(), recording.index[self.rows].tolist(), strict=True)
        for row in run.over(recording.pictures, indices, self._look, recording.name, faults):
            self.is_seen[row] = True
        light = recording.light or self._light_of_pictures()
        clock, is_known = None, np.zeros(len(self.frame), bool)
        if light is not None:
            clock = adaptation_clock(light, self.frame, self.fps, settings.light)
            is_known = clock.is_known
        is_seen = self.is_seen[self.frame_of_box]
        n_seen, n_unseen = int(is_seen.sum()), int((~is_seen).sum())
        n_outside = int(np.isnan(self.features[is_seen, FEATURE_KEYS.index("width_px")]).sum())
        outside = boxes_outside(recording, n_outside, n_seen)
        why_missing = {}
        if n_seen and n_outside == n_seen:
            why_missing = dict.fromkeys(FEATURE_KEYS, self._say(outside))
        elif recording.gaze and (fault := other_frames(recording.gaze, self.frame)):
            why_missing = {"fixation_distance_px": self._say(fault)}
        fixation, doubt = fixation_notes(recording, settings.fixation, self.frame, self.with_boxes)
        notes = [
            *picture_notes(recording, faults, n_unseen),
            *([Note("driver.sentence", clause=outside)] if outside else []),
            fixation,
            light_note(light, clock, self.frame, self.fps, settings.light),
        ]
        return RecordingFeatures(
            recording.name,
            self._table(clock),
            is_known[self.frame_of_box],
            n_unseen,
            tuple(map(self._say, notes)),
            recording.may_be_of_heat,
            clock,
            recording.name_in_data,
            recording.picture_px,
            why_missing,
            self._say(light_doubt(light, self.frame, self.fps, settings.light)),
            self._say(*recording.doubts, doubt),
        )

    def _look(self, row: int, picture: Picture) -> int:
        """Compute features and brightness of one picture.

        Threads may do so at once, as different pictures never share rows.
        """
        if picture.dtype != np.uint8:
            picture = stretch(picture, *STRETCH)
        recording, boxes = self.recording, slice(*self.first[row : row + 2].tolist())
        if boxes.stop > boxes.start:
            size = picture.shape[1], picture.shape[0]
            point = recording.fixations(self.frame[row : row + 1], self.settings.fixation, size)
            in_picture = recording.boxes_in_picture(self.box[boxes])
            self.features[boxes] = features_of(picture, in_picture, point, self.settings.features)
        if recording.needs_light:
            self.level[row] = picture_level(luminance_of(picture))
        return row

    def _light_of_pictures(self) -> Light | None:
        is_known = ~np.isnan(self.level)
        if not is_known.any():
            return None
        times, level = self.frame[is_known] / self.fps, self.level[is_known]
        return Light(times, level, LightSource.PICTURE)

    def _table(self, clock: AdaptationClock | None) -> pd.DataFrame:
        frame = self.frame[self.frame_of_box]
        period_s = level = np.full(len(frame), np.nan)
        if clock is not None:
            level, period_s = clock.level[self.frame_of_box], clock.period_s[self.frame_of_box]
        values: dict[str, object] = {
            "recording": pd.Categorical([self.recording.name_in_data] * len(frame)),
            "frame": frame,
            "track": integers_of(self.track, self.track != NO_TRACK),
            **dict(zip("xywh", self.box.T, strict=True)),
            **dict(zip(FEATURE_KEYS, self.features.T, strict=True)),
            "period_s": period_s,
            "illumination": level,
            "illumination_by": "" if clock is None else clock.source.value,
            "picture": np.where(self.is_seen[self.frame_of_box], self.recording.kind, ""),
        }
        return pd.DataFrame(values, index=pd.RangeIndex(len(frame)))[[*FEATURE_COLUMNS]]

    def _say(self, *notes: Note | None) -> str:
        return " ".join(phrase(note, self.objects) for note in notes if note is not None)
