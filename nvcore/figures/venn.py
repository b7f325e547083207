"""Venn diagram of encounters: two circles with areas in proportion to the counts.

The layout is in pixels at the least size in which the diagram is drawn. It may be larger.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import unescape
from math import acos, pi, sin, sqrt
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from scipy.optimize import brentq

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text
from nvcore.dataset.schema import CATEGORY_WORDS, Category
from nvcore.figures.marks import click_markers, marks
from nvcore.figures.style import EDGE_PX, HIDDEN_AXIS, LOOK, ChartLook, Names, faded, plain, written
from nvcore.metrics.venn import Venn
from nvcore.settings.objects import Objects

REGIONS: Final = (Category.BOTH, Category.X_ONLY, Category.Y_ONLY, Category.NEITHER)
IN_CIRCLES: Final = REGIONS[:3]
MOST_MARKS: Final = 150
"""Maximum number of encounters for drawing a mark for each."""
HEIGHT_PX: Final = 342
PLOT_PX: Final = (340, 255)
"""Width and height that the frame has at least: on a phone."""
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
BASE_PX: Final = 14
"""Font size of a whole label: no line is lower."""
MAX_SIZES: Final = (28, 24, 20, 17, 14, 12, 10, 8, 6.5, 5)
"""Sizes of the largest mark to try, px."""
FAIR: Final = MAX_SIZES.index(10)
"""If marks were smaller than this, the count stands beside its region instead."""
MIN_SIZE: Final = 4
"""Size of the mark of an encounter without severity."""
GAP: Final = 1.5
REACH: Final = 1.25
"""Reach of the corners of diamonds and squares over the radius of a circle of their area."""
STEP: Final = 3.3
"""Distance of the places to try."""


def venn_figure(
    venn: Venn,
    names: Names,
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
    encounters
        Table of `nvcore.tables.encounters.severity.weighed_encounters`. Up to 150 encounters get a
        mark each, with an area by the larger severity. None: counts only.

    References
    ----------
    Paper 11-0360, figures 1 and 2.
    """
    look = LOOK[theme]
    if venn.n_near == 0:
        text = f"No {objects.singular} came near enough to count."
        if venn.distant:
            text += f" {count_text(venn.distant, 'encounter')} stayed distant."
        return look.empty(text, height=HEIGHT_PX)
    parts = {}
    if encounters is not None:
        category = encounters["category"].to_numpy()
        parts = {kind: encounters[category == kind.value] for kind in REGIONS}
    labels = _labels(venn, names, parts, look)
    if encounters is None or len(encounters) > MOST_MARKS:
        plan = plan_counts(venn, labels)
    else:
        severity_s = {kind: part["severity_s"].to_numpy() for kind, part in parts.items()}
        plan = plan_marks(venn, labels, severity_s)
    circles, frame = plan.circles, plan.circles.frame
    line = {"color": look.pale, "width": 1}
    shapes = [filled("rect", frame, line, faded(look.pale, 0.12), name="all encounters")]
    for letter, x, radius in (("x", 0.0, circles.radius_x), ("y", circles.apart, circles.radius_y)):
        if radius:
            line = {"color": look.of(letter), "width": 2, "dash": look.dash(letter)}
            box, fill = Frame(x - radius, x + radius, -radius, radius), faded(look.of(letter), 0.30)
            shapes.append(filled("circle", box, line, fill, name=f"circle {letter}"))
    drawn = [
        _marks(parts[kind], kind, place, look, objects.singular)
        for kind, place in plan.marks.items()
        if place.size
    ]
    return look.draw(
        [_clicks(venn, plan), *drawn],
        title="Encounters detected",
        subtitle=f"{count_text(venn.n_near, 'encounter')} near enough to count; "
        f"areas {'' if plan.is_exact else 'roughly '}to scale",
        height=HEIGHT_PX,
        hoverdistance=24,
        margin={"r": EDGE_PX, "b": 24},  # below: the number of distant encounters
        shapes=shapes,
        annotations=_annotations(venn, plan, look),
        **square_axes(frame[:2], frame[2:]),
    )


def square_axes(across: Sequence[float], up: Sequence[float]) -> dict[str, Any]:
    """Return two hidden axes of one scale with these ranges.

    They give way by their domain: ranges would shrink for a narrow window and stay so in a wider
    one.
    """
    xaxis = {**HIDDEN_AXIS, "range": [*across], "constrain": "domain"}
    return {"xaxis": xaxis, "yaxis": {**xaxis, "range": [*up], "scaleanchor": "x"}}


def filled(kind: str, box: Frame, line: dict[str, Any], fill: str, **more: Any) -> dict[str, Any]:
    """Return a shape below the marks: the ``"circle"`` or ``"rect"`` in a box."""
    sides = dict(zip(("x0", "x1", "y0", "y1"), box, strict=True))
    return {"type": kind, "line": line, "fillcolor": fill, "layer": "below", **sides, **more}


class Frame(NamedTuple):
    """A rectangle."""

    left: float
    right: float
    bottom: float
    top: float


@dataclass(frozen=True)
class Circles:
    """X's circle around (0, 0) and Y's around (`apart`, 0).

    Their areas, and that of their overlap, are the numbers of encounters detected.
    """

    radius_x: float
    radius_y: float
    apart: float

    @property
    def sides(self) -> tuple[float, float, float, float]:
        """Leftmost and rightmost points of X's circle, then of Y's."""
        apart, radius = self.apart, self.radius_y
        return -self.radius_x, self.radius_x, apart - radius, apart + radius

    def ends(self, kind: Category) -> tuple[float, float]:
        """Return where a region begins and ends on the line through both centres."""
        left_x, right_x, left_y, right_y = self.sides
        if kind is Category.X_ONLY:
            return left_x, min(right_x, left_y)
        if kind is Category.Y_ONLY:
            return max(right_x, left_y), right_y
        return max(left_x, left_y), min(right_x, right_y)

    def middle(self, kind: Category) -> float:
        """Return the middle of a region on the line through both centres."""
        return sum(self.ends(kind)) / 2

    def depth(self, kind: Category, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Distance of places inside a region from its nearest circle. Outside it is negative."""
        in_x = self.radius_x - np.hypot(x, y)
        in_y = self.radius_y - np.hypot(x - self.apart, y)
        depth: np.ndarray = np.minimum(
            in_x if kind in (Category.BOTH, Category.X_ONLY) else -in_x,
            in_y if kind in (Category.BOTH, Category.Y_ONLY) else -in_y,
        )
        return depth

    @cached_property
    def frame(self) -> Frame:
        """Frame with room for the words beside the circles, and for the undetected below them."""
        left, right = min(self.sides), max(self.sides)
        width = max(right - left, 1.0)
        height = max(2 * max(self.radius_x, self.radius_y), 0.35 * width)
        pad = 0.1 * height
        half_width = max(width / 2 + pad, 0.5 * 1.75 * (height + 3.2 * pad))
        middle = (left + right) / 2
        bottom, top = -height / 2 - 2.4 * pad, height / 2 + 1.6 * pad
        return Frame(middle - half_width, middle + half_width, bottom, top)

    @property
    def scale(self) -> float:
        """Minimum number of pixels of a unit."""
        left, right, bottom, top = self.frame
        return min(PLOT_PX[0] / (right - left), PLOT_PX[1] / (top - bottom))


def overlap_area(radius_x: float, radius_y: float, apart: float) -> float:
    """Area of the overlap of two circles."""
    if apart >= radius_x + radius_y:
        return 0.0
    if apart <= abs(radius_x - radius_y):
        return pi * min(radius_x, radius_y) ** 2
    # two circular segments: angles at the centres, less the kite between centres and corners
    half_x = acos((apart**2 + radius_x**2 - radius_y**2) / (2 * apart * radius_x))
    half_y = acos((apart**2 + radius_y**2 - radius_x**2) / (2 * apart * radius_y))
    corner = radius_x**2 * sin(2 * half_x) + radius_y**2 * sin(2 * half_y)
    return radius_x**2 * half_x + radius_y**2 * half_y - corner / 2


def circles_of(both: float, x_only: float, y_only: float) -> Circles:
    """Return circles by the areas of their three regions, the counts of a Venn diagram.

    A circle inside the other touches it. Circles without overlap stand a little apart.
    """
    radius_x, radius_y = sqrt((both + x_only) / pi), sqrt((both + y_only) / pi)
    least, most = abs(radius_x - radius_y), radius_x + radius_y
    if both == 0:
        apart = most + 0.15 * max(radius_x, radius_y)
    elif x_only == 0 or y_only == 0:
        apart = least
    else:
        apart = brentq(
            lambda apart: overlap_area(radius_x, radius_y, apart) - both, least, most, xtol=1e-13
        )
    return Circles(radius_x, radius_y, apart)


class Line(NamedTuple):
    """One line of a label. Names in `text` went through `nvcore.figures.style.plain`."""

    text: str
    size: float
    colour: str = ""
    is_bold: bool = False

    @property
    def html(self) -> str:
        """The line as Plotly takes it."""
        text = f"<b>{self.text}</b>" if self.is_bold else self.text
        colour = f";color:{self.colour}" if self.colour else ""
        return f'<span style="font-size:{self.size:g}px{colour}">{text}</span>'


Label = tuple[Line, ...]
Labels = Mapping[str, tuple[Label, Label]]
"""Labels of regions (inside, beside the region) and of the systems "x" and "y"."""


def _width(label: Label) -> float:
    """Width of a label in a wide font, px."""
    return max(0.6 * line.size * len(unescape(line.text)) for line in label)


def _labels(
    venn: Venn, names: Names, parts: Mapping[Category, pd.DataFrame], look: ChartLook
) -> dict[str, tuple[Label, Label]]:
    """Return labels of the regions (count, words, severities) and of both systems."""
    labels = {}
    for kind in REGIONS:
        count, words = f"{venn.counts()[kind.value]:,}", CATEGORY_WORDS[kind]
        if count == "0" and kind is not Category.NEITHER:
            continue
        weights = _weights(parts[kind], kind) if parts else []
        large = Line(count, 24, is_bold=True), Line(words, 14), *weights
        small = Line(f"<b>{count}</b> {words}", 14), *weights
        labels[kind.value] = (small if kind is Category.NEITHER else large, small)
    for letter, name, alone in zip("xy", names, (venn.x_only, venn.y_only), strict=True):
        colour = look.of(letter)
        label = (
            Line(f"{letter.upper()}: {plain(name, max_length=18)}", 13, colour, True),
            Line(f"{venn.both + alone:,} of {venn.n_near:,}", 13, colour),
        )
        labels[letter] = label, label
    return labels


def _weights(part: pd.DataFrame, kind: Category) -> list[Line]:
    """Return a line with the severity of each system that fails in a region.

    A system may fail in some frames of an encounter that it detects. Over all regions the weights
    add up to its severity.
    """
    detected_by = {Category.X_ONLY: "x", Category.Y_ONLY: "y"}.get(kind)
    # the system with a failed detection first
    letters = "yx" if detected_by == "x" else "xy"
    weights_s = {letter: part[f"severity_s_{letter}"].sum() for letter in letters}
    return [
        Line(f"{letter.upper()} {weight_s:.2f} s", 12)
        for letter, weight_s in weights_s.items()
        if len(part) and (weight_s > 0 or letter != detected_by)
    ]


ACROSS: Final = {"left": 0.0, "center": 0.5, "right": 1.0}
UP: Final = {"bottom": 0.0, "middle": 0.5, "top": 1.0}
"""Places of a text's anchor, as shares of its width and height."""


class Text(NamedTuple):
    """A label in its place, in the circles' unit.

    `pointer` is the middle of the region beside which it stands; None: it stands in its region.
    """

    label: Label
    x: float
    y: float
    xanchor: str
    yanchor: str
    pointer: float | None = None

    def box(self, scale: float) -> Frame:
        """Return the rectangle that the label takes up, px."""
        width = _width(self.label)
        height = sum(1.3 * max(line.size, BASE_PX) for line in self.label)
        left = self.x * scale - ACROSS[self.xanchor] * width
        bottom = self.y * scale - UP[self.yanchor] * height
        return Frame(left, left + width, bottom, bottom + height)


def _texts(labels: Labels, circles: Circles, crowded: Container[str] = ()) -> dict[str, Text]:
    """Place the labels in their regions or in the corners.

    The label of a region that is in `crowded`, or too narrow for it, stands beside the region.
    """
    left, right, bottom, top = circles.frame
    pad, gap = 0.02 * (top - bottom), 0.06 * (right - left)
    places = {
        "x": (left + pad, top - pad, "left", "top"),
        "y": (right - pad, top - pad, "right", "top"),
        Category.NEITHER: (right - pad, bottom + pad, "right", "bottom"),
        Category.X_ONLY: (min(circles.sides) - gap, 0, "right", "middle"),
        Category.Y_ONLY: (max(circles.sides) + gap, 0, "left", "middle"),
        Category.BOTH: (circles.middle(Category.BOTH), 0.94 * bottom, "center", "bottom"),
    }
    texts = {}
    for name, (inside, outside) in labels.items():
        if name not in IN_CIRCLES:
            texts[name] = Text(outside, *places[name])
            continue
        start, stop = circles.ends(Category(name))
        middle = (start + stop) / 2
        if name in crowded or (stop - start) * circles.scale < _width(inside):
            texts[name] = Text(outside, *places[name], pointer=middle)
        else:
            texts[name] = Text(inside, middle, 0, "center", "middle")
    return texts


@dataclass(frozen=True)
class VennPlan:
    """Layout of the diagram. `is_exact` if the areas are in proportion to the counts.

    Marks are x and y in the circles' unit and size in px, of each region of shape (3, n).
    """

    circles: Circles
    texts: Mapping[str, Text]
    is_exact: bool = True
    marks: Mapping[Category, np.ndarray] = field(default_factory=dict)


def plan_counts(venn: Venn, labels: Labels) -> VennPlan:
    """Lay out the diagram without marks."""
    circles = circles_of(venn.both, venn.x_only, venn.y_only)
    return VennPlan(circles, _texts(labels, circles))


def plan_marks(venn: Venn, labels: Labels, severity_s: Mapping[Category, np.ndarray]) -> VennPlan:
    """Lay out the diagram with a mark for each encounter, its area by severity.

    The largest marks are nearest to the count of their region. A count whose marks would be small
    stands beside its region. A region that is too narrow for its marks grows, so that the areas are
    in proportion only roughly.

    Parameters
    ----------
    severity_s
        Severities of the encounters of every region, the largest first.
    """
    area = {kind: float(venn.counts()[kind.value]) for kind in REGIONS}
    largest = max(float(values.max(initial=0)) for values in severity_s.values()) or 1.0
    sizes_px = [
        {
            kind: np.maximum(max_size * np.sqrt(values / largest), MIN_SIZE)
            for kind, values in severity_s.items()
        }
        for max_size in MAX_SIZES
    ]
    for growth in range(16):
        circles = circles_of(*(area[kind] for kind in IN_CIRCLES))
        texts = _texts(labels, circles)
        rooms = _rooms(circles, texts)
        placed = _place(rooms, sizes_px[FAIR])
        crowded = {kind for kind in rooms.keys() - placed.keys() if texts[kind].pointer is None}
        if crowded:
            texts = _texts(labels, circles, crowded)
            rooms = _rooms(circles, texts)
            placed = _place(rooms, sizes_px[FAIR])
        placed = _enlarge(placed, rooms, sizes_px)
        if len(placed) == len(rooms):
            units = np.array([[circles.scale], [circles.scale], [1.0]])
            scaled = {kind: places / units for kind, places in placed.items()}
            return VennPlan(circles, texts, growth == 0, scaled)
        for kind in rooms.keys() - placed.keys():
            area[kind] *= 1.6
    return plan_counts(venn, labels)  # not seen with up to 150 marks


class Room(NamedTuple):
    """Places in a region where a mark may stand, px, shape (n_places,).

    `free` is the distance from the nearest edge or text, `apart` that from the label: nearer places
    are preferred.
    """

    x: np.ndarray
    y: np.ndarray
    free: np.ndarray
    apart: np.ndarray


def _rooms(circles: Circles, texts: Mapping[str, Text]) -> dict[Category, Room]:
    """Return the places of every region."""
    scale = circles.scale
    left, right, bottom, top = (end * scale for end in circles.frame)
    columns, rows = np.meshgrid(np.arange(left, right, STEP), np.arange(bottom, top, STEP))
    columns[1::2] += STEP / 2
    x, y = columns.ravel(), rows.ravel()
    boxes = {name: text.box(scale) for name, text in texts.items()}
    free = np.minimum.reduce([x - left, right - x, y - bottom, top - y])
    for box in boxes.values():
        across = np.maximum(np.maximum(box.left - x, x - box.right), 0)
        up = np.maximum(np.maximum(box.bottom - y, y - box.top), 0)
        free = np.minimum(free, np.hypot(across, up))
    rooms = {}
    for name, text in texts.items():
        if name not in REGIONS:
            continue
        kind, box = Category(name), boxes[name]
        own = np.minimum(free, circles.depth(kind, x / scale, y / scale) * scale)
        is_within = own >= MIN_SIZE * REACH / 2 + GAP
        middle_x, middle_y = (box.left + box.right) / 2, (box.bottom + box.top) / 2
        if text.pointer is not None:
            middle_x, middle_y = text.pointer * scale, 0.0
        apart = np.hypot(x - middle_x, y - middle_y)
        rooms[kind] = Room(x[is_within], y[is_within], own[is_within], apart[is_within])
    return rooms


Marks = dict[Category, np.ndarray]
"""x, y and size of the marks of regions, each of shape (3, n)."""


def _enlarge(placed: Marks, rooms: Mapping[Category, Room], sizes_px: Sequence[Marks]) -> Marks:
    """Place marks in the largest of `sizes_px` for which all regions have room, else the least.

    `placed` are the marks of the size `FAIR`.
    """
    if len(placed) < len(rooms):
        for size_px in sizes_px[FAIR + 1 :]:
            placed = _place(rooms, size_px)
            if len(placed) == len(rooms):
                break
        return placed
    for size_px in reversed(sizes_px[:FAIR]):
        larger = _place(rooms, size_px)
        if len(larger) < len(rooms):
            break
        placed = larger
    return placed


def _place(rooms: Mapping[Category, Room], size_px: Marks) -> Marks:
    """Place the marks of all regions that have room for theirs, px."""
    spots = {kind: _pack(room, size_px[kind] * REACH / 2) for kind, room in rooms.items()}
    return {
        kind: np.stack([rooms[kind].x[spot], rooms[kind].y[spot], size_px[kind]])
        for kind, spot in spots.items()
        if spot is not None
    }


def _pack(room: Room, radius: np.ndarray) -> np.ndarray | None:
    """Return the nearest free place for each circle, or None if one finds no place."""
    spots = np.empty(len(radius), dtype=np.int64)
    free = room.free
    # one after the other: where a circle can stand depends on those before it
    for index, own in enumerate(radius):
        has_room = free >= own + GAP
        if not has_room.any():
            return None
        spot = spots[index] = np.argmin(np.where(has_room, room.apart, np.inf))
        free = np.minimum(free, np.hypot(room.x - room.x[spot], room.y - room.y[spot]) - own)
    return spots


def _marks(
    part: pd.DataFrame, kind: Category, place: np.ndarray, look: ChartLook, noun: str
) -> go.Scatter:
    """Return a mark for each encounter of a region, styled after the system that fails in it."""
    x_s, y_s = (part[f"severity_s_{letter}"].to_numpy() for letter in "xy")
    is_one = kind is not Category.NEITHER
    fails = [(x_s > y_s) & is_one, (y_s > x_s) & is_one, x_s + y_s > 0]
    colour = np.select(fails, [look.x, look.y, look.ink], look.muted)
    symbol = np.select(fails, [look.symbol("x"), look.symbol("y"), "square"], "circle-open")
    text = [
        f"{plain(row.recording)}, {noun} {row.track}: {CATEGORY_WORDS[kind]}<br>severity X "
        f"{row.severity_s_x:.2f} s, Y {row.severity_s_y:.2f} s<br>peak cost X "
        f"{row.peak_cost_x:.2f}, Y {row.peak_cost_y:.2f}"
        for row in part.itertuples(index=False)
    ]
    rim = np.where(symbol == "circle-open", look.muted, look.surface)
    return marks(
        place[0],
        place[1],
        text,
        customdata=part["shown_row"].to_numpy(),
        name=f"{CATEGORY_WORDS[kind]}, by severity",
        showlegend=False,
        marker={
            "color": colour,
            "symbol": symbol,
            "size": place[2] * [AREAS[name] for name in symbol],
            "line": {"width": 1, "color": rim},
        },
    )


def _annotations(venn: Venn, plan: VennPlan, look: ChartLook) -> list[dict[str, Any]]:
    """Return the labels, with a line to the region that a label stands beside."""
    frame, notes = plan.circles.frame, []
    distant = Line(f"{venn.distant:,} too far to count", 12)
    corner = Text((distant,), frame.right, frame.bottom, "right", "top")
    for name, text in {**plan.texts, Category.DISTANT.value: corner}.items():
        place: dict[str, Any] = {"x": text.x, "y": text.y}
        if text.pointer is not None:
            line = {"arrowhead": 0, "arrowwidth": 1, "arrowcolor": look.muted}
            ends = {"x": text.pointer, "y": 0, "ax": text.x, "ay": text.y}
            place = {"showarrow": True, "axref": "x", "ayref": "y", **line, **ends}
        if text is corner:
            place["yshift"] = -4
        note = written(
            "<br>".join(line.html for line in text.label),
            size=BASE_PX,
            color=look.muted if text is corner else look.ink,
            name=f"system {name}" if name in ("x", "y") else name,
            borderpad=0,
            xanchor=text.xanchor,
            yanchor=text.yanchor,
            align=text.xanchor,
            **place,
        )
        notes.append(note)
    return notes


def _clicks(venn: Venn, plan: VennPlan) -> go.Scatter:
    """Return invisible, clickable markers of the categories wherever no encounter is marked."""
    circles, (left, right, bottom, top) = plan.circles, plan.circles.frame
    grid = np.meshgrid(np.linspace(left, right, 36), np.linspace(bottom, top, 22))
    x, y = (places.ravel() for places in grid)
    depth = [circles.depth(kind, x, y) >= 0 for kind in IN_CIRCLES]
    category = np.select(depth, range(3), default=3)
    # a region may be too small for the grid, so it gets one marker in its middle
    codes = [code for code, kind in enumerate(IN_CIRCLES) if venn.counts()[kind.value]]
    x = np.append(x, [circles.middle(IN_CIRCLES[code]) for code in codes])
    y, category = np.append(y, np.zeros(len(codes))), np.append(category, codes)
    mark_x, mark_y, size = np.hstack([np.empty((3, 0)), *plan.marks.values()])
    apart_px = np.hypot(x[:, None] - mark_x, y[:, None] - mark_y) * circles.scale
    is_free = (apart_px > (size + CLICK_PX) / 2 + GAP).all(axis=1)
    x = np.append(x[is_free], right)
    y = np.append(y[is_free], bottom - 0.04 * (top - bottom))
    names = [REGIONS[int(code)].value for code in category[is_free]] + [Category.DISTANT.value]
    text = [
        f"{count_text(venn.counts()[name], 'encounter')}: {CATEGORY_WORDS[Category(name)]}"
        for name in names
    ]
    return click_markers(x, y, text, customdata=names, name="regions", cliponaxis=False)
