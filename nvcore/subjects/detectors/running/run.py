"""Run a detector over the evaluated frames of recordings, and estimate the duration."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.common.errors import InputError
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import MOST_NAMED, count_text, duration_text, one_line
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About
from nvcore.inputs.evaluated_frames import frames_there
from nvcore.pictures import Picture, RecordingPictures
from nvcore.pictures.recordings import NO_PICTURES
from nvcore.pictures.run import PictureRun, speed_text
from nvcore.subjects.detectors.base import Detections, Detector, one_for_a_picture

_HOW_TO_NAME: Final = 'pictures = "drive.mp4"'
RUN_PER_PLACE: Final = 10
"""Minimum ratio of the run's pictures to the timed ones for a further place."""
PLACES: Final = 3
"""Maximum number of places in the recordings at which pictures are timed."""
TIMED_PER_THREAD: Final = 2
"""Minimum number of timed pictures per thread and place."""
ENOUGH_S: Final = 0.5
"""Minimum duration of the timing at a place, seconds."""


@dataclass(frozen=True, eq=False, repr=False)
class RecordingRun:
    """Boxes that a detector found in one recording.

    Attributes
    ----------
    boxes
        Columns frame, x, y, w, h (px of the recording), score, and class if the detector knows
        several. Sorted by frame, then by descending confidence.
    frames
        Frames with a readable picture, int64, shape (n,).
    n_listed
        Number of evaluated frames.
    note
        Reason why frames have no picture, or an empty text.
    """

    name: str
    boxes: pd.DataFrame
    frames: NDArray[np.int64]
    n_listed: int
    note: str = ""

    @property
    def n_without(self) -> int:
        """Number of evaluated frames without a picture."""
        return self.n_listed - len(self.frames)

    def __repr__(self) -> str:
        boxes = count_text(len(self.boxes), "box", "boxes")
        pictures = count_text(len(self.frames), "picture")
        return f"<RecordingRun of {one_line(self.name)}: {boxes} in {pictures}>"


@dataclass(frozen=True, eq=False, repr=False)
class DetectorRun:
    """Boxes that a detector found in recordings, and the duration. ``print`` shows a summary."""

    about: About
    recordings: tuple[RecordingRun, ...]
    seconds: float

    @property
    def n_boxes(self) -> int:
        """Number of boxes in all recordings."""
        return sum(len(recording.boxes) for recording in self.recordings)

    @property
    def n_pictures(self) -> int:
        """Number of pictures that the detector was given."""
        return sum(len(recording.frames) for recording in self.recordings)

    @property
    def n_without(self) -> int:
        """Number of evaluated frames without a picture."""
        return sum(recording.n_without for recording in self.recordings)

    def __repr__(self) -> str:
        return (
            f"<DetectorRun of {one_line(self.about.name)}: {self._boxes}, "
            f"{count_text(self.n_without, 'frame')} without a picture>"
        )

    def __str__(self) -> str:
        lines = [f"{self._boxes}, {speed_text(self.n_pictures, self.seconds)}"]
        if self.n_without:
            lines.append(
                f"{self.n_without:,} of {self.n_without + self.n_pictures:,} evaluated frames were "
                "not seen, and count as missed where they are compared:"
            )
            lines += [
                f"  {one_line(part.name)}: {part.n_without:,} of {part.n_listed:,}. "
                f"{part.note}".rstrip()
                for part in self.recordings
                if part.n_without
            ]
        return "\n".join(lines)

    @property
    def _boxes(self) -> str:
        n_run = sum(len(part.frames) > 0 for part in self.recordings)
        return (
            f"{count_text(self.n_boxes, 'box', 'boxes')} in "
            f"{count_text(self.n_pictures, 'picture')} of {count_text(n_run, 'recording')}"
        )


@dataclass(frozen=True)
class Expectation:
    """Expected duration of a run.

    Attributes
    ----------
    seconds_each
        Time from one picture to the next with all threads busy.
    """

    n_pictures: int
    n_recordings: int
    n_threads: int
    seconds_each: float

    @property
    def seconds(self) -> float:
        """Duration of the whole run."""
        return self.n_pictures * self.seconds_each

    def __str__(self) -> str:
        return (
            f"{count_text(self.n_pictures, 'picture')} of "
            f"{count_text(self.n_recordings, 'recording')} on "
            f"{count_text(self.n_threads, 'thread')}: about {duration_text(self.seconds)} "
            f"({self.seconds_each:.2g} s a picture)"
        )


def check_pictures(pictures: RecordingPictures, dataset: Dataset | None = None) -> int:
    """Count the evaluated frames with a picture.

    Raises
    ------
    InputError
        If there is none, with the reason and the unlisted frames of `dataset`.
    """
    n = sum(int(np.count_nonzero(index >= 0)) for index in pictures.indices.values())
    if not n:
        raise no_pictures(pictures, dataset)
    return n


def no_pictures(pictures: RecordingPictures, dataset: Dataset | None = None) -> InputError:
    """Return the error of `check_pictures`."""
    if not pictures.sources:
        return InputError(pictures.why_none(how=_HOW_TO_NAME))
    notes = list(dict.fromkeys(one_line(pictures.notes[number]) for number in pictures.sources))
    there = ""
    if dataset is not None:
        names = [str(dataset.recordings["name"].iloc[number]) for number in pictures.sources]
        frames = {name: dataset.unlisted_frames(name) for name in names}
        if any(map(len, frames.values())):
            there = f" By the ground truth {frames_there(frames)}."
    return InputError(f"{NO_PICTURES}. {' '.join(notes[:MOST_NAMED])}{there}")


def _picture_run(n_pictures: int, progress: Progress, n_threads: int | None) -> PictureRun:
    """Start a run. Each picture uses one thread, or all cores if it is the only one."""
    run = PictureRun(n_pictures, progress, n_threads=n_threads)
    run.begin = one_for_a_picture if run.n_threads > 1 else None
    return run


def run_detector(
    detector: Detector,
    dataset: Dataset,
    pictures: RecordingPictures,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> DetectorRun:
    """Run a detector on every evaluated frame that has a picture.

    The boxes do not depend on the number of threads. They are in pixels of the dataset's
    recordings, regardless of the size of the pictures.

    Parameters
    ----------
    pictures
        Pictures of the dataset's recordings (`nvcore.pictures.session_pictures`).
    n_threads, progress
        See `nvcore.pictures.run.PictureRun`.

    Raises
    ------
    InputError
        If no evaluated frame has a picture, or the detector cannot work on such pictures.
    CancelledError
        If `progress` raises it.
    """
    run = _picture_run(check_pictures(pictures, dataset), progress, n_threads)
    columns = dataset.frame_columns

    def detect(frame: int, picture: Picture) -> tuple[int, Detections]:
        return frame, detector.detect(picture)

    def run_recording(number: int, name: str) -> RecordingRun:
        listed, source = columns.frame[columns.rows_of(number)], pictures.sources.get(number)
        index = pictures.indices.get(number, np.full(len(listed), -1))
        has_picture = index >= 0
        with_picture = zip(listed[has_picture].tolist(), index[has_picture].tolist(), strict=True)
        faults: list[str] = []
        outputs = list(run.over(source, with_picture, detect, name, faults))
        note, scale = pictures.notes.get(number, "no pictures are named for it"), (1.0, 1.0)
        if source is not None:
            size = float(columns.width[number]), float(columns.height[number])
            scale = size[0] / source.width, size[1] / source.height
            note = "" if has_picture.all() else pictures.notes.get(number, "")
        note = one_line(note)
        if faults:
            n_faults = count_text(len(faults), "picture")
            note = f"{note} {n_faults} cannot be read: {faults[0]}".strip()
        frames = np.array([frame for frame, _ in outputs], np.int64)
        boxes = _table(frames, [detections for _, detections in outputs], *scale)
        return RecordingRun(name, boxes, frames, len(listed), note)

    recordings = tuple(
        run_recording(number, str(name)) for number, name in enumerate(dataset.recordings["name"])
    )
    progress(1.0, "done")
    return DetectorRun(detector.about, recordings, run.seconds)


def _table(
    frames: NDArray[np.int64], boxes: Sequence[Detections], across: float, down: float
) -> pd.DataFrame:
    """Return the columns of `RecordingRun.boxes`, scaled from pixels of the pictures."""
    columns: dict[str, NDArray[Any]] = {"frame": np.repeat(frames, [*map(len, boxes)])}
    for side, factor in {"x": across, "y": down, "w": across, "h": down, "score": 1}.items():
        parts = [getattr(detections, side) for detections in boxes]
        columns[side] = np.concatenate([*parts, np.empty(0)]) * factor
    if any(detections.label is not None for detections in boxes):
        labels = [
            np.full(len(detections), "", dtype=object)
            if detections.label is None
            else detections.label
            for detections in boxes
        ]
        columns["class"] = np.concatenate(labels)
    return pd.DataFrame(columns)


def expect(
    detector: Detector,
    pictures: RecordingPictures,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Expectation:
    """Time consecutive pictures at a few places spread over the run.

    The first picture of each thread at a place does not count, because compiled loops are loaded
    then, and a video is decoded from a key frame.

    Raises
    ------
    InputError
        If no evaluated frame has a picture, or none of the tested ones can be read.
    CancelledError
        If `progress` raises it.
    """
    n_pictures = check_pictures(pictures)
    indices = {number: index[index >= 0] for number, index in sorted(pictures.indices.items())}
    number_of = np.repeat([*indices], [*map(len, indices.values())])
    share, seconds, n_timed, faults = 0.0, 0.0, 0, list[str]()
    run = _picture_run(n_pictures, lambda *_: progress(share, "timing it"), n_threads)
    least = run.n_threads * (1 + TIMED_PER_THREAD)
    n_places = min(max(1, n_pictures // (RUN_PER_PLACE * least)), PLACES)
    for place in range(n_places):
        share = place / n_places
        middle = int((place + 0.5) / n_places * n_pictures)
        number = int(number_of[middle])
        place_in = middle - int(np.searchsorted(number_of, number))
        index = indices[number]
        index = index[max(0, min(place_in, len(index) - least)) :]
        ends = [time.perf_counter()]
        outputs = run.over(
            pictures.sources[number],
            enumerate(index.tolist()),
            lambda _, picture: detector.detect(picture),
            "",
            faults,
        )
        with closing(outputs):
            for _ in outputs:
                ends.append(time.perf_counter())
                if len(ends) > least and ends[-1] - ends[run.n_threads] > ENOUGH_S:
                    break
        began = run.n_threads if len(ends) > run.n_threads + 1 else 0
        n_timed += len(ends) - 1 - began
        seconds += ends[-1] - ends[began]
    if not n_timed:
        raise InputError(f"no picture can be read that was tried: {faults[0]}")
    n_recordings = sum(len(index) > 0 for index in indices.values())
    return Expectation(n_pictures, n_recordings, run.n_threads, seconds / n_timed)
