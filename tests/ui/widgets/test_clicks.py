"""What a click means, as figures report it."""

from __future__ import annotations

from typing import Any

import pytest

from ui.widgets import clicks


@pytest.fixture
def state(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    kept: dict[str, Any] = {}
    monkeypatch.setattr(clicks.st, "session_state", kept)
    return kept


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
