"""Tables of rows: accessible HTML, of which only the rows in sight are elements.

A Streamlit component. Headings sort in the browser, or ask the page to; where a table can be
clicked, Python is told the row and the column. Tables of measures are `ui.widgets.html`.
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
    """How a column of a table looks.

    Attributes
    ----------
    label
        Its heading.
    help
        What it holds, shown when the mouse is over the heading.
    form
        Format of its numbers: ``.2f``, ``+.2f``, ``.0%``, ``d``, ``.4g``; empty: as they are.
    is_head
        Whether it names the row: it stays in sight when the table is pushed sideways.
    is_number
        Whether it stands to the right though its values are texts.
    """

    label: str
    help: str = ""
    form: str = ""
    is_head: bool = False
    is_number: bool = False


@dataclass(frozen=True)
class SortedBy:
    """The column by which the page has sorted the rows."""

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
    """Draw the rows of `table`, at most `most_lines` of them in sight.

    Parameters
    ----------
    table : DataFrame
        Any number of rows; undefined values are shown as "–".
    columns
        The columns that are shown, in this order.
    key
        Streamlit's key.
    name
        What the table holds, for those who cannot see it.
    on_click
        Called before the next run with the clicked row's place in `table` and the column's name,
        unless other rows are there by then.
    clicks : {"row", "cell"}
        Whether a click means a row or a cell.
    selected
        Place of the row that is marked and brought into sight; None: none.
    sorted_by, on_sort
        The order in which the page gives the rows, and what is called with the column whose
        heading was clicked. None: headings sort the rows in the browser.
    is_sortable
        Whether headings sort at all.
    """
    shown = {column: table[column] for column in columns}
    listed = [_values(values) for values in shown.values()]
    version = 0  # of no use without clicks
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
    """All columns under their own names; the first names the row."""
    return {str(name): TableColumn(str(name), is_head=not i) for i, name in enumerate(table)}


def _values(values: pd.Series) -> list[Any]:
    """The values, which JSON can hold: None for NaN, a text for what is infinite."""
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
    """Pass on what was clicked, if a browser can have meant it."""
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
