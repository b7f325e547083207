from __future__ import annotations

from dataclasses import dataclass

import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.report.verdict import PointOf
from nvcore.sentences.facts import Fact
from nvcore.tables.added import Columns
from nvcore.tables.column import CellKind, Column
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


@dataclass(frozen=True)
class Long(Fact):
    """How many encounters are long."""

    n: int


TEXTS = {Long: "{n} are long."}
POINTS = (PointOf("Toy", lambda result: (Long(int(is_long(result).sum())),), after="Encounters"),)
