"""A figure that only the report has, and Plotly for a page that works offline."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Hashable, Mapping, Sequence
from functools import cache
from html import unescape
from textwrap import wrap
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from nvcore.figures.style import (
    LOOK,
    axis,
    empty_figure,
    layout,
    plain,
    take_heading,
    which_is_which,
)
from nvcore.measures.table import evidence_form, inference_of
from nvcore.palette import Theme
from nvcore.report.tiles import REACH
from nvcore.wording import difference, minus

INTERVAL_PX: Final = 56
WORDS_PX: Final = 48
"""Height of a measure's row with an interval, and without."""
STRIP_PX: Final = (6, 28)
"""Top and bottom of the axis within its row."""
WORDS_SHARE: Final = 0.47
"""Share of the width for the words left of the axes."""
LINE: Final = 38
"""Characters in a line of them."""
MARGIN_PX: Final = (62, 16)
"""Above and below the rows."""


@cache
def packed_plotly() -> str:
    """Plotly's JavaScript, compressed, in base64: the page unpacks it."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode()


def heading_apart(figure: go.Figure) -> tuple[go.Figure, str, str]:
    """The figure without heading, its title and its subtitle: as text of the page they wrap."""
    apart = go.Figure(figure)
    title, subtitle = map(unescape, take_heading(apart))
    return apart, title, subtitle


def figure_json(figure: go.Figure) -> str:
    """The figure as JSON that is safe inside a ``script`` element: it cannot end the element."""
    # the standard library's encoder writes the same text on every machine
    text = json.dumps(json.loads(figure.to_json(engine="json")), separators=(",", ":"))
    for sign, escape in (("<", "\\u003c"), (">", "\\u003e"), ("&", "\\u0026")):
        text = text.replace(sign, escape)
    return text


def interval_plot(evidence: pd.DataFrame, theme: Theme = "light") -> go.Figure:
    """Difference X - Y of every measure with its 95 % interval, each on an axis of its own.

    Right of the line X is better in all of them: where less is better, the axis runs backwards. A
    measure without interval has its difference in words and no place on an axis, because nothing
    shows whether the difference is large or small.

    Parameters
    ----------
    evidence
        `nvcore.evidence.measures.significance_table`; shares are drawn in percentage points.
    """
    defined = evidence[np.isfinite(evidence["difference"])]
    if defined.empty:
        return empty_figure("No measure is defined for both systems.", theme=theme)
    has_interval = np.isfinite(defined["low"].to_numpy()) & np.isfinite(defined["high"].to_numpy())
    heights = np.where(has_interval, INTERVAL_PX, WORDS_PX)
    ends = np.cumsum(heights)
    total = float(ends[-1])
    figure = go.Figure()
    for row, top, has_ends in zip(
        defined.to_dict("records"), (ends - heights).tolist(), has_interval.tolist(), strict=True
    ):
        form = evidence_form(row["figure"])
        lines = [plain(line, max_length=LINE) for line in wrap(f"{row['label']}:", LINE)]
        text = f"{'<br>'.join(lines)} <b>{minus(difference(row['difference'], 0, form))}</b>"
        if has_ends:
            _add_axis(
                figure, row, form, theme, [1 - (top + edge) / total for edge in STRIP_PX[::-1]]
            )
        else:
            text += " (no interval can be given)"
        figure.add_annotation(
            text=text,
            x=0,
            xref="paper",
            xanchor="left",
            y=1 - (top + 4) / total,
            yref="paper",
            yanchor="top",
            showarrow=False,
            align="left",
            font={"size": 12, "color": LOOK[theme].ink},
        )
    sides = "every axis has its own scale; right of the line X is better, left of it Y"
    above, below = MARGIN_PX
    # without any axis Plotly would draw its own
    no_axes = (
        {} if has_interval.any() else {"xaxis": {"visible": False}, "yaxis": {"visible": False}}
    )
    figure.update_layout(
        layout(
            theme,
            title="Differences X − Y with 95 % intervals",
            subtitle=(sides if has_interval.any() else "too few data for any interval")
            + which_is_which(theme),
            height=int(above + total + below),
            showlegend=False,
            margin={"l": 24, "r": 24, "t": above, "b": below},
            **no_axes,
        )
    )
    return figure


def _add_axis(
    figure: go.Figure,
    row: Mapping[Hashable, Any],
    form: str,
    theme: Theme,
    domain: Sequence[float],
) -> None:
    """The interval and the difference of a measure."""
    look: Any = LOOK[theme]
    number = sum(trace.mode == "markers" for trace in figure.data) + 1
    key = str(number) if number > 1 else ""
    is_share = form.endswith("%")
    low, high, middle = (
        (100.0 if is_share else 1.0) * row[name] for name in ("low", "high", "difference")
    )
    least = inference_of(row["figure"]).scale.least_reach
    reach = max(REACH * max(abs(low), abs(high), abs(middle)), least)
    sign = 1 if row["better"] == "higher" else -1
    axes = {"xaxis": f"x{key}", "yaxis": f"y{key}"}
    line = {"color": look.muted, "width": 3}
    figure.add_scatter(x=[low, high], y=[0, 0], mode="lines", hoverinfo="skip", **axes, line=line)
    gain = sign * middle
    better = look.x if gain > 0 else look.y if gain < 0 else look.muted
    marker = {"color": better, "size": 12, "symbol": "circle"}
    figure.add_scatter(x=[middle], y=[0], mode="markers", hoverinfo="x", **axes, marker=marker)
    x_axis = axis(
        theme,
        range=[-sign * reach, sign * reach],
        fixedrange=True,
        nticks=5,
        zeroline=True,
        zerolinewidth=1.5,
        zerolinecolor=look.muted,
        domain=[WORDS_SHARE, 1],
        anchor=f"y{key}",
        ticksuffix=" pp" if is_share else "",
    )
    y_axis = {
        "visible": False,
        "range": [-1, 1],
        "fixedrange": True,
        "domain": list(domain),
        "anchor": f"x{key}",
    }
    figure.update_layout({f"xaxis{key}": x_axis, f"yaxis{key}": y_axis})
