"""Comparisons that all visitors share (samples, start), with results computed once.

The samples, and the session that the app was started with. Nothing of a visitor's own gets in
here: a session takes part only while it has the very object `SharedSample.opened` open, which is
never changed but replaced. Of the settings that it opens with all is kept; of others what
was asked for last, where the recordings are short. Which pictures there are is
looked up once as well; each session reads them by itself, since their files have a position.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, Final, TypeVar

from nvcore.inputs.load import load
from nvcore.inputs.session import Session
from nvcore.inputs.session_toml import read_session
from nvcore.pictures.recordings import RecordingPictures, Source, session_pictures
from ui.session.workspace import Caching, Opened, Workspace

MOST_SAMPLES: Final = 3
MOST_MOVED: Final = 24
"""Settings other than those that it opens with, whose values are kept."""
MOVED_FRAMES: Final = 200_000
"""Frames of all of these together: a result holds some 200 bytes for each."""
T = TypeVar("T")


class SharedSample(Caching):
    """A session that all visitors share, read once; `opened` is never changed."""

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
        """Pictures for one more visitor; those that cannot be opened are tried again next time."""
        with self._pictures_turn:
            pictures = self._pictures.get(key)
            if pictures is None or pictures.troubles:
                session = self.opened.session.of_all
                pictures = session_pictures(session, self.opened.whole, key=key)
                self._pictures[key] = pictures
            return pictures.another()

    def cached(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """As `Caching.cached`; of visitors that ask at once, one computes and the others wait."""
        turn = (kind, key)
        try:
            with self._turns.setdefault(turn, threading.RLock()):
                return super().cached(kind, key, make, most=most)
        finally:
            self._turns.pop(turn, None)  # who waits has it; who comes now finds the value

    def cached_moved(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """As `cached`, for settings other than the initial ones; a bounded cache of its own."""
        known: T | None = self.peek(kind, key)  # what these settings do not move
        if known is not None:
            return known
        if not self.most_moved:
            return make()
        return self.cached(_moved(kind), key, make, most=max(most, self.most_moved))

    def known(self, kind: str, key: Hashable) -> Any:
        """The value for this key in either cache; None if there is none."""
        value = self.peek(kind, key)
        return self.peek(_moved(kind), key) if value is None else value


def _moved(kind: str) -> str:
    return f"{kind}, moved"


_samples: OrderedDict[Path, SharedSample] = OrderedDict()
_lock = threading.Lock()


def shared_sample(path: Path, *, label: str) -> SharedSample:
    """The shared comparison of that session file; the first call reads it, later ones wait.

    Parameters
    ----------
    label
        What it is called on the pages.

    Raises
    ------
    NvcoreError
        If it cannot be read; the next call tries again.
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
    """The shared comparison with that session and label; None if it is a visitor's own."""
    shared = (one for one in _openings() if one.session is session and one.label == label)
    return next(shared, None)


def sample_of(opened: Opened) -> SharedSample | None:
    """The shared comparison that is open; None if it is another, or was changed."""
    with _lock:
        return next((sample for sample in _samples.values() if sample.opened is opened), None)


def as_shared(opened: Opened) -> Opened:
    """The shared comparison if this equals it as opened; else the argument."""
    frames, session = opened.whole.frames, opened.session
    shared = (one for one in _openings() if one.whole.frames is frames and one.session == session)
    return next(shared, opened)


def shown_in(space: Workspace, opened: Opened) -> Opened:
    """Opens a comparison in a workspace: with the shared pictures of a sample, else its own."""
    shared = sample_of(opened)
    if shared is not None:
        return space.show(opened, shared.new_pictures(), shared.new_pictures("visible"))
    session, whole, opener = opened.session.of_all, opened.whole, space.picture_process.open
    visible = session_pictures(session, whole, opener=opener, key="visible")
    return space.show(opened, session_pictures(session, whole, opener=opener), visible)
