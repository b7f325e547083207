"""Logarithmic axes of rates, which may be 0: what is below the lowest tick stands at the edge."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

EDGE_SHARE: Final = 0.09
"""Of the axis: from the lowest tick down to the edge."""
MARGIN_SHARE: Final = 0.02
"""Of the axis: room at its low end, so that marks are whole and labels do not touch."""


@dataclass(frozen=True)
class LogScale:
    """A logarithmic axis with a place for zeros.

    Attributes
    ----------
    ticks
        Values with a label, increasing.
    high
        Its upper end.
    edge_label
        What stands at the edge: "0", or "< 0.001" where small numbers stand there as well; ""
        where nothing does.
    """

    ticks: tuple[float, ...]
    high: float
    edge_label: str = ""

    @property
    def low(self) -> float:
        """The lowest tick."""
        return self.ticks[0]

    @property
    def edge(self) -> float:
        """Where what is below the lowest tick is drawn."""
        return float(self.low * (self.low / self.high) ** EDGE_SHARE)

    def place(self, values: np.ndarray) -> np.ndarray:
        """Where values are drawn; those below the lowest tick at the edge."""
        placed: np.ndarray = np.where(self.is_below(values), self.edge, values)
        return placed

    def is_below(self, values: np.ndarray) -> np.ndarray:
        """Whether values stand at the edge."""
        below: np.ndarray = values < self.low * (1 - 1e-9)
        return below

    def axis(self) -> dict[str, Any]:
        """Settings of Plotly's axis."""
        bottom = self.edge if self.edge_label else self.low
        bottom *= (self.low / self.high) ** MARGIN_SHARE
        ticks, labels = [*self.ticks], [_label(tick) for tick in self.ticks]
        if self.edge_label:
            ticks, labels = [self.edge, *ticks], [self.edge_label, *labels]
        return {
            "type": "log",
            "range": [math.log10(bottom), math.log10(self.high)],
            "tickvals": ticks,
            "ticktext": labels,
        }


def log_scale(values: np.ndarray, ticks: Sequence[float], high: float) -> LogScale:
    """The axis with these ticks and upper end; whether it has an edge, the values (0 or more) tell.

    Examples
    --------
    >>> log_scale(np.array([0.0, 0.5]), (0.01, 0.1, 1.0), 1.0).edge_label
    '0'
    >>> log_scale(np.array([0.0, 0.001]), (0.01, 0.1, 1.0), 1.0).edge_label
    '< 0.01'
    """
    scale = LogScale(tuple(ticks), high)
    below = values[scale.is_below(values)]
    if not len(below):
        return scale
    return LogScale(tuple(ticks), high, "0" if not below.any() else f"< {_label(ticks[0])}")


def decades(low: float, high: float) -> tuple[float, ...]:
    """Powers of ten that hold both ends, both positive, in between."""
    first, last = math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9)
    # 10.0**-4 is not 1e-4, and a tick beyond the end has no label
    return tuple(float(f"1e{power}") for power in range(first, max(last, first + 1) + 1))


def _label(value: float) -> str:
    text = f"{value:g}" if value > 0.00099 else f"{value:.0e}"
    return text.replace("e-0", "e-")
