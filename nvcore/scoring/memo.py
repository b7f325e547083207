"""Results of the stages, kept from one comparison to the next."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import Any, TypeVar

from nvcore.params import Params
from nvcore.params.metadata import Stage

T = TypeVar("T")


class Memo:
    """Results of the stages by what they depend on: a new setting repeats only what it changes."""

    def __init__(self, params: Params, previous: Mapping[tuple[Any, ...], Any]):
        self._params = params
        self._previous = previous
        self.used: dict[tuple[Any, ...], Any] = {}

    def get(self, name: Hashable, make: Callable[[], T], *stages: Stage) -> T:
        """The result of these stages: the previous one if none of their settings has changed.

        Parameters
        ----------
        name
            Name of the result; with the system and its threshold if it belongs to one.
        """
        key = (name, *self._params.values_for(*stages))
        value = self._previous[key] if key in self._previous else make()
        self.used[key] = value
        return value
