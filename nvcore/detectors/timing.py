"""How long a run of a detector will take, timed on a few of its pictures."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.base import Detector
from nvcore.detectors.run import detections_in, no_pictures, threads_of
from nvcore.errors import InputError
from nvcore.pictures import Pictures, RecordingPictures
from nvcore.pictures.passes import pictures_of
from nvcore.progress import Progress, no_progress
from nvcore.wording import count_text, duration_text

RUN_PER_PLACE: Final = 10
"""Pictures of the run to each one that is tried: a short run is timed at a single place."""
PLACES: Final = 3
"""Places of the recordings at which pictures are timed."""
TIMED_PER_THREAD: Final = 2
"""Pictures that each thread is timed with at each place, ..."""
ENOUGH_S: Final = 0.5
"""... and more until this time has passed, seconds."""


@dataclass(frozen=True)
class Expectation:
    """How long a run will take.

    Attributes
    ----------
    n_pictures, n_recordings
        Of the run.
    n_threads
        Pictures at a time.
    seconds_each
        From one picture to the next, all threads busy.
    """

    n_pictures: int
    n_recordings: int
    n_threads: int
    seconds_each: float

    @property
    def seconds(self) -> float:
        """Of the whole run."""
        return self.n_pictures * self.seconds_each

    def __str__(self) -> str:
        return (
            f"{count_text(self.n_pictures, 'picture')} of "
            f"{count_text(self.n_recordings, 'recording')} on "
            f"{count_text(self.n_threads, 'thread')}: about {duration_text(self.seconds)} "
            f"({self.seconds_each:.2g} s a picture)"
        )


def expect(
    detector: Detector,
    pictures: RecordingPictures,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Expectation:
    """How long `run_detector` will take: consecutive pictures at a few places, timed.

    The places are spread over all pictures of the run. At each of them a first picture for each
    thread does not count: there compiled loops are loaded, and a video is decoded from a key frame
    on.

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
    starts = np.cumsum([0, *map(len, indices.values())])
    n_pictures = int(starts[-1])
    if not n_pictures:
        raise no_pictures(pictures)
    least = n_threads * (1 + TIMED_PER_THREAD)
    n_places = min(max(1, n_pictures // (RUN_PER_PLACE * least)), PLACES)
    n_timed, seconds, faults = 0, 0.0, list[str]()
    for place in range(n_places):
        poll = partial(progress, place / n_places, "timing it")
        middle = int((place + 0.5) / n_places * n_pictures)
        row = int(np.searchsorted(starts, middle, side="right")) - 1
        first = max(0, min(middle, int(starts[row + 1]) - least) - int(starts[row]))
        number = [*indices][row]
        n_here, seconds_here = _time(
            detector, pictures.sources[number], indices[number][first:], n_threads, faults, poll
        )
        n_timed += n_here
        seconds += seconds_here
    if not n_timed:
        raise InputError(f"no picture can be read that was tried: {faults[0]}")
    n_recordings = sum(len(index) > 0 for index in indices.values())
    return Expectation(n_pictures, n_recordings, n_threads, seconds / n_timed)


def _time(
    detector: Detector,
    source: Pictures,
    indices: NDArray[np.int64],
    n_threads: int,
    faults: list[str],
    poll: Callable[[], None],
) -> tuple[int, float]:
    """How many pictures were timed, and how long they took together, seconds."""
    source = source.another()
    start = began = time.perf_counter()
    n_done, now = 0, start
    try:
        read = pictures_of(source, enumerate(indices.tolist()), faults)
        with closing(detections_in(detector, read, n_threads, poll)) as outputs:
            for n_done, _ in enumerate(outputs, 1):
                now = time.perf_counter()
                if n_done == n_threads:
                    began = now
                is_enough = n_done >= n_threads * (1 + TIMED_PER_THREAD)
                if is_enough and now - began > ENOUGH_S:
                    break
                poll()
    finally:
        source.close()
    if n_done > n_threads:
        return n_done - n_threads, now - began
    return n_done, now - start
