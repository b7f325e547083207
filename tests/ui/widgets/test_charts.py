"""Figures as the browser gets them, and what a click in one of them means."""

from __future__ import annotations

import json
from typing import Any

import plotly.graph_objects as go
import pytest

from nvcore.figures.style import LOOK
from ui.widgets import charts
from ui.widgets.clicks import take_click


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What is drawn; `clicks` of the browser are believed or not by `on_clicked_change`."""
    drawn: dict[str, Any] = {}
    monkeypatch.setattr(charts, "_COMPONENT", lambda **sent: drawn.update(sent))
    monkeypatch.setattr("streamlit.session_state", drawn.setdefault("state", {}))
    return drawn


def figure() -> go.Figure:
    trace, texts = (
        go.Scatter(x=[1, 2], y=[3, 4]),
        {"title": "Lost & found", "subtitle": "<i>of 3</i>"},
    )
    return LOOK["light"].draw(trace, height=300, **texts)


def test_a_figure_is_sent_with_its_heading_apart(told: dict[str, Any]):
    shown = figure()
    for _ in range(2):  # a figure that is kept is drawn again
        charts.draw_chart(shown, "plot", of="frame 3", time_axis="x")
        assert told["data"]["meta"] == ["Lost & found", "frame 3; <i>of 3</i>", "x"]
        assert told["data"]["isClicked"] is False
        spec = json.loads(told["data"]["spec"])
        assert "text" not in spec["layout"].get("title", {})
        assert spec["layout"]["height"] == told["data"]["height"] < 300
        assert told["height"] == told["data"]["height"] + charts.HEADING_PX


@pytest.mark.parametrize(
    ("clicked", "heard"),
    [
        ({"value": 7, "curve": 1}, charts.Clicked(7, 1)),
        ({"value": ["x", 0.5], "curve": 0}, charts.Clicked(["x", 0.5], 0)),
        ({"value": None, "curve": 0}, None),  # stands for nothing
        ({"value": 7}, None),
        ({"value": 7, "curve": True}, None),
        ("7", None),
        (None, None),
    ],
)
def test_a_click_is_believed_where_it_can_be_meant(told: dict[str, Any], clicked, heard):
    calls: list[charts.Clicked] = []
    charts.draw_chart(figure(), "plot", on_click=calls.append)
    assert told["data"]["isClicked"] is True
    told["state"]["plot"] = {"clicked": clicked}
    told["on_clicked_change"]()
    assert calls == ([] if heard is None else [heard])


def test_a_click_that_the_page_asks_for_is_heard_once(told: dict[str, Any]):
    assert charts.clicked_chart(figure(), "plot") is None
    told["state"]["plot"] = {"clicked": {"value": [3, 4], "curve": 0}}
    told["on_clicked_change"]()
    assert take_click("other") is None
    assert charts.clicked_chart(figure(), "plot") == [3, 4]
    assert charts.clicked_chart(figure(), "plot") is None
