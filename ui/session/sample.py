"""The sample recordings, and what is computed of them as they open: made once for all visitors.

Most visits begin with them. Nothing of a visitor's own gets in here: a session takes part only
while it has the very object `SharedSample.opened` open, which is never changed but replaced, with
the settings that it opens with. Pictures stay with each session: their files have a position.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Final, TypeVar

from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from ui.session.workspace import Opened

T = TypeVar("T")

MOST_SAMPLES: Final = 2


class SharedSample:
    """A session file that all visitors may open, read once; nobody changes what is `opened`."""

    def __init__(self, path: Path, label: str) -> None:
        session = read_session(path)
        self.opened: Final = Opened(session, load(session), label)
        self._lock = threading.Lock()
        self._caches: dict[str, OrderedDict[Hashable, object]] = {}

    def cached(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """As `Workspace.cached`, made by any session.

        For values that follow from the sample and the key alone, and that nobody changes.
        """
        value = self.peek(kind, key)
        if value is None:
            value = make()  # without the lock: it takes its time, and may end the run
        with self._lock:
            cache = self._caches.setdefault(kind, OrderedDict())
            value = cache.setdefault(key, value)
            cache.move_to_end(key)
            while len(cache) > most:
                cache.popitem(last=False)
        return value  # type: ignore[return-value]  # one cache holds one type

    def peek(self, kind: str, key: Hashable) -> object | None:
        """The value that there is for this key; None: there is none."""
        with self._lock:
            cache = self._caches.get(kind)
            return None if cache is None else cache.get(key)


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


def sample_of(opened: Opened) -> SharedSample | None:
    """The sample that this is; None for anything else, a changed sample too."""
    with _lock:
        return next((sample for sample in _samples.values() if sample.opened is opened), None)
