"""What a table tells the page, and what it does not believe."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd
import pytest

from ui.widgets import table

ROWS = pd.DataFrame({"name": ["a", "b"], "n": [1, None], "share": [math.inf, math.nan]})


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What is drawn; `clicks` of the browser are believed or not by `on_clicked_change`."""
    drawn: dict[str, Any] = {}
    monkeypatch.setattr(table, "_COMPONENT", lambda **sent: drawn.update(sent))
    monkeypatch.setattr(table.st, "session_state", drawn.setdefault("state", {}))
    return drawn


def test_what_is_undefined_is_sent_as_nothing(told: dict[str, Any]):
    table.draw_table(ROWS, table.own_headings(ROWS), key="t", name="Rows")
    assert told["data"]["values"] == [["a", "b"], [1.0, None], ["∞", None]]
    assert [column["isNumber"] for column in told["data"]["columns"]] == [False, True, True]
    assert [column["isHead"] for column in told["data"]["columns"]] == [True, False, False]
    assert told["data"]["clicks"] is None


@pytest.mark.parametrize(
    ("clicked", "heard"),
    [
        ({"row": 1, "column": "n"}, [(1, "n")]),
        ({"row": None, "column": "n"}, ["n"]),
        ({"row": 1, "column": "n", "version": 0}, []),  # of other rows
        ({"row": 2, "column": "n"}, []),
        ({"row": -1, "column": "n"}, []),
        ({"row": True, "column": "n"}, []),
        ({"row": 0.5, "column": "n"}, []),
        ({"row": 0, "column": "other"}, []),
        ({"row": 0, "column": ["n"]}, []),
        ("0", []),
        (None, []),
    ],
)
def test_a_click_is_believed_where_it_can_be_meant(told: dict[str, Any], clicked, heard):
    calls: list[Any] = []
    table.draw_table(
        ROWS,
        table.own_headings(ROWS),
        key="t",
        name="Rows",
        on_click=lambda row, column: calls.append((row, column)),
        on_sort=calls.append,
    )
    version = told["data"]["version"]
    if isinstance(clicked, dict):
        clicked = {"version": version, **clicked}
    told["state"]["t"] = {"clicked": clicked}
    told["on_clicked_change"]()
    assert calls == heard
