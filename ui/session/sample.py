"""What all visitors may open (sample, start), and what is computed of it: made once.

The sample recordings, and the session that the app was started with. Nothing of a visitor's own
gets in here: a session takes part only while it has the very object `SharedSample.opened` open,
which is never changed but replaced. Of the settings that it opens with all is kept; of others what
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
from ui.session.cache import Caching
from ui.session.workspace import Opened, Workspace

MOST_SAMPLES: Final = 2
MOST_MOVED: Final = 24
"""Settings other than those that it opens with, whose values are kept."""
MOVED_FRAMES: Final = 200_000
"""Frames of all of these together: a result holds some 200 bytes for each."""
T = TypeVar("T")


class SharedSample(Caching):
    """A session file that all visitors may open, read once; nobody changes what is `opened`."""

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
        """Its pictures, for one more visitor; where some cannot be opened, the next call tries."""
        with self._pictures_turn:
            pictures = self._pictures.get(key)
            if pictures is None or pictures.troubles:
                session = self.opened.session.of_all
                pictures = session_pictures(session, self.opened.whole, key=key)
                self._pictures[key] = pictures
            return pictures.another()

    def cached(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """As `Caching.cached`; of several visitors at once one makes it, the others wait."""
        turn = (kind, key)
        try:
            with self._turns.setdefault(turn, threading.RLock()):
                return super().cached(kind, key, make, most=most)
        finally:
            self._turns.pop(turn, None)  # who waits has it; who comes now finds the value

    def cached_moved(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """The same with other settings than those that it opens with: kept apart, and not all."""
        known: T | None = self.peek(kind, key)  # what these settings do not move
        if known is not None:
            return known
        if not self.most_moved:
            return make()
        return self.cached(_moved(kind), key, make, most=max(most, self.most_moved))

    def known(self, kind: str, key: Hashable) -> Any:
        """What either of them has for this key; None: there is nothing."""
        value = self.peek(kind, key)
        return self.peek(_moved(kind), key) if value is None else value


def _moved(kind: str) -> str:
    return f"{kind}, moved"


_samples: OrderedDict[Path, SharedSample] = OrderedDict()
_lock = threading.Lock()


def shared_sample(path: Path, *, label: str) -> SharedSample:
    """The sample of that session file; the first call reads it, the others wait for it.

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


def shared_opening(session: Session, label: str) -> Opened | None:
    """The sample of that very session, called so on the pages; None: it is a visitor's own."""
    with _lock:
        for sample in _samples.values():
            if sample.opened.session is session and sample.opened.label == label:
                return sample.opened
    return None


def sample_of(opened: Opened) -> SharedSample | None:
    """The sample that this is; None for anything else, a changed sample too."""
    with _lock:
        return next((sample for sample in _samples.values() if sample.opened is opened), None)


def as_shared(opened: Opened) -> Opened:
    """The sample, where this is the sample as it opens; else what was given."""
    with _lock:
        starts = [sample.opened for sample in _samples.values()]
    for start in starts:
        if start.whole.frames is opened.whole.frames and start.session == opened.session:
            return start
    return opened


def shown_in(space: Workspace, opened: Opened) -> Opened:
    """What is open from now on, with its pictures: the shared ones of a sample, else its own."""
    shared = sample_of(opened)
    if shared is not None:
        return space.show(opened, shared.new_pictures(), shared.new_pictures("visible"))
    session, whole, opener = opened.session.of_all, opened.whole, space.picture_process.open
    visible = session_pictures(session, whole, opener=opener, key="visible")
    return space.show(opened, session_pictures(session, whole, opener=opener), visible)
