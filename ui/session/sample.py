"""What all visitors may open (sample, start), and what is computed of it as it opens: made once.

The sample recordings, and the session that the app was started with. Nothing of a visitor's own
gets in here: a session takes part only while it has the very object `SharedSample.opened` open,
which is never changed but replaced, with the settings that it opens with. Pictures stay with each
session: their files have a position.
"""

from __future__ import annotations

import threading
from collections import OrderedDict, defaultdict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Final, TypeVar

from nvcore.inputs.load import load
from nvcore.inputs.session import Session
from nvcore.inputs.session_toml import read_session
from ui.session.cache import Caching
from ui.session.workspace import Opened

MOST_SAMPLES: Final = 2
T = TypeVar("T")


class SharedSample(Caching):
    """A session file that all visitors may open, read once; nobody changes what is `opened`."""

    def __init__(self, path: Path, label: str) -> None:
        super().__init__()
        self._turns: defaultdict[str, threading.RLock] = defaultdict(threading.RLock)
        session = read_session(path)
        self.opened: Final = Opened.of(session, load(session.of_all), label)

    def cached(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """As `Caching.cached`; of several visitors at once one makes it, the others wait."""
        with self._turns[kind]:
            return super().cached(kind, key, make, most=most)


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
