"""Recordings to be appended to stores, and processes that append them."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
from builders import Box, Place, make_dataset

from nvcore.dataset import Dataset
from nvcore.subjects.fleet.ingest import tables_of
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.store import Store

N_FRAMES = 30


def recordings(*names: str, seed: int = 0, **columns: object) -> Dataset:
    """Recordings with a pedestrian each, whom x detects everywhere and y somewhere, by the seed."""
    rng = np.random.default_rng(seed)
    truth, x, y = [], [], []
    for recording in range(len(names)):
        for frame in range(0, N_FRAMES, 2):
            at = rng.random()
            truth.append(Box(frame, 10 + at, 20, 10, 20, track=1, recording=recording))
            x.append(Box(frame, 11 + at, 20, 10, 20, score=rng.random(), recording=recording))
            if rng.random() < 0.5:
                y.append(Box(frame, 9 + at, 20, 10, 20, score=0.5, recording=recording))
    made = make_dataset(truth, x, y, places=[Place(range(N_FRAMES), horizon=40)] * len(names))
    return replace(made, recordings=made.recordings.assign(name=list(names), **columns))


def batch_of(*names: str, seed: int = 0) -> list[dict[str, pa.Table]]:
    return [tables_of(recordings(name, seed=seed)) for name in names]


class Killed(BaseException):
    """Ends a writer in the middle, as a signal would."""


class DyingStore(Store):
    """A store whose writer ends before its n-th write to the location or commit.

    Parameters
    ----------
    end
        How it ends.
    """

    def __init__(self, location: Location, n: int, end: Callable[[], None]):
        super().__init__(location)
        self.left, self.end = n, end
        self.location.write = self._counted(self.location.write)  # type: ignore[method-assign]
        self._commit = self._counted(self._commit)  # type: ignore[method-assign]

    def _counted(self, act: Callable[..., None]) -> Callable[..., None]:
        def counted(*given: object) -> None:
            self.left -= 1
            if self.left < 0:
                self.end()
            act(*given)

        return counted


def append_and_be_killed(location: Location, n: int, *names: str) -> None:
    """In a process of its own: append, and be killed before the n-th write."""
    end = lambda: os.kill(os.getpid(), signal.SIGKILL)  # noqa: E731
    DyingStore(location, n, end).append(batch_of(*names, seed=1))


def append_each(location: Location, done: Path, *names: str) -> None:
    """In a process of its own: append recordings one by one; a file says that it is done."""
    store = Store(location)
    for name in names:
        store.append(batch_of(name))
    done.write_text("done")
