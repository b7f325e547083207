"""Tables as accessible HTML in which only the visible rows are elements.

This is a Streamlit component. Headings sort in the browser, or ask the page to sort. In clickable
tables, Python receives the row and the column. For tables of measures see `ui.widgets.html`.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import streamlit as st
from pandas.api.types import is_float_dtype, is_numeric_dtype

from ui.session import store
from ui.widgets.script import read_script

FOLDER: Final = Path(__file__).parent
MOST_LINES: Final = 10
INFINITE: Final = {np.inf: "∞", -np.inf: "−∞"}
_COMPONENT = st.components.v2.component(
    "nvcore_table",
    css=(FOLDER / "table.css").read_text(encoding="utf-8"),
    js=read_script(FOLDER / "table.js"),
)


@dataclass(frozen=True)
class TableColumn:
    """Appearance of a table column.

    Attributes
    ----------
    label
        Heading.
    help
        Description, shown while the mouse is over the heading.
    form
        Number format: ``.2f``, ``+.2f``, ``.0%``, ``d``, ``.4g``. Empty: unchanged.
    is_head
        Whether it names the row, and stays visible during horizontal scrolling.
    is_number
        Whether text values are right-aligned like numbers.
    """

    label: str
    help: str = ""
    form: str = ""
    is_head: bool = False
    is_number: bool = False


@dataclass(frozen=True)
class SortedBy:
    """Column by which the page has sorted the rows."""

    column: str
    is_descending: bool


def draw_table(
    table: pd.DataFrame,
    columns: Mapping[str, TableColumn],
    *,
    key: str,
    name: str,
    on_click: Callable[[int, str], None] | None = None,
    clicks: Literal["row", "cell"] = "row",
    selected: int | None = None,
    sorted_by: SortedBy | None = None,
    on_sort: Callable[[str], None] | None = None,
    is_sortable: bool = True,
    most_lines: int = MOST_LINES,
) -> None:
    """Draw the rows of `table`, at most `most_lines` of them visible at a time.

    Parameters
    ----------
    table : DataFrame
        Any number of rows. Undefined values are shown as "–".
    columns
        Columns to show, in this order.
    key
        Streamlit's key.
    name
        Description of the table for screen readers.
    on_click
        Called before the next run with the position of the clicked row in `table` and the column's
        name, unless the rows have changed by then.
    clicks : {"row", "cell"}
        Whether a click selects a row or a cell.
    selected
        Position of the row to mark and scroll to. None: no row.
    sorted_by, on_sort
        Current order of the rows, and a callback for the column of a clicked heading. None:
        headings sort the rows in the browser.
    is_sortable
        Whether headings sort at all.
    """
    shown = {column: table[column] for column in columns}
    listed = [_values(values) for values in shown.values()]
    version = 0  # not needed without clicks
    if on_click is not None or on_sort is not None:
        version = zlib.crc32(repr(listed).encode())
    _COMPONENT(
        key=key,
        data={
            "name": name,
            "version": version,
            "nRows": len(table),
            "columns": [
                {
                    "label": column.label,
                    "help": column.help,
                    "form": column.form,
                    "isHead": column.is_head,
                    "isNumber": column.is_number or is_numeric_dtype(shown[of]),
                }
                for of, column in columns.items()
            ],
            "names": [*columns],
            "values": listed,
            "clicks": clicks if on_click is not None else None,
            "selected": selected,
            "isSortable": is_sortable and len(table) > 1,
            "sortedBy": None
            if sorted_by is None
            else {"column": sorted_by.column, "isDescending": sorted_by.is_descending},
            "lines": min(max(len(table), 1), most_lines),
        },
        on_clicked_change=partial(_tell, key, version, len(table), [*columns], on_click, on_sort),
    )


def own_headings(table: pd.DataFrame) -> dict[str, TableColumn]:
    """Return all columns under their own names. The first one names the row."""
    return {str(name): TableColumn(str(name), is_head=not i) for i, name in enumerate(table)}


def _values(values: pd.Series) -> list[Any]:
    """Return JSON-compatible values: None for NaN, text for infinity."""
    known: list[Any] = values.astype(object).where(values.notna(), None).tolist()
    return [INFINITE.get(value, value) for value in known] if is_float_dtype(values) else known


def _tell(
    key: str,
    version: int,
    n_rows: int,
    names: list[str],
    on_click: Callable[[int, str], None] | None,
    on_sort: Callable[[str], None] | None,
) -> None:
    """Pass on a click, unless its message is malformed."""
    clicked = store.sent(key, "clicked")
    if not isinstance(clicked, Mapping) or clicked.get("version") != version:
        return
    if clicked.get("column") not in names:
        return
    row, column = clicked.get("row"), str(clicked["column"])
    if row is None and on_sort is not None:
        on_sort(column)
    elif type(row) is int and 0 <= row < n_rows and on_click is not None:
        on_click(row, column)
