"""Venn diagram: circles, counts, severity of failures, and a mark for each encounter."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import click_markers, marks
from nvcore.figures.style import (
    EDGE_PX,
    HIDDEN_AXIS,
    LOOK,
    ChartLook,
    draw,
    empty_figure,
    faded,
    plain,
    written,
)
from nvcore.figures.venn.circles import Circles, Frame
from nvcore.figures.venn.labels import BASE_PX, Label, LabelLine, Labels, anchor_of
from nvcore.figures.venn.plan import GAP, IN_CIRCLES, REGIONS, VennPlan, plan_counts, plan_marks
from nvcore.metrics.venn import Venn
from nvcore.objects import Objects
from nvcore.palette import Theme
from nvcore.schema import CATEGORY_WORDS, Category
from nvcore.wording import count_text

MOST_MARKS: Final = 150
"""Maximum number of encounters for drawing a mark for each."""
HEIGHT_PX: Final = 342
BELOW_PX: Final = 24
"""Space below the frame for the number of distant encounters."""
GRID: Final = (36, 22)
"""Number of clickable points, across and down."""
CLICK_PX: Final = 8
"""Size of a clickable point."""
AREAS: Final = {
    "circle": 1.0,
    "diamond": 0.96,
    "pentagon": 1.149,
    "cross": 1.279,
    "star": 1.195,
    "square": 0.886,
    "circle-open": 1.0,
}
"""Sizes that give symbols the same area."""
FAILING: Final = {
    Category.BOTH: "xy",
    Category.X_ONLY: "yx",
    Category.Y_ONLY: "xy",
    Category.NEITHER: "xy",
}
"""Systems whose failures a region's severity counts, the system with a failed detection first."""


def venn_figure(
    venn: Venn,
    names: tuple[str, str],
    *,
    theme: Theme,
    objects: Objects,
    encounters: pd.DataFrame | None = None,
) -> go.Figure:
    """Plot encounters by the systems that detect them, with the severity of failures.

    A click on a region gives its category as `customdata`. A click on a mark gives the most
    informative row of the frames table.

    Parameters
    ----------
    names
        Names of X and Y.
    encounters
        Table of `nvcore.tables.encounters.severity.weighed_encounters`. Up to 150 encounters get a
        mark each, with an area by the larger severity. None: counts only.

    References
    ----------
    Paper 11-0360, figures 1 and 2.
    """
    if venn.n_near == 0:
        text = f"No {objects.singular} came near enough to count."
        if venn.distant:
            text += f" {count_text(venn.distant, 'encounter')} stayed distant."
        return empty_figure(text, theme=theme, height=HEIGHT_PX)
    look = LOOK[theme]
    labels = _labels(venn, names, encounters, look)
    has_marks = encounters is not None and len(encounters) <= MOST_MARKS
    parts = {}
    if encounters is not None and has_marks:
        category = encounters["category"].to_numpy()
        parts = {kind: encounters[category == kind.value] for kind in REGIONS}
    plan = (
        plan_marks(venn, labels, {kind: parts[kind]["severity_s"].to_numpy() for kind in REGIONS})
        if has_marks
        else plan_counts(venn, labels)
    )
    frame = plan.frame
    areas = "areas to scale" if plan.is_exact else "areas roughly to scale"
    figure = draw(
        [_clicks(venn, plan)],
        theme,
        title="Encounters detected",
        subtitle=f"{count_text(venn.n_near, 'encounter')} near enough to count; {areas}",
        height=HEIGHT_PX,
        hoverdistance=24,
        margin={"r": EDGE_PX, "b": BELOW_PX},
        # by the domain: ranges shrink for a narrow window and stay so in a wider one
        xaxis={**HIDDEN_AXIS, "range": [frame.left, frame.right], "constrain": "domain"},
        yaxis={
            **HIDDEN_AXIS,
            "range": [frame.bottom, frame.top],
            "constrain": "domain",
            "scaleanchor": "x",
        },
    )
    pale = LOOK[theme].pale
    line = {"color": pale, "width": 1}
    _fill(figure, "rect", "all encounters", frame, line, faded(pale, 0.12))
    _draw_circles(figure, plan.circles, theme)
    for kind, part in parts.items():
        if len(plan.x.get(kind, ())):
            figure.add_trace(_marks(part, kind, plan, look, objects.singular))
    figure.update_layout(annotations=_label_texts(venn, plan, labels, look))
    return figure


def _labels(
    venn: Venn, names: tuple[str, str], encounters: pd.DataFrame | None, look: ChartLook
) -> Labels:
    """Return labels of the regions (count, words, severities) and of both systems."""
    inside, beside = {}, {}
    for kind in REGIONS:
        count = f"{venn.counts()[kind.value]:,}"
        if count == "0" and kind is not Category.NEITHER:
            continue
        weights = _weights(encounters, kind)
        small = Label((LabelLine(f"<b>{count}</b> {CATEGORY_WORDS[kind]}", 14), *weights))
        large = (LabelLine(count, 24, is_bold=True), LabelLine(CATEGORY_WORDS[kind], 14))
        beside[kind] = small
        inside[kind] = small if kind is Category.NEITHER else Label((*large, *weights))
    systems = (
        Label(
            (
                LabelLine(
                    f"{letter.upper()}: {plain(name, max_length=18)}", 13, look.of(letter), True
                ),
                LabelLine(f"{venn.both + alone:,} of {venn.n_near:,}", 13, look.of(letter)),
            )
        )
        for letter, name, alone in zip("xy", names, (venn.x_only, venn.y_only), strict=True)
    )
    return Labels(inside, beside, *systems)


def _weights(encounters: pd.DataFrame | None, kind: Category) -> list[LabelLine]:
    """Return a label line with the severity of each system that fails in a region.

    A system may fail in some frames of an encounter that it detects. Over all regions the weights
    add up to its severity.
    """
    if encounters is None:
        return []
    part = encounters[encounters["category"].to_numpy() == kind.value]
    is_only = kind in (Category.X_ONLY, Category.Y_ONLY)
    weights_s = {letter: part[f"severity_s_{letter}"].sum() for letter in FAILING[kind]}
    return [
        LabelLine(f"{letter.upper()} {weight_s:.2f} s", 12)
        for place, (letter, weight_s) in enumerate(weights_s.items())
        if len(part) and (weight_s > 0 or not (is_only and place))
    ]


def _draw_circles(figure: go.Figure, circles: Circles, theme: Theme) -> None:
    for letter, centre, radius in (
        ("x", 0.0, circles.radius_x),
        ("y", circles.apart, circles.radius_y),
    ):
        if radius:
            colour = LOOK[theme].of(letter)
            line = {"color": colour, "width": 2, "dash": LOOK[theme].dash(letter)}
            corners = Frame(centre - radius, centre + radius, -radius, radius)
            _fill(figure, "circle", f"circle {letter}", corners, line, faded(colour, 0.30))


def _fill(
    figure: go.Figure, kind: str, name: str, corners: Frame, line: dict[str, Any], colour: str
) -> None:
    sides = dict(zip(("x0", "x1", "y0", "y1"), corners, strict=True))
    figure.add_shape(type=kind, name=name, line=line, fillcolor=colour, layer="below", **sides)


def _marks(
    part: pd.DataFrame, kind: Category, plan: VennPlan, look: ChartLook, noun: str
) -> go.Scatter:
    """Return a mark for each encounter of a region, styled after the system that fails in it."""
    x_s, y_s = (part[f"severity_s_{letter}"].to_numpy() for letter in "xy")
    fails = [x_s > y_s, y_s > x_s, x_s > 0]
    if kind is Category.NEITHER:
        fails = [np.zeros(len(part), bool), np.zeros(len(part), bool), x_s + y_s > 0]
    colour = np.select(fails, [look.x, look.y, look.ink], look.muted)
    symbol = np.select(fails, [look.symbol("x"), look.symbol("y"), "square"], "circle-open")
    text = [
        f"{plain(row.recording)}, {noun} {row.track}: {CATEGORY_WORDS[kind]}<br>severity X "
        f"{row.severity_s_x:.2f} s, Y {row.severity_s_y:.2f} s<br>peak cost X "
        f"{row.peak_cost_x:.2f}, Y {row.peak_cost_y:.2f}"
        for row in part.itertuples(index=False)
    ]
    return marks(
        plan.x[kind],
        plan.y[kind],
        text,
        customdata=part["shown_row"].to_numpy(),
        name=f"{CATEGORY_WORDS[kind]}, by severity",
        showlegend=False,
        marker={
            "color": colour,
            "symbol": symbol,
            "size": plan.size_px[kind] * [AREAS[name] for name in symbol],
            "line": {
                "width": 1,
                "color": np.where(symbol == "circle-open", look.muted, look.surface),
            },
        },
    )


def _label_texts(
    venn: Venn, plan: VennPlan, labels: Labels, look: ChartLook
) -> list[dict[str, Any]]:
    """Return annotations with names and counts. Those of a narrow region stand beside it."""
    circles, frame = plan.circles, plan.frame
    texts = []
    for kind in labels.inside:
        anchor = anchor_of(kind, circles, frame, plan.is_inside)
        place: dict[str, Any] = {"x": anchor.x, "y": anchor.y}
        text = labels.inside[kind].html
        if not plan.is_inside.get(kind, True):
            text = labels.beside[kind].html
            line = {"arrowhead": 0, "arrowwidth": 1, "arrowcolor": look.muted}
            ends = {"x": sum(circles.region_ends(kind)) / 2, "y": 0, "ax": anchor.x, "ay": anchor.y}
            place = {"showarrow": True, "axref": "x", "ayref": "y", **line, **ends}
        texts.append(_text(text, kind.value, look.ink, place, anchor.xanchor, anchor.yanchor))
    for letter, label in (("x", labels.x), ("y", labels.y)):
        anchor = anchor_of(letter, circles, frame, plan.is_inside)
        place = {"x": anchor.x, "y": anchor.y}
        name = f"system {letter}"
        texts.append(_text(label.html, name, look.ink, place, anchor.xanchor, anchor.yanchor))
    place = {"x": frame.right, "y": frame.bottom, "yshift": -4}
    text = f'<span style="font-size:12px">{venn.distant:,} too far to count</span>'
    texts.append(_text(text, Category.DISTANT.value, look.muted, place, "right", "top"))
    return texts


def _text(
    text: str, name: str, colour: str, place: dict[str, Any], xanchor: str, yanchor: str
) -> dict[str, Any]:
    place |= {"xanchor": xanchor, "yanchor": yanchor, "align": xanchor}
    return written(text, size=BASE_PX, color=colour, name=name, borderpad=0, **place)


def _clicks(venn: Venn, plan: VennPlan) -> go.Scatter:
    """Return invisible, clickable markers of the categories wherever no encounter is marked."""
    circles, (left, right, bottom, top) = plan.circles, plan.frame
    across, up = np.linspace(left, right, GRID[0]), np.linspace(bottom, top, GRID[1])
    x, y = (grid.ravel() for grid in np.meshgrid(across, up))
    depth = [circles.depth(kind, x, y) >= 0 for kind in IN_CIRCLES]
    category = np.select(depth, range(3), default=3)
    # a region may be too small for the grid, so it gets one marker in its middle
    for code, kind in enumerate(IN_CIRCLES):
        if venn.counts()[kind.value]:
            x, y = np.append(x, sum(circles.region_ends(kind)) / 2), np.append(y, 0.0)
            category = np.append(category, code)
    is_free = np.ones(len(x), bool)
    for kind, size_px in plan.size_px.items():
        for mark_x, mark_y, size in zip(plan.x[kind], plan.y[kind], size_px, strict=True):
            apart_px = np.hypot(x - mark_x, y - mark_y) * plan.frame.scale
            is_free &= apart_px > (size + CLICK_PX) / 2 + GAP
    x, y, category = x[is_free], y[is_free], category[is_free]
    x, y = np.append(x, right), np.append(y, bottom - 0.04 * (top - bottom))
    names = [REGIONS[code].value for code in category] + [Category.DISTANT.value]
    text = [
        f"{count_text(venn.counts()[name], 'encounter')}: {CATEGORY_WORDS[Category(name)]}"
        for name in names
    ]
    return click_markers(x, y, text, customdata=names, name="regions", cliponaxis=False)
