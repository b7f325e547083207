"""Columns that subjects add to the CSV files of a report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

from nvcore.comparison import Result
from nvcore.measures.entry import Condition, is_met
from nvcore.subjects import contributed
from nvcore.tables.column import Column


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
        for part in chain(*contributed("columns"))
        if part.file == file
        for column in part.columns
    )


def added_values(file: str, result: Result) -> dict[str, Any]:
    """Return the values of the `added_columns` that a comparison has, by name."""
    values: dict[str, Any] = {}
    for part in chain(*contributed("columns")):
        if part.file == file and is_met(part.only_if, result):
            values |= part.values(result)
    return values
