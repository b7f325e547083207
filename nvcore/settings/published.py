"""Published operating points of others, drawn beside the curves."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from nvcore.common.errors import ParameterError

_LONGEST_NAME = 80
_HIGHEST = {"recall": 1.0, "miss_rate": 1.0, "precision": 1.0, "fppi": 1e9, "fppw": 1.0}


@dataclass(frozen=True, kw_only=True)
class PublishedPoint:
    """Point of a published detection curve, perhaps with some values unknown.

    Attributes
    ----------
    name
        Name of the system or the source.
    recall, miss_rate
        Share of the objects that are detected or missed. Exactly one of them is given.
    precision
        Share of the detections that are right.
    fppi, fppw
        False positives per image, and per window.

    Raises
    ------
    ParameterError
        If a value is impossible, or there is nothing to draw.
    """

    name: str
    recall: float | None = None
    miss_rate: float | None = None
    precision: float | None = None
    fppi: float | None = None
    fppw: float | None = None

    def __post_init__(self) -> None:
        if not 0 < len(self.name) <= _LONGEST_NAME or not self.name.isprintable():
            raise ParameterError(f"name: expected 1 to {_LONGEST_NAME} characters")
        for key, highest in _HIGHEST.items():
            value = getattr(self, key)
            if value is not None and not 0 <= value <= highest:
                raise ParameterError(f"{key}: expected 0 to {highest:g}, got {value:g}")
        if (self.recall is None) == (self.miss_rate is None):
            raise ParameterError("expected recall or miss_rate, one of them")
        if self.precision is None and self.fppi is None and self.fppw is None:
            raise ParameterError("expected precision, fppi or fppw beside it")

    def values(self) -> dict[str, float]:
        """Return the values by the names of a curve's columns, NaN if unknown."""
        known = {key: math.nan if value is None else value for key, value in self._numbers()}
        if self.recall is None:
            known["recall"] = 1 - known["miss_rate"]
        else:
            known["miss_rate"] = 1 - known["recall"]
        return known

    def given(self) -> dict[str, Any]:
        """Return the known values as in a session file."""
        numbers = {key: value for key, value in self._numbers() if value is not None}
        return {"name": self.name, **numbers}

    def _numbers(self) -> list[tuple[str, Any]]:
        return [(key, value) for key, value in asdict(self).items() if key != "name"]
