from __future__ import annotations

import plotly.graph_objects as go

from nvcore.comparison.compare import Result
from nvcore.notes import Note
from nvcore.report.verdict import PointOf
from nvcore.tables.column import CellKind, Column, Columns
from toy.measures import is_long


def _draw(result: Result, *, theme: str) -> go.Figure:
    return go.Figure(go.Bar(y=is_long(result).astype(int)), layout={"title": "Toy"})


COLUMNS = (
    Columns(
        "encounters.csv",
        (Column("toy_long", CellKind.TRUTH_VALUE, "", "Whether the encounter is long."),),
        lambda result: {"toy_long": is_long(result)},
    ),
)
FIGURES = {"toy": _draw}


def _long(result: Result) -> tuple[Note, ...]:
    return (Note("toy.long", n=int(is_long(result).sum())),)


POINTS = (PointOf("Toy", _long, after="Encounters"),)
