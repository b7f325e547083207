"""Maps: settings where X or Y is better, the cost of a miss over the picture, classes read."""

# ruff: noqa: PD011  (the values of a setting's axis are an array)

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, product
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from scipy.ndimage import binary_dilation, binary_erosion, distance_transform_edt

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text
from nvcore.evidence.stability.axes import Axis
from nvcore.evidence.stability.map import StabilityMap
from nvcore.evidence.stability.notes import (
    CRITERIA,
    QUANTITY,
    UNDEFINED,
    settings_text,
    share_text,
    winner_text,
)
from nvcore.figures.marks import cells, click_markers, still_line
from nvcore.figures.style import (
    CLEAR,
    HEADING_PX,
    LOOK,
    ChartLook,
    faded,
    plain,
    system_label,
    which_is_which,
    written,
)
from nvcore.metrics.cost_map import CostMap
from nvcore.settings.objects import Objects, labels_in_order
from nvcore.tables.classes import read_share

INSIDE_PX: Final = (620, 300)
"""Approximate width and height of the map itself."""
NAME_PX: Final = (74, 26)
"""Approximate width and height of a region's name."""
NO_CLASS: Final = "no class"
"""Column of the matches to which the system gives no class."""

Points = list[tuple[float, float]]


def stability_map(stability: StabilityMap, *, theme: Theme) -> go.Figure:
    """Plot the difference between X and Y against one or two settings, coloured by who is better.

    Two settings give a heat map with the line at which the verdict changes. One setting gives a
    curve. The dotted frame is the plausible range. A click selects a setting: `customdata` is the
    cell's flat index for `StabilityMap.settings`.
    """
    look = LOOK[theme]
    if not np.isfinite(stability.difference).any():
        return look.empty(f"The comparison is undefined here: {UNDEFINED[stability.criterion]}.")
    is_map = len(stability.axes) == 2
    if is_map:
        traces = _heat(stability, look)
        x, y = np.meshgrid(*(setting.values for setting in stability.axes), indexing="ij")
        xaxis, yaxis = (_map_axis(setting, look) for setting in stability.axes)
        settings: dict[str, Any] = {"height": 460, "xaxis": xaxis, "yaxis": yaxis}
    else:
        traces = _line(stability, look)
        x, y = stability.axes[0].values, stability.difference
        edge = 1.08 * (float(np.nanmax(np.abs(y))) or 1.0)
        zero: dict[str, Any] = {"zeroline": True, "zerolinecolor": look.muted}
        settings = {
            "height": 320,
            "hovermode": "x",
            "xaxis": _setting_axis(stability.axes[0], look),
            "yaxis": look.axis(QUANTITY[stability.criterion], range=[-edge, edge], **zero),
        }
    places = product(*(setting.values.tolist() for setting in stability.axes))
    cells = zip(places, stability.winner.ravel(), stability.difference.ravel(), strict=True)
    texts = [
        f"{settings_text(stability, at) or 'any setting'}<br>"
        + winner_text(stability.criterion, winner, difference)
        for at, winner, difference in cells
    ]
    n, marked = stability.difference.size, _marked(stability)
    subtitle = count_text(n, "setting")
    if np.isfinite(stability.share_held):
        share = share_text(stability.share_held)
        subtitle += f"; the present verdict holds in {share} of the plausible range (dotted)"
    clicks = click_markers(x.ravel(), y.ravel(), texts, name="settings", customdata=np.arange(n))
    frame: dict[str, Any] = {} if is_map else {"yref": "paper", "y0": 0, "y1": 1}
    frame |= {"type": "rect", "name": "plausible range", "layer": "above"}
    for letter, setting in zip("xy", stability.axes, strict=False):
        low, high = (-0.5, len(setting) - 0.5) if setting.labels else setting.plausible
        frame |= {f"{letter}0": low, f"{letter}1": high}
    return look.draw(
        [*traces, clicks, *(_mark(name, points, look) for name, points in marked.items())],
        title=f"Who is better by {CRITERIA[stability.criterion]}",
        subtitle=subtitle + which_is_which(theme),
        hoverdistance=-1,
        shapes=[{**frame, "line": {"color": look.ink, "width": 1.4, "dash": "dot"}}],
        annotations=_region_names(stability, marked, look) if is_map else None,
        uirevision=f"{stability.plane} {stability.criterion}",
        **settings,
    )


def _heat(stability: StabilityMap, look: ChartLook) -> list[Any]:
    """Return the coloured cells, the line where the verdict turns, and the line of equal alarms."""
    across, up = stability.axes
    values = stability.difference.T  # transposed: rows are drawn upwards
    most = float(np.nanmax(np.abs(values))) or 1.0
    place = {"x": across.values, "y": up.values, "hoverinfo": "skip"}
    cells = go.Heatmap(
        **place,
        z=values,
        zmin=-most,
        zmax=most,
        colorscale=[[0.0, look.y], [0.5, look.grid], [1.0, look.x]],
        name="difference",
        zsmooth=False,
        colorbar=look.colour_bar(QUANTITY[stability.criterion], 12, len=1),
    )
    traces: list[Any] = [cells]
    if not (across.labels or up.labels):
        has_ties = bool((stability.winner == "even").any())
        if has_ties:  # the line goes around them
            is_better = [stability.winner == letter for letter in "xy"]
            values = np.select(is_better, [1.0, -1.0], default=0.0).T
        level = 0.5 if has_ties else 0.0
        turning = go.Contour(
            **place,
            z=values,
            contours={"start": -level, "end": level, "size": 1, "coloring": "none"},
            line={"color": look.ink, "width": 1.6, "smoothing": 0},
            showscale=False,
            name="verdict turns",
            showlegend=True,
        )
        traces.append(turning)
    if len(alarms := _equal_alarms(stability)):
        looks = {"color": look.ink, "width": 2.2, "dash": "dash", "showlegend": None}
        x, y = alarms.T
        traces.append(still_line(x, y, "equal false alarms per frame", **looks))
    return traces


def _line(stability: StabilityMap, look: ChartLook) -> list[Any]:
    """Return the curve over one setting, filled on the side of the better system."""
    along, values = stability.axes[0].values, stability.difference
    filled: dict[str, Any] = {"showlegend": None, "width": 0, "fill": "tozeroy"}
    x_part, y_part = np.maximum(values, 0), np.minimum(values, 0)
    return [
        still_line(along, x_part, "X better", fillcolor=faded(look.x, 0.3), **filled),
        still_line(along, y_part, "Y better", fillcolor=faded(look.y, 0.3), **filled),
        still_line(along, values, "difference", color=look.ink, width=2),
    ]


def _setting_axis(setting: Axis, look: ChartLook, **more: Any) -> dict[str, Any]:
    in_unit = f"{setting.label.removesuffix(')')}, {setting.unit})"
    title = in_unit if setting.unit else setting.label
    return look.axis(title, begins=setting.values[0], **more)


def _map_axis(setting: Axis, look: ChartLook) -> dict[str, Any]:
    before, after = ((setting.values[i + 1] - setting.values[i]) / 2 for i in (0, -2))
    more: dict[str, Any] = {
        "showgrid": False,
        # invisible ticks keep the numbers of the two axes apart in the corner
        "ticks": "outside",
        "ticklen": 8,
        "tickcolor": CLEAR,
        # up to the edges of the outermost cells
        "range": [setting.values[0] - before, setting.values[-1] + after],
    }
    if setting.labels:
        words = [word.replace(" ", "<br>", 1) for word in setting.words]
        more |= {"tickvals": setting.values, "ticktext": words}
    return _setting_axis(setting, look, **more)


def _equal_alarms(stability: StabilityMap) -> np.ndarray:
    """Return threshold pairs within the map that give equal false alarms, float64, shape (n, 2)."""
    line = stability.equal_alarms
    if line is None:
        return np.empty((0, 2))
    pairs = np.column_stack([line.threshold_x, line.threshold_y])
    ends = np.array([[setting.values[0], setting.values[-1]] for setting in stability.axes])
    within: np.ndarray = pairs[((pairs >= ends[:, 0]) & (pairs <= ends[:, 1])).all(axis=1)]
    return within


def _marked(stability: StabilityMap) -> dict[str, Points]:
    """Return the points to mark in the figure, by label.

    A point is two settings on a map, setting and difference on a curve.
    """
    marked = {}
    ends = dict.fromkeys(zip(*(setting.present for setting in stability.axes), strict=True))
    present = stability.present_difference
    if np.isfinite(present):
        marked["as analysed"] = [(*at, present)[:2] for at in ends]
    if (overturn := stability.overturn) is not None:
        marked["nearest that overturns it"] = [(*overturn.place, overturn.difference)[:2]]
    return marked


def _mark(name: str, points: Points, look: ChartLook) -> go.Scatter:
    """Return markers for settings, joined if recordings have their own: the least and greatest."""
    x, y = (list(values) for values in zip(*points, strict=True))
    return still_line(
        x,
        y,
        name,
        mode="markers+lines" if len(x) > 1 else "markers",
        color=look.ink,
        width=3,
        showlegend=None,
        marker={
            "symbol": "circle" if name == "as analysed" else "x",
            "size": 12,
            "color": look.ink,
            "line": {"width": 2, "color": look.surface},
        },
        cliponaxis=False,
    )


def _region_names(
    stability: StabilityMap, marked: dict[str, Points], look: ChartLook
) -> list[dict[str, Any]]:
    """Label each region with the better system's name, so that it reads without colour.

    The label is where the region is widest, clear of markers, the line of equal false alarms and
    the frame of the plausible range.
    """
    across, up = stability.axes
    shape = stability.winner.shape
    awkward = np.hypot(*np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij"))
    # odd, so that a name is centred on a cell
    size = np.ones(
        [
            2 * round(name * n / inside / 2) + 1
            for name, inside, n in zip(NAME_PX, INSIDE_PX, shape, strict=True)
        ]
    )
    cells = [_cell_at(stability, point) for point in chain(*marked.values())]
    is_drawn = np.zeros(shape, dtype=bool)
    for cell in (*cells, *(_cell_at(stability, pair) for pair in _equal_alarms(stability))):
        is_drawn[cell] = True
    is_framed = np.logical_and.outer(*(axis.is_plausible(axis.values) for axis in (across, up)))
    awkward = awkward + 10.0 * binary_dilation(is_drawn, size)
    awkward = awkward + 5.0 * binary_dilation(is_framed & ~binary_erosion(is_framed), size)
    is_roomy = INSIDE_PX[1] / shape[1] >= 3 * NAME_PX[1]  # a name fits above a mark
    names = []
    for winner, words in (("x", "X better"), ("y", "Y better"), ("even", "even")):
        is_inside = stability.winner == winner
        has_room = binary_erosion(is_inside, size)
        # neither a small region nor a narrow stripe of ties between lines has a name
        if is_inside.mean() < 0.02 or (winner == "even" and not has_room.any()):
            continue
        depth = distance_transform_edt(np.pad(is_inside, 1))[1:-1, 1:-1]
        is_deep = has_room if has_room.any() else depth >= 0.7 * depth.max()
        widest = np.where(is_deep, awkward - depth / max(shape), np.inf)
        i, j = (int(place) for place in np.unravel_index(int(np.argmin(widest)), shape))
        place = {"x": float(across.values[i]), "y": float(up.values[j])}
        place["yshift"] = NAME_PX[1] if is_roomy and (i, j) in cells else 0
        back = faded(look.surface, 0.75)
        names.append(written(words, size=13, color=look.ink, bgcolor=back, **place))
    return names


def _cell_at(stability: StabilityMap, point: Sequence[float]) -> tuple[int, ...]:
    """Return the cell nearest to a point of the figure."""
    return tuple(
        int(np.argmin(np.abs(setting.values - value)))
        for setting, value in zip(stability.axes, point, strict=True)
    )


def cost_plot(cost_map: CostMap, *, theme: Theme, objects: Objects) -> go.Figure:
    """Plot the cost of missing a pedestrian, 0 to 1, by lateral position and row of the feet.

    Lower rows are nearer, as in the picture. Places where nobody can stand are empty.
    """
    look, feet = LOOK[theme], objects.say("{feet}")
    costs = go.Contour(
        x=cost_map.centre_px,
        y=cost_map.foot_px,
        z=cost_map.cost.astype(np.float32),  # half the bytes
        zmin=0,
        zmax=1,
        contours={"start": 0.1, "end": 0.9, "size": 0.1},
        line={"width": 0.6, "color": look.surface},
        colorscale=look.loss_scale,
        colorbar=look.colour_bar("", 8, tickvals=[0, 0.5, 1]),
        hovertemplate=feet + " at x %{x:.0f}, row %{y:.0f}: cost %{z:.2f}<extra></extra>",
        name="cost",
    )
    across, down = (
        [float(centres[0]) - half, float(centres[-1]) + half]
        for centres in (cost_map.centre_px, cost_map.foot_px)
        for half in (0.5 * float(centres[1] - centres[0]),)
    )
    return look.draw(
        costs,
        title="Cost of a miss",
        height=190 + HEADING_PX,
        margin={"r": 0},
        xaxis=look.axis("lateral position (px)", range=across, showgrid=False),
        yaxis=look.axis(f"{feet} (row)", range=down[::-1], showgrid=False),
    )


def classes_plot(table: pd.DataFrame, letter: str, name: str, *, theme: Theme) -> go.Figure:
    """Plot the matches of one system: a row for each class of the truth, a column for each read.

    Cells say how many boxes, darker the larger their share of the row. Empty cells have none.
    Correct classes stand in the diagonal.

    Parameters
    ----------
    table
        `nvcore.tables.classes.classes_table`.
    letter, name
        "x" or "y", and the system's name.
    """
    look, rows = LOOK[theme], table[table["system"] == letter]
    if rows.empty:
        return look.empty("No match has a class.")
    has_class = rows["read_class"].notna()
    classes = labels_in_order([*rows["truth_class"], *rows["read_class"][has_class]])
    columns = [*classes, *([] if has_class.all() else [NO_CLASS])]
    place = {label: number for number, label in enumerate(classes)}
    count = np.zeros((len(classes), len(columns)), np.int64)
    read = [place.get(label, len(classes)) for label in rows["read_class"]]
    count[[place[label] for label in rows["truth_class"]], read] = rows["n"].to_numpy(np.int64)
    total = count.sum(axis=1, keepdims=True)
    share = np.divide(count, total, out=np.full(count.shape, np.nan), where=count > 0)
    across = [plain(label) for label in columns]
    down = across[: len(classes)]
    heat = cells(
        share,
        [[f"{n:,}" if n else "" for n in row] for row in count.tolist()],
        x=list(range(len(across))),
        y=list(range(len(down))),
        zmin=0,
        zmax=1,
        colorscale=[(0, look.grid), (1, look.of(letter))],
        customdata=[[[of, to] for to in across] for of in down],
        hovertemplate="%{customdata[0]} read as %{customdata[1]}: %{text} (%{z:.0%} of its "
        "matches)<extra></extra>",
        hoverongaps=False,
    )
    right = read_share(table, letter)
    return look.draw(
        heat,
        title=f"Classes read by {system_label(letter, name)}",
        subtitle=f"{right.n_right:,} of {count_text(right.n, 'match', 'matches')} right",
        height=170 + 30 * len(classes),
        showlegend=False,
        xaxis=look.cells_axis("class read", across, can_zoom=True),
        yaxis=look.cells_axis("class in the truth", down, can_zoom=True, autorange="reversed"),
    )
