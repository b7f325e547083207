"""Columns that subjects add to the CSV files of a report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any

from nvcore.comparison import Result
from nvcore.subjects import contributed
from nvcore.tables.column import Column


@dataclass(frozen=True)
class Columns:
    """Columns of one file, which follow the core's own.

    Attributes
    ----------
    file
        Such as ``encounters.csv``.
    columns
        What they hold, in order.
    values
        Their values by name.
    applies
        Whether a comparison has them; None: every one does.
    """

    file: str
    columns: tuple[Column, ...]
    values: Callable[[Result], Mapping[str, Any]]
    applies: Callable[[Result], bool] | None = None


def added_columns(file: str) -> tuple[Column, ...]:
    """What subjects add to a file, in order."""
    return tuple(
        column
        for part in chain(*contributed("columns"))
        if part.file == file
        for column in part.columns
    )


def added_values(file: str, result: Result) -> dict[str, Any]:
    """The values of `added_columns` that a comparison has, by name."""
    values: dict[str, Any] = {}
    for part in chain(*contributed("columns")):
        if part.file == file and (part.applies is None or part.applies(result)):
            values |= part.values(result)
    return values
