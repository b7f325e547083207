"""Column of the report: its name, unit, type and meaning."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

from nvcore.measures.entry import Condition, Measure


class CellKind(StrEnum):
    """Type of a column's cells."""

    TEXT = "text"
    INTEGER = "integer"
    NUMBER = "number"
    TRUTH_VALUE = "0 or 1"
    TABLE = "table"  # summary.json only


@dataclass(frozen=True)
class Column:
    """Column of a CSV file, or key of ``summary.json``.

    Attributes
    ----------
    name
        Name in the file.
    kind
        Type of the cells.
    unit
        Unit or range; empty for none.
    meaning
        One sentence; a template with words of the objects (`nvcore.wording.objects`).
    better
        ``"high"`` or ``"low"`` if one is better, else empty.
    empty
        Case in which the cell is empty (in JSON: null), a template as well; empty: never.
    only_if
        Condition for including it in files; None: always included.
    """

    name: str
    kind: CellKind
    unit: str
    meaning: str
    better: str = ""
    empty: str = ""
    only_if: Condition | None = None


def measure_column(measure: Measure) -> Column:
    """Return the column of a measure for a system over all recordings."""
    return Column(
        measure.key,
        CellKind.INTEGER if measure.form == "d" else CellKind.NUMBER,
        measure.unit,
        measure.meaning,
        measure.better.removesuffix("er"),
        measure.empty,
        measure.only_if,
    )


def of_both(*columns: Column) -> tuple[Column, ...]:
    """Return the columns of X, then the same of Y."""
    return tuple(
        replace(column, name=f"{column.name}_{letter}") for letter in "xy" for column in columns
    )


RECORDING: Final = Column("recording", CellKind.TEXT, "", "Name of the recording.")
