"""Paired points: a measure of X against Y for each recording, the largest difference on top."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import click_markers, marks, still_line, system_marker, with_gaps
from nvcore.figures.style import (
    LOOK,
    axis,
    begins_at,
    draw,
    empty_figure,
    plain,
    rows_axis,
    system_label,
)
from nvcore.measures.entry import HIGHER
from nvcore.measures.table import measure_of
from nvcore.palette import Theme
from nvcore.wording import count_text

ByRecording = Literal["mean_similarity", "saliency"]

MAX_RECORDINGS: Final = 40
"""Recordings drawn: those with the largest differences."""
ROW_PX: Final = 24
MARGIN: Final = 0.03
"""Room beside the points, as a share of the axis."""


@dataclass(frozen=True)
class _MeasureAxis:
    """How a measure is drawn; the axis shows `least` at least, so that small gains look small."""

    title: str
    axis_title: str
    least: tuple[float, float]


AXES: Final[dict[ByRecording, _MeasureAxis]] = {
    "mean_similarity": _MeasureAxis(
        "Similarity by recording", "mean similarity (1 = perfect)", (0.5, 1.0)
    ),
    "saliency": _MeasureAxis(
        "Saliency by recording", "saliency (s, 0 = nothing to notice)", (0.0, 1.0)
    ),
}


def recordings_plot(
    recordings: pd.DataFrame,
    names: tuple[str, str],
    *,
    theme: Theme,
    measure: ByRecording = "mean_similarity",
) -> go.Figure:
    """X and Y joined by a line for each recording; `customdata` is the recording's row.

    The more X is better, the higher a recording stands; the subtitle says in how many it is better.

    Parameters
    ----------
    recordings
        `nvcore.tables.result.recordings_table`, or rows of it with the same index.
    names
        Names of X and Y.
    measure
        ``mean_similarity`` (1 is best) or ``saliency`` (0 is best).
    """
    look = AXES[measure]
    x, y = (recordings[f"{measure}_{letter}"].to_numpy(dtype=float) for letter in "xy")
    defined = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if not len(defined):
        return empty_figure("There is no recording to compare.", theme=theme)
    gain = (x - y) if measure_of(measure).better == HIGHER else (y - x)
    largest = defined[np.argsort(-np.abs(gain[defined]), kind="stable")][:MAX_RECORDINGS]
    largest = largest[np.argsort(-gain[largest], kind="stable")]
    labels = [plain(name, max_length=24) for name in recordings["recording"].to_numpy()[largest]]
    place = np.arange(len(largest), dtype=float)
    rows = recordings.index.to_numpy()[largest]
    text = [
        f"{label}<br>X {value_x:.3f}   Y {value_y:.3f}   X − Y {value_x - value_y:+.3f}"
        for label, value_x, value_y in zip(labels, x[largest], y[largest], strict=True)
    ]
    values = np.concatenate([x[largest], y[largest]])
    low, high = min(look.least[0], values.min()), max(look.least[1], values.max())
    margin = MARGIN * (high - low)
    start = low - margin
    traces = [
        still_line(
            with_gaps(x[largest], y[largest]),
            with_gaps(place, place),
            "difference",
            line={"width": 3, "color": LOOK[theme].pale},
        )
    ]
    for letter, name, values in (("x", names[0], x), ("y", names[1], y)):
        label, marker = system_label(letter, name), system_marker(letter, 11, theme)
        traces.append(
            marks(values[largest], place, text, customdata=rows, name=label, marker=marker)
        )
    middle = (x[largest] + y[largest]) / 2
    traces.append(click_markers(middle, place, text, customdata=rows, name="recordings"))
    extent = count_text(len(defined), "recording")
    has_all = len(defined) == len(largest)
    if not has_all:
        extent += f", the {len(largest)} that differ most drawn"
    if len(defined) > 1:
        n_x, n_y = int((gain[defined] > 0).sum()), int((gain[defined] < 0).sum())
        extent += f"; X is better in {n_x:,}, Y in {n_y:,}"
        extent += "; best for X on top" if has_all else ""  # no room for both
    return draw(
        traces,
        theme,
        title=look.title,
        subtitle=extent,
        height=150 + ROW_PX * len(largest),
        hoverdistance=-1,
        xaxis=axis(theme, look.axis_title + begins_at(start), range=[start, high + margin]),
        yaxis=rows_axis(theme, labels, tickvals=place, fixedrange=True),
    )
