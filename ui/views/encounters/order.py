"""Encounters page: order in which the encounters are listed and reviewed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from nvcore.dataset.schema import Category
from nvcore.tables.columns import report_columns

SEVERITY: Final = "severity"
"""Initial order, by the larger of X's and Y's severity. All other orders are columns."""
COLUMNS: Final = tuple(column.name for column in report_columns()["encounters.csv"])


@dataclass(frozen=True)
class Order:
    """Sort key of the encounters: `SEVERITY`, or one of `COLUMNS`."""

    by: str = SEVERITY
    is_descending: bool = True

    @property
    def text(self) -> str:
        """Text for an address, such as ``-lag_s_x`` for descending order."""
        return f"-{self.by}" if self.is_descending else self.by

    def sort(self, encounters: pd.DataFrame) -> pd.DataFrame:
        """Sort rows and keep their index.

        Rows without a value are last in either direction. Ties are sorted by heavier failure, then
        by taller pedestrian. By severity, distant pedestrians, who do not count, are last.
        """
        heaviest_first = encounters.iloc[_by_weight(encounters, is_descending=True)]
        if self.by == SEVERITY:
            if self.is_descending:
                return heaviest_first
            return encounters.iloc[_by_weight(encounters, is_descending=False)]
        return heaviest_first.sort_values(
            self.by, ascending=not self.is_descending, kind="stable", na_position="last"
        )


def order_of(text: str) -> Order | None:
    """Parse the order in an address. Return None if it is not valid."""
    order = Order(text.removeprefix("-"), is_descending=text.startswith("-"))
    return order if order.by in (SEVERITY, *COLUMNS) else None


def _by_weight(encounters: pd.DataFrame, *, is_descending: bool) -> np.ndarray:
    severity_s = encounters[["severity_s_x", "severity_s_y"]].max(axis=1).to_numpy(dtype=float)
    severity_s = np.where(np.isnan(severity_s), -1.0, severity_s)
    is_distant = (encounters["category"] == Category.DISTANT.value).to_numpy()
    height = encounters["peak_height"].to_numpy(dtype=float)
    sign = -1 if is_descending else 1
    return np.lexsort((-height, sign * severity_s, is_distant))
