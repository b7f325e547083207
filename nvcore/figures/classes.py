"""What matched boxes were taken for, as a matrix."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.style import LOOK, axis, draw, empty_figure, plain, system_label
from nvcore.objects import labels_in_order
from nvcore.palette import Theme
from nvcore.tables.classes import read_share
from nvcore.wording import count_text

NO_CLASS: Final = "no class"
"""Column of the matches to which the system gives no class."""
_ROW_PX: Final = 30
_AROUND_PX: Final = 170


def classes_plot(table: pd.DataFrame, letter: str, name: str, *, theme: Theme) -> go.Figure:
    """Matches of one system: a row for each class of the truth, a column for each one read.

    Cells say how many boxes, darker the larger their share of the row; empty ones have none. What
    is right stands in the diagonal.

    Parameters
    ----------
    table
        `nvcore.tables.classes.classes_table`.
    letter, name
        "x" or "y", and the system's name.
    """
    look = LOOK[theme]
    rows = table[table["system"] == letter]
    if rows.empty:
        return empty_figure("No match has a class.", theme=theme)
    has_class = rows["read_class"].notna()
    classes = labels_in_order([*rows["truth_class"], *rows["read_class"][has_class]])
    columns = [*classes, *([] if has_class.all() else [NO_CLASS])]
    place = {label: number for number, label in enumerate(classes)}
    count = np.zeros((len(classes), len(columns)), np.int64)
    read = [place.get(label, len(classes)) for label in rows["read_class"]]
    count[[place[label] for label in rows["truth_class"]], read] = rows["n"].to_numpy(np.int64)
    total = count.sum(axis=1, keepdims=True)
    share = np.divide(count, total, out=np.full(count.shape, np.nan), where=count > 0)
    shown = [plain(label) for label in columns]
    cells = go.Heatmap(
        x=list(range(len(columns))),
        y=list(range(len(classes))),
        z=share,
        zmin=0,
        zmax=1,
        text=[[f"{n:,}" if n else "" for n in row] for row in count.tolist()],
        texttemplate="%{text}",
        colorscale=[(0, look.grid), (1, look.of(letter))],
        showscale=False,
        xgap=1,
        ygap=1,
        customdata=[[[of, to] for to in shown] for of in shown[: len(classes)]],
        hovertemplate="%{customdata[0]} read as %{customdata[1]}: %{text} (%{z:.0%} of its "
        "matches)<extra></extra>",
        hoverongaps=False,
    )
    right = read_share(table, letter)
    return draw(
        cells,
        theme,
        title=f"Classes read by {system_label(letter, name)}",
        subtitle=f"{right.n_right:,} of {count_text(right.n, 'match', 'matches')} right",
        height=_AROUND_PX + _ROW_PX * len(classes),
        showlegend=False,
        xaxis=axis(
            theme, "class read", tickvals=list(range(len(columns))), ticktext=shown, showgrid=False
        ),
        yaxis=axis(
            theme,
            "class in the truth",
            tickvals=list(range(len(classes))),
            ticktext=shown[: len(classes)],
            autorange="reversed",
            showgrid=False,
        ),
    )
