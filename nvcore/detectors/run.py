"""A detector run over the evaluated frames of recordings, several pictures at a time."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from itertools import islice
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About
from nvcore.detectors.base import Detections, Detector
from nvcore.detectors.threads import one_for_a_picture
from nvcore.errors import InputError, MediaError
from nvcore.pictures import Picture, RecordingPictures
from nvcore.progress import POLL_S, Progress, no_progress
from nvcore.wording import count_text, duration_text, one_line

NO_PICTURES: Final = (
    "no evaluated frame has a picture; name the pictures of each recording in the session file "
    '(pictures = "drive.mp4" under [[recording]])'
)
TIMED_PER_THREAD: Final = 2
"""Pictures that each thread is timed with before a run."""
AHEAD: Final = 2
"""Pictures read ahead for each thread."""


@dataclass(frozen=True)
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


@dataclass(frozen=True)
class DetectorRun:
    """What a detector gave on recordings.

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
        return sum(recording.n_listed for recording in self.recordings) - self.n_pictures


@dataclass(frozen=True)
class Expectation:
    """How long a run will take, timed on a few of its pictures.

    Attributes
    ----------
    n_pictures
        Of the run.
    n_threads
        Pictures at a time.
    seconds_each
        From one picture to the next, all threads busy.
    """

    n_pictures: int
    n_threads: int
    seconds_each: float

    @property
    def seconds(self) -> float:
        """Of the whole run."""
        return self.n_pictures * self.seconds_each


def threads_of(n_threads: int | None) -> int:
    """So many threads, or as many as there are cores."""
    return n_threads or os.cpu_count() or 1


def expect(
    detector: Detector,
    pictures: RecordingPictures,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Expectation:
    """How long `run_detector` will take: a few consecutive pictures, timed.

    The recording is the one with the most pictures, the place its middle; a first picture, on which
    compiled loops are loaded, does not count; a run of a single picture takes no time.

    Parameters
    ----------
    progress
        Called for every picture and now and then between.

    Raises
    ------
    InputError
        If no evaluated frame has a picture, or the detector cannot work on such pictures.
    CancelledError
        If `progress` raises it.
    """
    n_threads = threads_of(n_threads)
    indices = {number: index[index >= 0] for number, index in sorted(pictures.indices.items())}
    n_pictures = sum(map(len, indices.values()))
    if not n_pictures:
        raise InputError(" ".join([NO_PICTURES, *map(one_line, pictures.troubles.values())]))
    number = max(indices, key=lambda key: len(indices[key]))
    n_timed = min(len(indices[number]), 1 + TIMED_PER_THREAD * n_threads)
    start = (len(indices[number]) - n_timed) // 2
    source = pictures.sources[number].another()
    n_done = 0

    def poll() -> None:
        progress(n_done / n_timed, "timing it")

    try:
        timed = _read(source.read, enumerate(indices[number][start : start + n_timed]), [])
        for _ in _in_order(detector, islice(timed, 1), n_threads, poll):
            n_done += 1
        began = time.perf_counter()
        for _ in _in_order(detector, timed, n_threads, poll):
            n_done += 1
            poll()
        seconds = time.perf_counter() - began
    finally:
        source.close()
    if not n_done:
        raise InputError(f"{NO_PICTURES}: those of {source.name} cannot be read")
    return Expectation(n_pictures, n_threads, seconds / max(1, n_done - 1))


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
        raise InputError(" ".join([NO_PICTURES, *map(one_line, pictures.troubles.values())]))
    clock = _Clock(n_pictures, progress)
    recordings = []
    for number, name in enumerate(dataset.recordings["name"]):
        part = _run_recording(
            detector, dataset, pictures, number, threads_of(n_threads), clock.within(str(name))
        )
        recordings.append(replace(part, name=str(name)))
    progress(1.0, "done")
    return DetectorRun(detector.about, tuple(recordings), clock.seconds)


class _Clock:
    """Counts pictures, and says how long the rest will take."""

    def __init__(self, n_pictures: int, progress: Progress):
        self.n_pictures, self.n_done, self._progress = n_pictures, 0, progress
        self._began = time.perf_counter()

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self._began

    def within(self, name: str) -> Callable[[int], None]:
        """Called with the pictures done since the last call, of this recording."""

        def tell(n_more: int) -> None:
            self.n_done += n_more
            words = f"{name}: {self.n_done:,} of {count_text(self.n_pictures, 'picture')}"
            if self.n_done:
                left = self.seconds / self.n_done * (self.n_pictures - self.n_done)
                words += f", {duration_text(left)} left"
            self._progress(self.n_done / self.n_pictures, words)

        return tell


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
        pending = _read(source.read, with_picture, faults)
        for frame, detections in _in_order(detector, pending, n_threads, lambda: tell(0)):
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


def _read(
    read: Callable[[int], Picture], indices: Iterable[tuple[int, int]], faults: list[str]
) -> Iterator[tuple[int, Picture]]:
    """Frame and picture; of those that cannot be read, why, is added to `faults`."""
    for frame, index in indices:
        try:
            picture = read(int(index))
        except MediaError as error:
            faults.append(one_line(str(error)))
        else:
            yield int(frame), picture


def _in_order(
    detector: Detector,
    pictures: Iterator[tuple[int, Picture]],
    n_threads: int,
    poll: Callable[[], None],
) -> Iterator[tuple[int, Detections]]:
    """Frame and boxes of every picture, in their order; `poll` is called while waiting.

    This thread reads, the others detect: pictures of a video are decoded one after another. Of
    several pictures at a time each has one thread: more would only change between the cores.
    """
    waiting: deque[tuple[int, Future[Detections]]] = deque()

    def oldest() -> tuple[int, Detections]:
        frame, future = waiting[0]
        while not wait([future], POLL_S).done:
            poll()
        waiting.popleft()
        return frame, future.result()

    begin = one_for_a_picture if n_threads > 1 else None
    with ThreadPoolExecutor(n_threads, initializer=begin) as pool:
        try:
            for frame, picture in pictures:
                waiting.append((frame, pool.submit(detector.detect, picture)))
                if len(waiting) > AHEAD * n_threads:
                    yield oldest()
            while waiting:
                yield oldest()
        finally:
            for _, future in waiting:
                future.cancel()


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
