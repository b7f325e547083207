"""Figure of the report's intervals, and figures and Plotly for a page that works offline."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Hashable, Mapping
from functools import cache
from html import unescape
from textwrap import wrap
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from nvcore.common.palette import Theme
from nvcore.common.wording import difference, minus
from nvcore.comparison.measures.table import evidence_form, inference_of
from nvcore.figures.style import LOOK, ChartLook, plain, take_heading, which_is_which, write
from nvcore.report.tiles import REACH

INTERVAL_PX: Final = 56
"""Height of a measure's row with an interval."""
WORDS_PX: Final = 48
"""Height of a measure's row without an interval."""
STRIP_PX: Final = (6, 28)
"""Top and bottom of the axis within its row."""
WORDS_SHARE: Final = 0.47
"""Share of the width for the words left of the axes."""
LINE: Final = 38
"""Characters in a line of these words."""
MARGIN_PX: Final = (62, 16)
"""Margins above and below the rows."""


@cache
def packed_plotly() -> str:
    """Return Plotly's JavaScript, compressed, in base64: the page unpacks it."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode()


def heading_apart(figure: go.Figure) -> tuple[go.Figure, str, str]:
    """Return a figure without heading, its title and its subtitle, which wrap on a page."""
    apart = go.Figure(figure)
    title, subtitle = map(unescape, take_heading(apart))
    return apart, title, subtitle


def figure_json(figure: go.Figure) -> str:
    """Return a figure as JSON that cannot end the ``script`` element that it is in."""
    # the standard library's encoder writes the same text on every machine
    text = json.dumps(json.loads(figure.to_json(engine="json")), separators=(",", ":"))
    for sign, escape in (("<", "\\u003c"), (">", "\\u003e"), ("&", "\\u0026")):
        text = text.replace(sign, escape)
    return text


def interval_plot(evidence: pd.DataFrame, theme: Theme = "light") -> go.Figure:
    """Draw the difference X - Y of every measure with its 95 % interval, each on its own axis.

    Right of the line X is better in all of them: where less is better, the axis runs backwards. A
    measure without interval has its difference in words and no place on an axis, because nothing
    shows whether the difference is large or small.

    Parameters
    ----------
    evidence
        `nvcore.evidence.measures.significance_table`; shares are drawn in percentage points.
    """
    look = LOOK[theme]
    defined = evidence[np.isfinite(evidence["difference"])]
    if defined.empty:
        return look.empty("No measure is defined for both systems.")
    has_interval = np.isfinite(defined["low"].to_numpy()) & np.isfinite(defined["high"].to_numpy())
    heights = np.where(has_interval, INTERVAL_PX, WORDS_PX)
    ends = np.cumsum(heights)
    total = float(ends[-1])
    place = {"x": 0, "xref": "paper", "xanchor": "left", "yref": "paper", "yanchor": "top"}
    figure, n_axes = go.Figure(), 0
    for row, top, has_ends in zip(
        defined.to_dict("records"), (ends - heights).tolist(), has_interval.tolist(), strict=True
    ):
        form = evidence_form(row["figure"])
        lines = [plain(line, max_length=LINE) for line in wrap(f"{row['label']}:", LINE)]
        text = f"{'<br>'.join(lines)} <b>{minus(difference(row['difference'], 0, form))}</b>"
        if has_ends:
            domain = [1 - (top + edge) / total for edge in STRIP_PX[::-1]]
            n_axes += 1
            _add_axis(figure, row, look, n_axes, domain)
        else:
            text += " (no interval can be given)"
        y, color = 1 - (top + 4) / total, look.ink
        write(figure, text, size=12, color=color, y=y, align="left", **place)
    about = "every axis has its own scale; right of the line X is better, left of it Y"
    axes: dict[str, Any] = {}
    if not n_axes:  # Plotly would draw its own
        about = "too few data for any interval"
        axes = {name: {"visible": False} for name in ("xaxis", "yaxis")}
    above, below = MARGIN_PX
    looks = look.layout(
        title="Differences X − Y with 95 % intervals",
        subtitle=about + which_is_which(theme),
        height=int(above + total + below),
        showlegend=False,
        margin={"l": 24, "r": 24, "t": above, "b": below},
        **axes,
    )
    return figure.update_layout(looks)


def _add_axis(
    figure: go.Figure, row: Mapping[Hashable, Any], look: ChartLook, n: int, domain: list[float]
) -> None:
    """Add the interval and the difference of a measure, on axes of their own."""
    key = str(n) if n > 1 else ""
    is_share = evidence_form(row["figure"]).endswith("%")
    unit, suffix = (100.0, " pp") if is_share else (1.0, "")
    low, high, middle = (unit * row[name] for name in ("low", "high", "difference"))
    least = inference_of(row["figure"]).scale.least_reach
    reach = max(REACH * max(abs(low), abs(high), abs(middle)), least)
    sign = 1 if row["better"] == "higher" else -1
    gain = sign * middle
    better = look.x if gain > 0 else look.y if gain < 0 else look.muted
    of, line = {"xaxis": f"x{key}", "yaxis": f"y{key}"}, {"color": look.muted, "width": 3}
    marker = {"color": better, "size": 12, "symbol": "circle"}
    x_axis = look.axis(
        range=[-sign * reach, sign * reach],
        nticks=5,
        zeroline=True,
        zerolinewidth=1.5,
        zerolinecolor=look.muted,
        domain=[WORDS_SHARE, 1],
        anchor=f"y{key}",
        ticksuffix=suffix,
    )
    y_axis = {"visible": False, "range": [-1, 1], "fixedrange": True, "domain": domain}
    y_axis["anchor"] = f"x{key}"
    figure.add_scatter(x=[low, high], y=[0, 0], mode="lines", hoverinfo="skip", line=line, **of)
    figure.add_scatter(x=[middle], y=[0], mode="markers", hoverinfo="x", marker=marker, **of)
    figure.update_layout({f"xaxis{key}": x_axis, f"yaxis{key}": y_axis})
