"""What was clicked in a figure or a table, whichever way the widget reports it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import streamlit as st


def clicked_point(key: str) -> tuple[Any, int] | None:
    """What a click in a figure means: `customdata` of the point and its trace; None: nothing."""
    points = st.session_state[key]["selection"]["points"]
    if not points or "customdata" not in points[0]:
        return None
    value = points[0]["customdata"]
    # Plotly passes a single value as it is or in a list
    return (value[0] if isinstance(value, list) else value), int(points[0]["curve_number"])


def clicked_place(clicked: Any) -> tuple[int, int]:
    """Frame row and encounter that a clicked point has as its `customdata`."""
    # Plotly passes several values as an object with their numbers as names
    row, encounter = clicked.values() if isinstance(clicked, Mapping) else clicked
    return int(row), int(encounter)


def clicked_row(key: str) -> int | None:
    """Row of a table that was clicked, on its mark or in one of its cells; None: taken back.

    To be called when the selection has changed: row and cell stay selected side by side, and what
    differs from the last time is what was clicked.
    """
    selection = st.session_state[key]["selection"]
    rows = [int(row) for row in selection["rows"]]
    cells = [int(row) for row, _ in selection["cells"]]
    before = st.session_state.get(f"{key}_before", ([], []))
    st.session_state[f"{key}_before"] = rows, cells
    if rows != before[0]:
        return rows[0] if rows else None
    clicked = cells if cells != before[1] else cells or rows
    return clicked[0] if clicked else None


def clicked_cell(key: str) -> tuple[int, str] | None:
    """Row and column of the cell of a table that was clicked; None: nothing."""
    cells = st.session_state[key]["selection"]["cells"]
    return (int(cells[0][0]), str(cells[0][1])) if cells else None


def is_new_click(key: str, points: Any) -> bool:
    """Whether a chart's selection is new since the last call: it outlives reruns."""
    seen_clicks = st.session_state.setdefault("seen_clicks", {})
    current = repr(points)
    if seen_clicks.get(key) == current:
        return False
    seen_clicks[key] = current
    return True
