"""A detector run over the evaluated frames of recordings, several pictures at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About
from nvcore.detectors.base import Detections, Detector, one_for_a_picture
from nvcore.errors import InputError
from nvcore.inputs.evaluated_frames import frames_there
from nvcore.pictures import Picture, RecordingPictures
from nvcore.pictures.passes import PictureClock, in_order, pictures_of
from nvcore.pictures.recordings import NO_PICTURES
from nvcore.progress import Progress, no_progress
from nvcore.wording import MOST_NAMED, count_text, duration_text, one_line

_HOW_TO_NAME: Final = 'pictures = "drive.mp4"'


@dataclass(frozen=True, eq=False, repr=False)
class RecordingRun:
    """What came out for one recording.

    Attributes
    ----------
    name
        Of the recording, as the dataset calls it.
    boxes
        Columns frame, x, y, w, h (px of the recording), score, and class where the detector knows
        several; by frame, the most confident first.
    frames
        Frames that the detector was given, int64, shape (n,).
    n_listed
        Evaluated frames, with those that have no picture.
    note
        Why some have none; empty: all have.
    """

    name: str
    boxes: pd.DataFrame
    frames: NDArray[np.int64]
    n_listed: int
    note: str = ""

    @property
    def n_without(self) -> int:
        """Evaluated frames without a picture."""
        return self.n_listed - len(self.frames)

    def __repr__(self) -> str:
        boxes = count_text(len(self.boxes), "box", "boxes")
        pictures = count_text(len(self.frames), "picture")
        return f"<RecordingRun of {one_line(self.name)}: {boxes} in {pictures}>"


@dataclass(frozen=True, eq=False, repr=False)
class DetectorRun:
    """What a detector gave on recordings; ``print`` says what came out.

    Attributes
    ----------
    about
        The detector.
    recordings
        In the order of the dataset.
    seconds
        How long it took.
    """

    about: About
    recordings: tuple[RecordingRun, ...]
    seconds: float

    @property
    def n_boxes(self) -> int:
        """Boxes in all recordings."""
        return sum(len(recording.boxes) for recording in self.recordings)

    @property
    def n_pictures(self) -> int:
        """Frames that the detector was given."""
        return sum(len(recording.frames) for recording in self.recordings)

    @property
    def n_without(self) -> int:
        """Evaluated frames without a picture."""
        return sum(recording.n_without for recording in self.recordings)

    def __repr__(self) -> str:
        return (
            f"<DetectorRun of {one_line(self.about.name)}: {self._boxes}, "
            f"{count_text(self.n_without, 'frame')} without a picture>"
        )

    def __str__(self) -> str:
        rate = self.n_pictures / self.seconds if self.seconds > 0 else 0.0
        lines = [f"{self._boxes}, in {duration_text(self.seconds)} ({rate:.1f} pictures a second)"]
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


def threads_of(n_threads: int | None) -> int:
    """So many threads, or as many as there are cores."""
    return n_threads or os.cpu_count() or 1


def no_pictures(pictures: RecordingPictures, dataset: Dataset | None = None) -> InputError:
    """That no evaluated frame has a picture, and why.

    Parameters
    ----------
    dataset
        For the frames that there are beside those that are evaluated; None: they are not said.
    """
    if not pictures.sources:
        return InputError(pictures.why_none(how=_HOW_TO_NAME))
    notes = list(dict.fromkeys(one_line(pictures.notes[number]) for number in pictures.sources))
    there = ""
    if dataset is not None:
        names = dataset.recordings["name"]
        frames = {
            str(names.iloc[i]): dataset.unlisted_frames(names.iloc[i]) for i in pictures.sources
        }
        if any(map(len, frames.values())):
            there = f" By the ground truth {frames_there(frames)}."
    return InputError(f"{NO_PICTURES}. {' '.join(notes[:MOST_NAMED])}{there}")


def run_detector(
    detector: Detector,
    dataset: Dataset,
    pictures: RecordingPictures,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> DetectorRun:
    """The detector's boxes in every evaluated frame that has a picture.

    The same pictures give the same result, however many threads there are.

    Parameters
    ----------
    dataset
        Its frames are the evaluated ones; boxes are in pixels of its recordings, whatever size the
        pictures are.
    pictures
        Of its recordings (`nvcore.pictures.session_pictures`).
    n_threads
        Pictures at a time; None: as many as there are cores.
    progress
        Called for every picture and now and then between, with the time left in words.

    Raises
    ------
    InputError
        If no evaluated frame has a picture, or the detector cannot work on such pictures.
    CancelledError
        If `progress` raises it; nothing is left behind.
    """
    indices = pictures.indices
    n_pictures = sum(int(np.count_nonzero(index >= 0)) for index in indices.values())
    if not n_pictures:
        raise no_pictures(pictures, dataset)
    clock = PictureClock(n_pictures, progress)
    recordings = []
    for number, name in enumerate(dataset.recordings["name"]):
        tell = partial(clock.count, name=str(name))
        part = _run_recording(detector, dataset, pictures, number, threads_of(n_threads), tell)
        recordings.append(replace(part, name=str(name)))
    progress(1.0, "done")
    return DetectorRun(detector.about, tuple(recordings), clock.seconds)


def _run_recording(
    detector: Detector,
    dataset: Dataset,
    pictures: RecordingPictures,
    number: int,
    n_threads: int,
    tell: Callable[[int], None],
) -> RecordingRun:
    columns = dataset.frame_columns
    listed = columns.frame[columns.rows_of(number)]
    empty = np.empty(0, np.int64)
    source = pictures.sources.get(number)
    if source is None:
        note = one_line(pictures.notes.get(number, "no pictures are named for it"))
        return RecordingRun("", _table([], []), empty, len(listed), note)
    source = source.another()
    index = pictures.indices[number]
    with_picture = zip(listed[index >= 0].tolist(), index[index >= 0].tolist(), strict=True)
    faults: list[str] = []
    frames: list[int] = []
    boxes: list[Detections] = []
    try:
        pending = pictures_of(source, with_picture, faults)
        for frame, detections in detections_in(detector, pending, n_threads, lambda: tell(0)):
            frames.append(frame)
            boxes.append(detections)
            tell(1)
    finally:
        source.close()
    tell(len(faults))
    table = _table(frames, boxes)
    across = float(columns.width[number]) / source.width
    down = float(columns.height[number]) / source.height
    if (across, down) != (1, 1):
        table = table.assign(
            **{side: table[side] * across for side in "xw"},
            **{side: table[side] * down for side in "yh"},
        )
    n_missing = int(np.count_nonzero(index < 0))
    note = one_line(pictures.notes.get(number, "")) if n_missing else ""
    if faults:
        note = f"{note} {count_text(len(faults), 'picture')} cannot be read: {faults[0]}".strip()
    return RecordingRun("", table, np.array(frames, np.int64), len(listed), note)


def detections_in(
    detector: Detector,
    pictures: Iterable[tuple[int, Picture]],
    n_threads: int,
    poll: Callable[[], None],
) -> Generator[tuple[int, Detections]]:
    """Frame and boxes of every picture, in their order; `poll` is called while waiting.

    Of several pictures at a time each has one thread: more would only change between the cores.
    """

    def detect(frame: int, picture: Picture) -> tuple[int, Detections]:
        return frame, detector.detect(picture)

    begin = one_for_a_picture if n_threads > 1 else None
    return in_order(detect, pictures, poll, n_threads=n_threads, begin=begin)


def _table(frames: list[int], boxes: list[Detections]) -> pd.DataFrame:
    """The boxes of all frames: columns of `RecordingRun.boxes`."""
    lengths = [len(detections) for detections in boxes]
    columns: dict[str, NDArray[np.generic]] = {
        "frame": np.repeat(np.array(frames, np.int64), np.array(lengths, np.int64))
    }
    for name in ("x", "y", "w", "h", "score"):
        parts = [getattr(detections, name) for detections in boxes]
        columns[name] = np.concatenate([*parts, np.empty(0)])
    if any(detections.label is not None for detections in boxes):
        labels = [
            np.full(n, "", dtype=object) if detections.label is None else detections.label
            for n, detections in zip(lengths, boxes, strict=True)
        ]
        columns["class"] = np.concatenate(labels)
    return pd.DataFrame(columns)
