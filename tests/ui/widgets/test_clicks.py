"""What a click means, as figures and tables report it."""

from __future__ import annotations

from typing import Any

import pytest

from ui.widgets import clicks


@pytest.fixture
def state(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    kept: dict[str, Any] = {}
    monkeypatch.setattr(clicks.st, "session_state", kept)
    return kept


def select(state: dict[str, Any], rows=(), cells=()) -> int | None:
    state["table"] = {"selection": {"rows": list(rows), "cells": list(cells), "columns": []}}
    return clicks.clicked_row("table")


@pytest.mark.parametrize(
    ("points", "click"),
    [
        ([{"customdata": 7, "curve_number": 1}], (7, 1)),
        ([{"customdata": [7], "curve_number": 1}], (7, 1)),
        ([], None),  # taken back
        ([{"curve_number": 0}], None),  # stands for nothing
    ],
)
def test_a_point_is_known_by_its_custom_data_and_trace(
    state: dict[str, Any], points: list[dict[str, Any]], click: tuple[int, int] | None
):
    state["plot"] = {"selection": {"points": points}}
    assert clicks.clicked_point("plot") == click


def test_a_row_is_clicked_on_its_mark_or_in_a_cell_also_again(state: dict[str, Any]):
    assert select(state) is None
    assert select(state, rows=[3]) == 3
    assert select(state, rows=[3], cells=[(5, "track")]) == 5
    assert select(state, rows=[4], cells=[(5, "track")]) == 4
    assert select(state, cells=[(5, "track")]) is None  # the row was taken back
    assert select(state, cells=[(5, "track")]) == 5


def test_a_cell_is_known_by_row_and_column(state: dict[str, Any]):
    select(state, cells=[(2, "Y late")])
    assert clicks.clicked_cell("table") == (2, "Y late")
    select(state)
    assert clicks.clicked_cell("table") is None
