"""Column of the report: its name, unit, type and meaning; and the columns that subjects add."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import chain
from typing import Any, Final

from nvcore.common.subject import subjects
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Condition, Measure, is_met


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
        One sentence; a template with words of the objects (`nvcore.common.wording.objects`).
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


@dataclass(frozen=True)
class Columns:
    """Columns of one file that follow the core's own.

    Attributes
    ----------
    file
        Name of the file, such as ``encounters.csv``.
    columns
        Columns in order.
    values
        Function that returns the values by column name.
    only_if
        Condition for including them in the file; None: always included.
    """

    file: str
    columns: tuple[Column, ...]
    values: Callable[[Result], Mapping[str, Any]]
    only_if: Condition | None = None


def added_columns(file: str) -> tuple[Column, ...]:
    """Return the columns that subjects add to a file, in order."""
    return tuple(
        replace(column, only_if=part.only_if)
        for subject in subjects()
        for part in subject.tables().columns
        if part.file == file
        for column in part.columns
    )


def added_values(file: str, result: Result) -> dict[str, Any]:
    """Return the values of the `added_columns` that a comparison has, by name."""
    values: dict[str, Any] = {}
    for part in chain(*(subject.tables().columns for subject in subjects())):
        if part.file == file and is_met(part.only_if, result):
            values |= part.values(result)
    return values
