"""Where counts and marks stand in the diagram, without touching each other or a region's edge.

All lengths here are pixels at the least size in which the diagram is drawn; it may be larger.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from nvcore.figures.venn.circles import Circles, Frame, circles_of, frame_of
from nvcore.figures.venn.labels import Labels, text_boxes
from nvcore.metrics.venn import Venn
from nvcore.schema import Category

REGIONS: Final = (Category.BOTH, Category.X_ONLY, Category.Y_ONLY, Category.NEITHER)
IN_CIRCLES: Final = REGIONS[:3]
MAX_SIZES: Final = (28, 24, 20, 17, 14, 12, 10, 8, 6.5, 5)
"""Sizes of the largest mark that are tried, px."""
FAIR: Final = MAX_SIZES.index(10)
"""Rather than that marks are smaller than this, a count stands beside its region."""
MIN_SIZE: Final = 4
"""Size of the mark of an encounter in which nothing was missed."""
GAP: Final = 1.5
REACH: Final = 1.25
"""How far corners of diamonds and squares reach beyond a circle of their area."""
STEP: Final = 3.3
"""Distance of the places that are tried."""
GROWTH: Final = 1.6
"""By how much a region grows that is too narrow for its marks."""
MAX_GROWTHS: Final = 16


@dataclass(frozen=True)
class VennPlan:
    """A layout of the diagram.

    Attributes
    ----------
    is_inside
        Whether the count of a region stands in it.
    is_exact
        Whether the areas are in proportion to the counts.
    x, y, size_px
        Of the marks of each region, in the circles' unit and in pixels.
    """

    circles: Circles
    frame: Frame
    is_inside: Mapping[Category, bool]
    is_exact: bool = True
    x: Mapping[Category, np.ndarray] = field(default_factory=dict)
    y: Mapping[Category, np.ndarray] = field(default_factory=dict)
    size_px: Mapping[Category, np.ndarray] = field(default_factory=dict)


def plan_counts(venn: Venn, labels: Labels) -> VennPlan:
    """A layout without marks."""
    circles = circles_of(venn.both, venn.x_only, venn.y_only)
    frame = frame_of(circles)
    return VennPlan(circles, frame, _inside(circles, frame, labels))


def plan_marks(venn: Venn, labels: Labels, severity_s: Mapping[Category, np.ndarray]) -> VennPlan:
    """A layout with a mark for each encounter, its area by severity.

    The largest marks are nearest to the count of their region. A count whose marks would be small
    stands beside its region. A region that is too narrow for its marks grows: the areas are then
    in proportion only roughly.

    Parameters
    ----------
    severity_s
        Of the encounters of every region, the largest first.
    """
    area = {kind: float(venn.counts()[kind.value]) for kind in REGIONS}
    largest = max((float(values.max(initial=0)) for values in severity_s.values()), default=0.0)
    sizes_px = [
        {kind: _sizes(severity_s[kind], largest, max_size) for kind in REGIONS}
        for max_size in MAX_SIZES
    ]
    for growth in range(MAX_GROWTHS):
        circles = circles_of(*(area[kind] for kind in IN_CIRCLES))
        frame = frame_of(circles)
        is_inside = _inside(circles, frame, labels)
        rooms = _rooms(circles, frame, labels, is_inside)
        narrow = _place(rooms, sizes_px[FAIR])[1]
        if any(is_inside.get(kind) for kind in narrow):
            is_inside = {kind: is_inside[kind] and kind not in narrow for kind in IN_CIRCLES}
            rooms = _rooms(circles, frame, labels, is_inside)
        places, size_px, narrow = _place_largest(rooms, sizes_px)
        if not narrow:
            x, y = ({kind: places[kind][axis] / frame.scale for kind in REGIONS} for axis in (0, 1))
            return VennPlan(circles, frame, is_inside, growth == 0, x, y, size_px)
        area |= {kind: area[kind] * GROWTH for kind in narrow}
    return plan_counts(venn, labels)  # not seen with up to 150 marks


def _inside(circles: Circles, frame: Frame, labels: Labels) -> dict[Category, bool]:
    """Whether each region is wide enough for its count."""
    fits = {}
    for kind in IN_CIRCLES:
        start, stop = circles.region_ends(kind)
        width = labels.inside[kind].width if kind in labels.inside else 0
        fits[kind] = (stop - start) * frame.scale >= width
    return fits


def _sizes(severity_s: np.ndarray, largest: float, max_size: float) -> np.ndarray:
    """Diameters of marks, px: their areas are severities, those of the least are visible."""
    share = severity_s / largest if largest else np.zeros(len(severity_s))
    sizes: np.ndarray = np.maximum(max_size * np.sqrt(share), MIN_SIZE)
    return sizes


class MarkRoom(NamedTuple):
    """Places in a region where a mark may stand; all px, shape (n_places,).

    Attributes
    ----------
    free
        Distance from what a mark may not touch.
    apart
        Distance from the label, by which places are preferred.
    """

    x: np.ndarray
    y: np.ndarray
    free: np.ndarray
    apart: np.ndarray


def _rooms(
    circles: Circles, frame: Frame, labels: Labels, is_inside: Mapping[Category, bool]
) -> dict[Category, MarkRoom]:
    """The places of every region."""
    scale = frame.scale
    left, right, bottom, top = (end * scale for end in frame)
    columns, rows = np.meshgrid(np.arange(left, right, STEP), np.arange(bottom, top, STEP))
    columns[1::2] += STEP / 2
    x, y = columns.ravel(), rows.ravel()
    boxes = text_boxes(labels, circles, frame, is_inside)
    from_sides = [x - left, right - x, y - bottom, top - y]
    free = np.min([*from_sides, *(box.distance(x, y) for box in boxes.values())], axis=0)
    rooms = {}
    for kind in REGIONS:
        own = np.minimum(free, circles.depth(kind, x / scale, y / scale) * scale)
        is_within = own >= MIN_SIZE * REACH / 2 + GAP
        room_x, room_y = x[is_within], y[is_within]
        if kind in boxes and is_inside.get(kind, True):
            box = boxes[kind]
            middle_x, middle_y = (box.left + box.right) / 2, (box.bottom + box.top) / 2
        else:
            middle_x, middle_y = sum(circles.region_ends(kind)) / 2 * scale, 0.0
        apart = np.hypot(room_x - middle_x, room_y - middle_y)
        rooms[kind] = MarkRoom(room_x, room_y, own[is_within], apart)
    return rooms


Places = dict[Category, tuple[np.ndarray, np.ndarray]]


def _place(
    rooms: Mapping[Category, MarkRoom], size_px: Mapping[Category, np.ndarray]
) -> tuple[Places, list[Category]]:
    """Places of the marks of every region, px, and which regions have no room for theirs."""
    places: Places = {}
    narrow = []
    for kind, room in rooms.items():
        spots = _pack(room, size_px[kind] * REACH / 2)
        if spots is None:
            narrow.append(kind)
        else:
            places[kind] = room.x[spots], room.y[spots]
    return places, narrow


def _place_largest(
    rooms: Mapping[Category, MarkRoom], sizes_px: Sequence[Mapping[Category, np.ndarray]]
) -> tuple[Places, Mapping[Category, np.ndarray], list[Category]]:
    """`_place` with the largest of `sizes_px` for which all regions have room, else the least."""
    places, narrow = _place(rooms, sizes_px[FAIR])
    index = FAIR
    while narrow and index + 1 < len(sizes_px):
        index += 1
        places, narrow = _place(rooms, sizes_px[index])
    while index <= FAIR and index > 0 and not narrow:
        larger, without_room = _place(rooms, sizes_px[index - 1])
        if without_room:
            break
        places, index = larger, index - 1
    return places, sizes_px[index], narrow


def _pack(room: MarkRoom, radius: np.ndarray) -> np.ndarray | None:
    """Which place each circle takes, the nearest that is free; None: one finds no place."""
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
