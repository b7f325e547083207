"""Estimate the duration of a detector run from a few of its pictures."""

from __future__ import annotations

import time
from contextlib import closing
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.base import Detector
from nvcore.detectors.run import check_pictures, picture_run
from nvcore.errors import InputError
from nvcore.pictures import Pictures, RecordingPictures
from nvcore.pictures.run import PictureRun
from nvcore.progress import Progress, no_progress
from nvcore.wording import count_text, duration_text

RUN_PER_PLACE: Final = 10
"""Minimum ratio of the run's pictures to the timed ones for a further place."""
PLACES: Final = 3
"""Maximum number of places in the recordings at which pictures are timed."""
TIMED_PER_THREAD: Final = 2
"""Minimum number of timed pictures per thread and place."""
ENOUGH_S: Final = 0.5
"""Minimum duration of the timing at a place, seconds."""


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


def expect(
    detector: Detector,
    pictures: RecordingPictures,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Expectation:
    """Time consecutive pictures at a few places that are spread over the run.

    The first picture of each thread at a place does not count: compiled loops are loaded, and a
    video is decoded from a key frame on.

    Parameters
    ----------
    n_threads, progress
        See `nvcore.detectors.run.run_detector`.

    Raises
    ------
    InputError
        If no evaluated frame has a picture, or none of those that were tried can be read.
    CancelledError
        If `progress` raises it.
    """
    n_pictures = check_pictures(pictures)
    indices = {number: index[index >= 0] for number, index in sorted(pictures.indices.items())}
    starts = np.cumsum([0, *map(len, indices.values())])
    share = 0.0
    run = picture_run(n_pictures, lambda *_: progress(share, "timing it"), n_threads)
    least = run.n_threads * (1 + TIMED_PER_THREAD)
    n_places = min(max(1, n_pictures // (RUN_PER_PLACE * least)), PLACES)
    n_timed, seconds, faults = 0, 0.0, list[str]()
    for place in range(n_places):
        share = place / n_places
        middle = int((place + 0.5) / n_places * n_pictures)
        row = int(np.searchsorted(starts, middle, side="right")) - 1
        first = max(0, min(middle, int(starts[row + 1]) - least) - int(starts[row]))
        number = [*indices][row]
        n_here, seconds_here = _time(
            detector, pictures.sources[number], indices[number][first:], run, faults
        )
        n_timed += n_here
        seconds += seconds_here
    if not n_timed:
        raise InputError(f"no picture can be read that was tried: {faults[0]}")
    n_recordings = sum(len(index) > 0 for index in indices.values())
    return Expectation(n_pictures, n_recordings, run.n_threads, seconds / n_timed)


def _time(
    detector: Detector,
    source: Pictures,
    indices: NDArray[np.int64],
    run: PictureRun,
    faults: list[str],
) -> tuple[int, float]:
    """Return the number of timed pictures, and their total time in seconds."""
    n_threads = run.n_threads
    ends = [time.perf_counter()]
    outputs = run.over(
        source, enumerate(indices.tolist()), lambda _, picture: detector.detect(picture), "", faults
    )
    with closing(outputs):
        for _ in outputs:
            ends.append(time.perf_counter())
            is_enough = len(ends) > n_threads * (1 + TIMED_PER_THREAD)
            if is_enough and ends[-1] - ends[n_threads] > ENOUGH_S:
                break
    began = n_threads if len(ends) > n_threads + 1 else 0
    return len(ends) - 1 - began, ends[-1] - ends[began]
