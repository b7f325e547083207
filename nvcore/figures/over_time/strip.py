"""A strip for each recording: when the worse system loses how much; where to look first."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import click_markers
from nvcore.figures.style import (
    LOOK,
    axis,
    draw,
    empty_figure,
    loss_scale,
    plain,
    rows_axis,
    which_is_which,
)
from nvcore.palette import Theme
from nvcore.tables.loss_strip import LossStrip
from nvcore.wording import count_text

ROW_PX: Final = 22
NARROW_ROW_PX: Final = 15
FEW: Final = 20
"""Recordings up to which rows are not narrow."""
BAR_PX: Final = (80, 220)
"""Least and largest length of the colour bar."""
SCALE_PX: Final = 76
"""Width of the colour bar with its labels."""
MAX_CLICKS: Final = 400
"""Places that can be clicked, over all strips; the browser draws a marker for each."""
LEAST_TOP: Final = 0.2
"""Least upper end of the colour scale, so that trifles look small."""


def loss_strip_plot(result: Result, strip: LossStrip, *, theme: Theme) -> go.Figure:
    """One row for each recording, the worst on top; the stronger the colour, the more is lost.

    The colour is the largest loss ``1 - M`` of either system in that bin of time. A click gives the
    frame in which it stands: `customdata` is its row in ``dataset.frames``.

    Parameters
    ----------
    strip
        `nvcore.tables.loss_strip.loss_strip` of the result.
    """
    n_strips, n_bins = strip.loss.shape
    if not n_strips:
        return empty_figure("There is no evaluated frame.", theme=theme)
    font = {"size": 12, "color": LOOK[theme].muted}
    bar = {"title": {"text": "loss", "side": "top", "font": font}, "tickfont": font}
    strips_px = n_strips * (ROW_PX if n_strips <= FEW else NARROW_ROW_PX)
    length_px = float(np.clip(strips_px, *BAR_PX))
    bar |= {"outlinewidth": 0, "thickness": 12, "nticks": 4}
    bar |= {"lenmode": "pixels", "len": length_px, "y": 1, "yanchor": "top"}
    top = max(LEAST_TOP, float(np.ceil(np.nanmax(strip.loss) * 5 - 1e-9) / 5))
    heat = go.Heatmap(
        x0=0.5 * strip.bin_s,
        dx=strip.bin_s,
        y=np.arange(n_strips),
        z=strip.loss.astype(np.float32),  # half the bytes
        zmin=0,
        zmax=top,
        colorscale=loss_scale(theme),
        colorbar=bar,
        xgap=0,
        ygap=3 if n_strips <= FEW else 2,
        hoverinfo="skip",
        hoverongaps=False,
        name="loss",
    )
    names = result.dataset.recordings["name"].to_numpy()[strip.recording]
    end_s = n_bins * strip.bin_s
    extent = count_text(strip.n_recordings, "recording")
    if strip.n_recordings > n_strips:
        extent += f", the {n_strips} in which most is lost drawn"
    if n_strips > 1:
        extent += ", most lost per minute on top"
    return draw(
        [heat, _clicks(result, strip)],
        theme,
        title="Where to look first",
        subtitle=f"{extent}; colour: the worse system's largest loss "
        f"in each {strip.bin_s:.3g} s{which_is_which(theme)}",
        height=132 + strips_px,
        margin={"r": SCALE_PX},
        hoverdistance=-1,
        showlegend=False,
        xaxis=axis(theme, "time (s)", range=[0, end_s], showgrid=False),
        yaxis=rows_axis(
            theme,
            [plain(name, max_length=18) for name in names],
            fixedrange=True,
            showgrid=False,
        ),
    )


def _clicks(result: Result, strip: LossStrip) -> Any:
    """Invisible markers: Plotly reports no clicks in a heat map. Each is at the worst bin near it.

    Neighbouring bins share one where there are more than `MAX_CLICKS`.
    """
    n_strips, n_bins = strip.loss.shape
    stride = max(1, -(-n_strips * n_bins // MAX_CLICKS))
    n_groups = -(-n_bins // stride)
    padded = np.full((n_strips, n_groups * stride), -1.0)
    padded[:, :n_bins] = np.nan_to_num(strip.loss, nan=-1.0)
    groups = padded.reshape(n_strips, n_groups, stride)
    worst = groups.argmax(axis=2) + stride * np.arange(n_groups)
    place, group = np.nonzero(groups.max(axis=2) >= 0)
    bins = worst[place, group]
    rows = strip.row[place, bins]
    frames = result.dataset.frames
    names = result.dataset.recordings["name"].to_numpy()[strip.recording]
    labels = np.array([plain(name) for name in names], dtype=object)[place]
    text = [
        f"{label}, frame {frame}, {second:.2f} s<br>similarity X {value_x:.2f}   Y {value_y:.2f}"
        for label, frame, second, value_x, value_y in zip(
            labels,
            frames["frame"].to_numpy()[rows],
            frames["time_s"].to_numpy()[rows],
            result.x.similarity[rows],
            result.y.similarity[rows],
            strict=True,
        )
    ]
    middles = (bins + 0.5) * strip.bin_s
    return click_markers(middles, place.astype(float), text, customdata=rows, name="frames")
