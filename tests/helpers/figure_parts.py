"""Parts of a Plotly figure by name, for tests."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go


def trace(figure: go.Figure, name: str) -> Any:
    """The only trace of that name."""
    parts = [part for part in figure.data if part.name == name]
    assert len(parts) == 1, [part.name for part in figure.data]
    return parts[0]


def shape(figure: go.Figure, name: str) -> Any:
    """The only shape of that name."""
    parts = [part for part in figure.layout.shapes if part.name == name]
    assert len(parts) == 1, [part.name for part in figure.layout.shapes]
    return parts[0]


def words(figure: go.Figure) -> str:
    """Everything that a person reads without pointing at a mark."""
    texts = [figure.layout.title.text or "", *(note.text for note in figure.layout.annotations)]
    return " | ".join(texts + [part.name or "" for part in figure.data]).replace("<br>", " ")
