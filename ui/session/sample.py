"""Comparisons that all visitors share, with results computed once.

These are the samples and the session that the app was started with. A browser session takes part
only while the very object `SharedSample.opened` is its open comparison. Changes replace that object
and never modify it, so no visitor's own data get in here. All results of the initial settings are
kept. For other settings, the latest results are kept if the recordings are short. The search for
pictures runs once as well, but each session reads them by itself, since files have a position.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, Final, TypeVar

from nvcore.inputs.load import load
from nvcore.inputs.session import Session
from nvcore.inputs.session.toml import read_session
from nvcore.pictures.recordings import RecordingPictures, Source, session_pictures
from ui.session.workspace import Caching, Opened, Workspace

MOST_SAMPLES: Final = 3
MOST_MOVED: Final = 24
"""Largest number of cached values for settings other than the initial ones."""
MOVED_FRAMES: Final = 200_000
"""Largest number of frames in all of these together. A result holds about 200 bytes per frame."""
T = TypeVar("T")


class SharedSample(Caching):
    """A comparison that all visitors share, read once. `opened` is never modified."""

    def __init__(self, path: Path, label: str) -> None:
        super().__init__()
        self._turns: dict[tuple[str, Hashable], threading.RLock] = {}
        self._pictures: dict[Source, RecordingPictures] = {}
        self._pictures_turn = threading.Lock()
        session = read_session(path)
        self.opened: Final = Opened.of(session, load(session.of_all), label)
        n_frames = max(len(self.opened.dataset.frames), 1)
        self.most_moved: Final = min(MOST_MOVED, MOVED_FRAMES // n_frames)

    def new_pictures(self, key: Source = "pictures") -> RecordingPictures:
        """Return pictures for another visitor. Each call retries those that cannot be opened."""
        with self._pictures_turn:
            pictures = self._pictures.get(key)
            if pictures is None or pictures.troubles:
                session = self.opened.session.of_all
                pictures = session_pictures(session, self.opened.whole, key=key)
                self._pictures[key] = pictures
            return pictures.another()

    def cached(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """Like `Caching.cached`, but of several visitors one computes and the others wait."""
        turn = (kind, key)
        try:
            with self._turns.setdefault(turn, threading.RLock()):
                return super().cached(kind, key, make, most=most)
        finally:
            self._turns.pop(turn, None)  # waiting threads have the lock, later ones find the value

    def cached_moved(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """Like `cached`, but in a bounded cache for settings other than the initial ones."""
        known: T | None = self.peek(kind, key)  # a value that these settings do not affect
        if known is not None:
            return known
        if not self.most_moved:
            return make()
        return self.cached(_moved(kind), key, make, most=max(most, self.most_moved))

    def known(self, kind: str, key: Hashable) -> Any:
        """Return the value for this key from either cache, or None."""
        value = self.peek(kind, key)
        return self.peek(_moved(kind), key) if value is None else value


def _moved(kind: str) -> str:
    return f"{kind}, moved"


_samples: OrderedDict[Path, SharedSample] = OrderedDict()
_lock = threading.Lock()


def shared_sample(path: Path, *, label: str) -> SharedSample:
    """Return the shared comparison of a session file. The first call reads it, others wait.

    Parameters
    ----------
    label
        Name of the comparison on the pages.

    Raises
    ------
    NvcoreError
        If it cannot be read. The next call tries again.
    """
    with _lock:
        if path not in _samples:
            _samples[path] = SharedSample(path, label)
        _samples.move_to_end(path)
        while len(_samples) > MOST_SAMPLES:
            _samples.popitem(last=False)
        return _samples[path]


def _openings() -> list[Opened]:
    with _lock:
        return [sample.opened for sample in _samples.values()]


def shared_opening(session: Session, label: str) -> Opened | None:
    """Return the shared comparison with that session and label, or None."""
    shared = (one for one in _openings() if one.session is session and one.label == label)
    return next(shared, None)


def sample_of(opened: Opened) -> SharedSample | None:
    """Return the shared comparison that is `opened`, or None if it is another or was changed."""
    with _lock:
        return next((sample for sample in _samples.values() if sample.opened is opened), None)


def as_shared(opened: Opened) -> Opened:
    """Return the shared comparison that has the same data and session, or else the argument."""
    frames, session = opened.whole.frames, opened.session
    shared = (one for one in _openings() if one.whole.frames is frames and one.session == session)
    return next(shared, opened)


def shown_in(space: Workspace, opened: Opened) -> Opened:
    """Show a comparison in a workspace, with a sample's shared pictures if it is one."""
    shared = sample_of(opened)
    if shared is not None:
        return space.show(opened, shared.new_pictures(), shared.new_pictures("visible"))
    session, whole, opener = opened.session.of_all, opened.whole, space.picture_process.open
    visible = session_pictures(session, whole, opener=opener, key="visible")
    return space.show(opened, session_pictures(session, whole, opener=opener), visible)
