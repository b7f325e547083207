"""What was clicked in a figure, whichever way the widget reports it."""

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


def is_new_click(key: str, points: Any) -> bool:
    """Whether a chart's selection is new since the last call: it outlives reruns."""
    seen_clicks = st.session_state.setdefault("seen_clicks", {})
    current = repr(points)
    if seen_clicks.get(key) == current:
        return False
    seen_clicks[key] = current
    return True
