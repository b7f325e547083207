"""A cache of values by kind and key."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

T = TypeVar("T")


class Caching:
    """Thread-safe cache of values by kind and key."""

    def __init__(self) -> None:
        self._caches: dict[str, OrderedDict[Hashable, Any]] = {}
        self._caches_lock = threading.Lock()

    def cached(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """The cached value for this key; if there is none, `make` computes it.

        Parameters
        ----------
        kind
            Name of the cache; each kind has its own.
        key
            What the value depends on.
        make
            Makes it; of two threads that ask at once, each makes one and the first is kept.
        most
            How many values the cache holds; the least recently used is dropped first.
        """
        value: T
        with self._caches_lock:
            cache = self._caches.setdefault(kind, OrderedDict())
            if key in cache:
                cache.move_to_end(key)
                value = cache[key]
                return value
        new = make()  # without the lock: it takes its time, and may end the run
        with self._caches_lock:
            cache = self._caches.setdefault(kind, OrderedDict())
            value = cache.setdefault(key, new)
            cache.move_to_end(key)
            while len(cache) > most:
                cache.popitem(last=False)
        return value

    def peek(self, kind: str, key: Hashable) -> Any:
        """The cached value for this key; None if there is none."""
        with self._caches_lock:
            cache = self._caches.get(kind)
            return None if cache is None else cache.get(key)

    def forget_values(self) -> None:
        """Empty the cache."""
        with self._caches_lock:
            self._caches.clear()
