"""Stability maps: regions of settings where X or Y is better, and the border between them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, product
from typing import Any, Final

import numpy as np
import plotly.graph_objects as go
from scipy.ndimage import binary_dilation, binary_erosion, distance_transform_edt

from nvcore.figures.marks import click_markers, still_line
from nvcore.figures.style import (
    CLEAR,
    LOOK,
    axis,
    begins_at,
    draw,
    empty_figure,
    faded,
    which_is_which,
    write,
)
from nvcore.palette import Theme
from nvcore.stability.axes import Axis
from nvcore.stability.flips import combine_axes
from nvcore.stability.map import StabilityMap
from nvcore.stability.notes import (
    CRITERIA,
    QUANTITY,
    UNDEFINED,
    settings_text,
    share_text,
    winner_text,
)
from nvcore.wording import count_text

MAP_PX: Final = 460
LINE_PX: Final = 320
LEAST_SHARE: Final = 0.02
"""Minimum share of the cells for naming a region in the map."""
DEEP: Final = 0.7
"""Minimum depth of a name's position, as a share of the region's greatest depth."""
INSIDE_PX: Final = (620, 300)
"""Approximate width and height of the map itself."""
NAME_PX: Final = (74, 26)
"""Approximate width and height of a region's name."""
ROOMY_PX: Final = 3 * NAME_PX[1]
"""Minimum height of a cell that can hold a name above a mark."""
EQUAL_ALARMS: Final = "equal false alarms per frame"
SYMBOLS: Final = {"as analysed": "circle", "nearest that overturns it": "x"}
ROOM: Final = 0.08
"""Space above and below a line, as a share of its largest difference."""


def stability_map(stability: StabilityMap, *, theme: Theme) -> go.Figure:
    """Plot the difference between X and Y against one or two settings, coloured by who is better.

    Two settings give a heat map with the line at which the verdict changes. One setting gives a
    curve. The dotted frame is the plausible range. A click selects a setting: `customdata` is the
    cell's flat index for `StabilityMap.settings`.
    """
    if not np.isfinite(stability.difference).any():
        return empty_figure(
            f"The comparison is undefined here: {UNDEFINED[stability.criterion]}.", theme=theme
        )
    figure = _line(stability, theme) if len(stability.axes) == 1 else _heat(stability, theme)
    figure.update_layout(uirevision=f"{stability.plane} {stability.criterion}")
    return figure


def _title(stability: StabilityMap, theme: Theme) -> dict[str, Any]:
    subtitle = count_text(stability.difference.size, "setting")
    if np.isfinite(stability.share_held):
        share = share_text(stability.share_held)
        subtitle += f"; the present verdict holds in {share} of the plausible range (dotted)"
    return {
        "title": f"Who is better by {CRITERIA[stability.criterion]}",
        "subtitle": subtitle + which_is_which(theme),
    }


def _axis_title(setting: Axis) -> str:
    in_unit = f"{setting.label.removesuffix(')')}, {setting.unit})"
    return (in_unit if setting.unit else setting.label) + begins_at(setting.values[0])


def _texts(stability: StabilityMap) -> list[str]:
    """Return the hover text of each cell, in flat order."""
    places = product(*(setting.values.tolist() for setting in stability.axes))
    parts = zip(places, stability.winner.ravel(), stability.difference.ravel(), strict=True)
    return [
        f"{settings_text(stability, at) or 'any setting'}<br>"
        + winner_text(stability.criterion, winner, difference)
        for at, winner, difference in parts
    ]


def _heat(stability: StabilityMap, theme: Theme) -> go.Figure:
    look = LOOK[theme]
    across, up = stability.axes
    values = stability.difference.T  # transposed: rows are drawn upwards
    most = float(np.nanmax(np.abs(values))) or 1.0
    scale = [[0.0, look.y], [0.5, look.grid], [1.0, look.x]]
    font = {"size": 12, "color": look.muted}
    title = {"text": QUANTITY[stability.criterion], "side": "right", "font": font}
    bar = {"title": title, "tickfont": font, "outlinewidth": 0, "thickness": 12, "len": 1}
    traces: list[Any] = [
        go.Heatmap(
            x=across.values,
            y=up.values,
            z=values,
            zmin=-most,
            zmax=most,
            colorscale=scale,
            name="difference",
            hoverinfo="skip",
            zsmooth=False,
            colorbar=bar,
        )
    ]
    if not (across.labels or up.labels):
        traces.append(_turning_line(stability, look.ink))
    if len(_equal_alarms(stability)):
        x, y = _equal_alarms(stability).T
        line = {"width": 2.2, "color": look.ink, "dash": "dash"}
        traces.append(still_line(x, y, EQUAL_ALARMS, showlegend=None, line=line))
    cells = np.meshgrid(across.values, up.values, indexing="ij")
    traces.append(_clicks(stability, *(cell.ravel() for cell in cells)))
    traces += _places(stability, theme)
    figure = draw(
        traces,
        theme,
        **_title(stability, theme),
        height=MAP_PX,
        hoverdistance=-1,
        xaxis=_map_axis(across, theme),
        yaxis=_map_axis(up, theme),
    )
    _plausible_frame(figure, stability, theme)
    _name_regions(figure, stability, theme)
    return figure


def _clicks(stability: StabilityMap, x: np.ndarray, y: np.ndarray) -> go.Scatter:
    """Return an invisible, clickable marker for each cell, in flat order."""
    return click_markers(
        x, y, _texts(stability), name="settings", customdata=np.arange(stability.difference.size)
    )


def _equal_alarms(stability: StabilityMap) -> np.ndarray:
    """Return threshold pairs within the map that give equal false alarms, float64, shape (n, 2).

    n is 0 if there are none.
    """
    line = stability.equal_alarms
    if line is None:
        return np.empty((0, 2))
    pairs = np.column_stack([line.threshold_x, line.threshold_y])
    ends = np.array([[setting.values[0], setting.values[-1]] for setting in stability.axes])
    within: np.ndarray = pairs[((pairs >= ends[:, 0]) & (pairs <= ends[:, 1])).all(axis=1)]
    return within


def _map_axis(setting: Axis, theme: Theme) -> dict[str, Any]:
    # invisible ticks keep the numbers of the two axes apart in the corner
    more: dict[str, Any] = {
        "showgrid": False,
        "fixedrange": True,
        "ticks": "outside",
        "ticklen": 8,
        "tickcolor": CLEAR,
    }
    before, after = ((setting.values[i + 1] - setting.values[i]) / 2 for i in (0, -2))
    more["range"] = [setting.values[0] - before, setting.values[-1] + after]  # the outermost cells
    if setting.labels:
        words = [word.replace(" ", "<br>", 1) for word in setting.words]
        more |= {"tickvals": setting.values, "ticktext": words}
    return axis(theme, _axis_title(setting), **more)


def _turning_line(stability: StabilityMap, colour: str) -> go.Contour:
    """Return the line at which the difference is 0. Ties are enclosed."""
    across, up = stability.axes
    has_ties = bool((stability.winner == "even").any())
    code = np.select([stability.winner == "x", stability.winner == "y"], [1.0, -1.0], default=0.0)
    level = 0.5 if has_ties else 0.0
    return go.Contour(
        x=across.values,
        y=up.values,
        z=(code if has_ties else stability.difference).T,
        contours={"start": -level, "end": level, "size": 1, "coloring": "none"},
        line={"color": colour, "width": 1.6, "smoothing": 0},
        showscale=False,
        hoverinfo="skip",
        name="verdict turns",
        showlegend=True,
    )


def _places(stability: StabilityMap, theme: Theme) -> list[go.Scatter]:
    """Return markers for the analysed settings and for the nearest ones that overturn the verdict.

    If recordings have their own settings, a line joins the least and the greatest of them.
    """
    look = LOOK[theme]
    rim = {"width": 2, "color": look.surface}
    traces = []
    for name, points in _marked(stability).items():
        x, y = (list(values) for values in zip(*points, strict=True))
        traces.append(
            go.Scatter(
                x=x,
                y=y,
                mode="markers+lines" if len(x) > 1 else "markers",
                name=name,
                hoverinfo="skip",
                line={"width": 3, "color": look.ink},
                marker={"symbol": SYMBOLS[name], "size": 12, "color": look.ink, "line": rim},
                cliponaxis=False,
            )
        )
    return traces


def _marked(stability: StabilityMap) -> dict[str, list[tuple[float, float]]]:
    """Return the points to mark in the figure, by label."""
    marked = {}
    ends = list(dict.fromkeys(zip(*(setting.present for setting in stability.axes), strict=True)))
    if np.isfinite(stability.present_difference):
        marked["as analysed"] = [_point(at, stability.present_difference) for at in ends]
    if (overturn := stability.overturn) is not None:
        marked["nearest that overturns it"] = [_point(overturn.place, overturn.difference)]
    return marked


def _point(at: tuple[float, ...], difference: float) -> tuple[float, float]:
    """Convert settings to figure coordinates: both on a map, setting and difference on a curve."""
    return (at[0], at[1] if len(at) > 1 else difference)


def _plausible_frame(figure: go.Figure, stability: StabilityMap, theme: Theme) -> None:
    sides: dict[str, Any] = {}
    for letter, setting in zip("xy", stability.axes, strict=False):
        low, high = (-0.5, len(setting) - 0.5) if setting.labels else setting.plausible
        sides |= {f"{letter}0": low, f"{letter}1": high}
    if len(stability.axes) == 1:
        sides |= {"yref": "paper", "y0": 0, "y1": 1}
    line = {"color": LOOK[theme].ink, "width": 1.4, "dash": "dot"}
    figure.add_shape(type="rect", name="plausible range", layer="above", line=line, **sides)


def _name_regions(figure: go.Figure, stability: StabilityMap, theme: Theme) -> None:
    """Label each region with the better system's name, so that it reads without colour.

    The label is where the region is widest.
    """
    look = LOOK[theme]
    across, up = stability.axes
    shape = stability.winner.shape
    place = np.stack(np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij"), axis=-1)
    awkward = np.hypot(place[..., 0], place[..., 1])
    # odd, so that a name is centred on a cell
    size = [
        2 * round(name * n / inside / 2) + 1
        for name, inside, n in zip(NAME_PX, INSIDE_PX, shape, strict=True)
    ]
    marked = {_cell_at(stability, point) for point in chain(*_marked(stability).values())}
    is_roomy = INSIDE_PX[1] / shape[1] >= ROOMY_PX
    for obstacle, weight in _obstacles(stability):
        awkward = awkward + weight * binary_dilation(obstacle, np.ones(size))
    for winner, words in (("x", "X better"), ("y", "Y better"), ("even", "even")):
        is_inside = stability.winner == winner
        if is_inside.mean() < LEAST_SHARE:
            continue
        has_room = binary_erosion(is_inside, np.ones(size))
        if winner == "even" and not has_room.any():
            continue  # a narrow stripe between lines
        depth = distance_transform_edt(np.pad(is_inside, 1))[1:-1, 1:-1]
        is_deep = has_room if has_room.any() else depth >= DEEP * depth.max()
        widest = np.where(is_deep, awkward - depth / max(shape), np.inf)
        i, j = (int(place) for place in np.unravel_index(int(np.argmin(widest)), depth.shape))
        x, y = float(across.values[i]), float(up.values[j])
        back = faded(look.surface, 0.75)
        shift = NAME_PX[1] if is_roomy and (i, j) in marked else 0
        write(figure, words, size=13, color=look.ink, x=x, y=y, yshift=shift, bgcolor=back)


def _obstacles(stability: StabilityMap) -> list[tuple[np.ndarray, float]]:
    """Return masks of cells that labels should not hide, bool of the map's shape, with weights.

    These are markers, the line of equal false alarms, and the frame of the plausible range.
    """
    is_drawn = np.zeros(stability.winner.shape, dtype=bool)
    for point in chain(*_marked(stability).values(), _equal_alarms(stability).tolist()):
        is_drawn[_cell_at(stability, point)] = True
    framed = combine_axes(
        [setting.is_plausible(setting.values) for setting in stability.axes], np.logical_and
    )
    return [(is_drawn, 10.0), (framed & ~binary_erosion(framed), 5.0)]


def _cell_at(stability: StabilityMap, point: Sequence[float]) -> tuple[int, ...]:
    """Return the cell nearest to a point of the figure."""
    return tuple(
        int(np.argmin(np.abs(setting.values - value)))
        for setting, value in zip(stability.axes, point, strict=True)
    )


def _line(stability: StabilityMap, theme: Theme) -> go.Figure:
    look = LOOK[theme]
    setting, values = stability.axes[0], stability.difference
    most = float(np.nanmax(np.abs(values))) or 1.0
    traces: list[Any] = [
        still_line(
            setting.values,
            part,
            name,
            showlegend=None,
            line={"width": 0},
            fill="tozeroy",
            fillcolor=faded(colour, 0.3),
        )
        for name, colour, part in (
            ("X better", look.x, np.maximum(values, 0)),
            ("Y better", look.y, np.minimum(values, 0)),
        )
    ]
    line = {"width": 2, "color": look.ink}
    traces.append(still_line(setting.values, values, "difference", line=line))
    traces.append(_clicks(stability, setting.values, values))
    traces += _places(stability, theme)
    edge = (1 + ROOM) * most
    zero = {"zeroline": True, "zerolinecolor": look.muted, "fixedrange": True}
    figure = draw(
        traces,
        theme,
        **_title(stability, theme),
        height=LINE_PX,
        hovermode="x",
        hoverdistance=-1,
        xaxis=axis(theme, _axis_title(setting), fixedrange=True),
        yaxis=axis(theme, QUANTITY[stability.criterion], range=[-edge, edge], **zero),
    )
    _plausible_frame(figure, stability, theme)
    return figure
