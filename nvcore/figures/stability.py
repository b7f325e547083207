"""Stability maps: where X is better, where Y, and where it turns."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import plotly.graph_objects as go
from scipy.ndimage import distance_transform_edt

from nvcore.figures.style import (
    LOOK,
    axis,
    click_markers,
    count_text,
    empty_figure,
    faded,
    layout,
)
from nvcore.palette import Theme
from nvcore.stability import StabilityMap
from nvcore.stability_axes import Axis
from nvcore.stability_words import QUANTITY, UNDEFINED, settings_text, winner_text

MAP_PX: Final = 460
LINE_PX: Final = 320
LEAST_SHARE: Final = 0.02
"""Share of the cells that a region must have to be named in the map."""
DEEP: Final = 0.7
"""Share of a region's greatest depth from which its name may stand there."""
MARKER_ROOM: Final = 0.2
"""Names keep this far from markers, in half widths of the map."""
SYMBOLS: Final = {"as analysed": "circle", "nearest that overturns it": "x"}
ROOM: Final = 0.08
"""Room above and below a line, as a share of its largest difference."""


def stability_map(stability: StabilityMap, *, theme: Theme) -> go.Figure:
    """The difference between X and Y over the settings, in X's colour where X is better.

    Two settings: a heat map with the line at which the verdict turns; one: a curve. The dotted
    frame is the plausible range. A click gives a setting: `customdata` is the cell's flat index
    for `StabilityMap.settings`.
    """
    if not np.isfinite(stability.difference).any():
        return empty_figure(
            f"The comparison is undefined here: {UNDEFINED[stability.criterion]}.", theme=theme
        )
    figure = _line(stability, theme) if len(stability.axes) == 1 else _heat(stability, theme)
    figure.update_layout(uirevision=f"{stability.plane} {stability.criterion}")
    return figure


def _title(stability: StabilityMap) -> dict[str, Any]:
    subtitle = count_text(stability.difference.size, "setting")
    if np.isfinite(stability.share_held):
        share = stability.share_held
        percent = f"{100 * share:.0f}" if share in (0, 1) else f"{min(max(100 * share, 1), 99):.0f}"
        subtitle += f"; the present verdict holds in {percent} % of the plausible range (dotted)"
    names = " and ".join(one.title for one in stability.axes)
    return {"title": f"Verdict by {names}", "subtitle": subtitle}


def _axis_title(one: Axis) -> str:
    return f"{one.title} ({one.unit})" if one.unit else one.title


def _texts(stability: StabilityMap) -> list[str]:
    """What stands at each cell, in flat order."""
    parts = zip(stability.winner.ravel(), stability.difference.ravel(), strict=True)
    return [
        f"{settings_text(stability, cell) or 'any setting'}<br>"
        + winner_text(stability.criterion, winner, difference)
        for cell, (winner, difference) in enumerate(parts)
    ]


def _heat(stability: StabilityMap, theme: Theme) -> go.Figure:
    look = LOOK[theme]
    across, up = stability.axes
    values = stability.difference.T  # rows upwards
    most = float(np.nanmax(np.abs(values))) or 1.0
    scale = [[0.0, look.y], [0.5, look.grid], [1.0, look.x]]
    traces: list[Any] = [
        go.Heatmap(
            x=across.values, y=up.values, z=values, zmin=-most, zmax=most, colorscale=scale,
            name="difference", hoverinfo="skip", zsmooth=False,
            colorbar={
                "title": {"text": QUANTITY[stability.criterion], "side": "right",
                          "font": {"size": 12, "color": look.muted}},
                "tickfont": {"size": 12, "color": look.muted}, "outlinewidth": 0,
                "thickness": 12, "len": 1,
            },
        )
    ]  # fmt: skip
    if not (across.labels or up.labels):
        traces.append(_turning_line(stability, look.ink))
    cell_x, cell_y = np.meshgrid(across.values, up.values, indexing="ij")
    traces.append(
        click_markers(
            x=cell_x.ravel(), y=cell_y.ravel(), name="settings", text=_texts(stability),
            customdata=np.arange(stability.difference.size),
            hovertemplate="%{text}<extra></extra>",
        )
    )  # fmt: skip
    traces += _places(stability, cell_x.ravel(), cell_y.ravel(), theme)
    figure = go.Figure(
        traces,
        layout(
            theme, **_title(stability), height=MAP_PX, hoverdistance=-1,
            xaxis=_map_axis(across, theme), yaxis=_map_axis(up, theme),
        ),
    )  # fmt: skip
    _plausible_frame(figure, stability, theme)
    _name_regions(figure, stability, theme)
    return figure


def _map_axis(one: Axis, theme: Theme) -> dict[str, Any]:
    more: dict[str, Any] = {"showgrid": False, "fixedrange": True}
    if one.labels:
        more |= {"tickvals": one.values, "ticktext": list(one.labels)}
    return axis(theme, _axis_title(one), **more)


def _turning_line(stability: StabilityMap, colour: str) -> go.Contour:
    """Where the difference is 0; around the ties, where there are any."""
    across, up = stability.axes
    has_ties = bool((stability.winner == "even").any())
    code = np.select([stability.winner == "x", stability.winner == "y"], [1.0, -1.0], default=0.0)
    level = 0.5 if has_ties else 0.0
    return go.Contour(
        x=across.values, y=up.values, z=(code if has_ties else stability.difference).T,
        contours={"start": -level, "end": level, "size": 1, "coloring": "none"},
        line={"color": colour, "width": 1.6, "smoothing": 0}, showscale=False, hoverinfo="skip",
        name="verdict turns", showlegend=True,
    )  # fmt: skip


def _places(
    stability: StabilityMap, cell_x: np.ndarray, cell_y: np.ndarray, theme: Theme
) -> list[go.Scatter]:
    """The analysed setting, and the nearest one that overturns the verdict."""
    look = LOOK[theme]
    return [
        go.Scatter(
            x=[cell_x[cell]], y=[cell_y[cell]], mode="markers", name=name, hoverinfo="skip",
            marker={"symbol": SYMBOLS[name], "size": 12, "color": look.ink,
                    "line": {"width": 2, "color": look.surface}}, cliponaxis=False,
        )
        for name, cell in _marked(stability).items()
    ]  # fmt: skip


def _marked(stability: StabilityMap) -> dict[str, int]:
    """Cells that are marked, by what they are called."""
    overturn = stability.overturn
    cells = (stability.present_cell, None if overturn is None else overturn.cell)
    return {name: cell for name, cell in zip(SYMBOLS, cells, strict=True) if cell is not None}


def _plausible_frame(figure: go.Figure, stability: StabilityMap, theme: Theme) -> None:
    sides: dict[str, Any] = {}
    for letter, one in zip("xy", stability.axes, strict=False):
        low, high = (-0.5, len(one) - 0.5) if one.labels else one.plausible
        sides |= {f"{letter}0": low, f"{letter}1": high}
    if len(stability.axes) == 1:
        sides |= {"yref": "paper", "y0": 0, "y1": 1}
    figure.add_shape(
        type="rect", name="plausible range", layer="above",
        line={"color": LOOK[theme].muted, "width": 1.4, "dash": "dot"}, **sides,
    )  # fmt: skip


def _name_regions(figure: go.Figure, stability: StabilityMap, theme: Theme) -> None:
    """Who is better, written where each region is widest: told apart without colour."""
    look = LOOK[theme]
    across, up = stability.axes
    shape = stability.winner.shape
    place = np.stack(np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij"), axis=-1)
    awkward = np.hypot(place[..., 0], place[..., 1])
    for cell in _marked(stability).values():  # a marker stays visible
        apart = np.abs(place - place.reshape(-1, 2)[cell]).max(axis=-1)
        awkward = awkward + 10 * (apart < MARKER_ROOM)
    for winner, said in (("x", "X better"), ("y", "Y better"), ("even", "even")):
        is_inside = stability.winner == winner
        if is_inside.mean() < LEAST_SHARE:
            continue
        depth = distance_transform_edt(np.pad(is_inside, 1))[1:-1, 1:-1]
        widest = np.where(depth >= DEEP * depth.max(), awkward, np.inf)
        i, j = np.unravel_index(int(np.argmin(widest)), depth.shape)
        figure.add_annotation(
            x=float(across.values[i]), y=float(up.values[j]), text=said, showarrow=False,
            font={"size": 13, "color": look.ink}, bgcolor=faded(look.surface, 0.75),
        )  # fmt: skip


def _line(stability: StabilityMap, theme: Theme) -> go.Figure:
    look = LOOK[theme]
    one, values = stability.axes[0], stability.difference
    most = float(np.nanmax(np.abs(values))) or 1.0
    traces: list[Any] = [
        go.Scatter(
            x=one.values, y=part, mode="lines", line={"width": 0}, fill="tozeroy",
            fillcolor=faded(colour, 0.3), hoverinfo="skip", name=name,
        )
        for name, colour, part in (
            ("X better", look.x, np.maximum(values, 0)),
            ("Y better", look.y, np.minimum(values, 0)),
        )
    ]  # fmt: skip
    traces.append(
        go.Scatter(
            x=one.values,
            y=values,
            mode="lines",
            line={"width": 2, "color": look.ink},
            hoverinfo="skip",
            name="difference",
            showlegend=False,
        )
    )
    traces.append(
        click_markers(
            x=one.values,
            y=values,
            name="settings",
            text=_texts(stability),
            customdata=np.arange(values.size),
            hovertemplate="%{text}<extra></extra>",
        )
    )
    traces += _places(stability, one.values, values, theme)
    edge = (1 + ROOM) * most
    figure = go.Figure(
        traces,
        layout(
            theme, **_title(stability), height=LINE_PX, hovermode="x", hoverdistance=-1,
            xaxis=axis(theme, _axis_title(one), fixedrange=True),
            yaxis=axis(
                theme, QUANTITY[stability.criterion], range=[-edge, edge], fixedrange=True,
                zeroline=True, zerolinecolor=look.muted,
            ),
        ),
    )  # fmt: skip
    _plausible_frame(figure, stability, theme)
    return figure
