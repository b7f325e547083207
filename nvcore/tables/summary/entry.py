"""Key of ``summary.json`` and its value."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any, NamedTuple

from nvcore.comparison.compare import Result
from nvcore.tables.column import Column


class SummaryEntry(NamedTuple):
    """Key and its value, by default the result's attribute of that name.

    The value is None or NaN if undefined.
    """

    column: Column
    of: Callable[[Result], Any] | None = None

    def value(self, result: Result) -> Any:
        """Return the key's value in a comparison."""
        return attrgetter(self.column.name)(result) if self.of is None else self.of(result)
