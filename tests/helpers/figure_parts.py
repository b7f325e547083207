"""Parts of a Plotly figure by name, for tests."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go


def trace(figure: go.Figure, name: str) -> Any:
    """The only trace of that name."""
    found = [one for one in figure.data if one.name == name]
    assert len(found) == 1, [one.name for one in figure.data]
    return found[0]


def shape(figure: go.Figure, name: str) -> Any:
    """The only shape of that name."""
    found = [one for one in figure.layout.shapes if one.name == name]
    assert len(found) == 1, [one.name for one in figure.layout.shapes]
    return found[0]


def words(figure: go.Figure) -> str:
    """Everything that a person reads without pointing at a mark."""
    texts = [figure.layout.title.text or "", *(one.text for one in figure.layout.annotations)]
    return " | ".join(texts + [one.name or "" for one in figure.data]).replace("<br>", " ")
