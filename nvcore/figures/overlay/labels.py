"""Placement of labels: inside the picture, apart from each other and from missed pedestrians.

A label that does not fit is left out, unless it belongs to a missed pedestrian.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

Box = tuple[float, float, float, float]
"""Left, top, right, bottom."""
Place = tuple[float, float]
"""Left and top."""

FAR_LINES: Final = 5


class LabelRoom:
    """Free space of a picture.

    Parameters
    ----------
    width, height
        Size of the picture, px.
    missed
        Boxes that no label may cover.
    """

    def __init__(self, width: float, height: float, missed: Sequence[Box] = ()):
        self.width = width
        self.height = height
        self.taken: list[Box] = list(missed)

    def take(self, size: Place, places: Sequence[Place]) -> Box | None:
        """Reserve the first of the places that is free, or return None if none is.

        Parameters
        ----------
        size
            Width and height of the label, px.
        places
            Candidate positions (left, top), the best first.
        """
        for left, top in places:
            box = (left, top, left + size[0], top + size[1])
            is_inside = left >= 0 and top >= 0 and box[2] <= self.width and box[3] <= self.height
            if is_inside and not any(overlap(box, other) for other in self.taken):
                self.taken.append(box)
                return box
        return None

    def must_take(self, size: Place, places: Sequence[Place]) -> Box:
        """Reserve a place like `take`, or else the place inside the picture that hides least."""
        moved = [self._inside(place, size) for place in places]
        best_place = self.take(size, moved)
        if best_place is None:
            boxes = [(left, top, left + size[0], top + size[1]) for left, top in moved]
            best_place = min(
                boxes, key=lambda box: sum(overlap(box, other) for other in self.taken)
            )
            self.taken.append(best_place)
        return best_place

    def _inside(self, place: Place, size: Place) -> Place:
        left, top = place
        return (
            max(0.0, min(left, self.width - size[0])),
            max(0.0, min(top, self.height - size[1])),
        )


def overlap(box: Box, other: Box) -> float:
    """Return the area that two boxes share, px².

    Examples
    --------
    >>> overlap((0, 0, 4, 4), (2, 3, 9, 9))
    2
    >>> overlap((0, 0, 4, 4), (4, 0, 8, 4))
    0
    """
    across = min(box[2], other[2]) - max(box[0], other[0])
    down = min(box[3], other[3]) - max(box[1], other[1])
    return across * down if across > 0 and down > 0 else 0


def tag_places(box: Box, size: Place) -> list[Place]:
    """Return the places for a tag at a box: above, below, beside, then further away."""
    left, top, right, bottom = box
    width, height = size
    near = [
        (left, top - height),
        (left, bottom),
        (right - width, top - height),
        (right - width, bottom),
        (right, top),
        (left - width, top),
    ]
    lines = [line * (height + 1) for line in range(1, FAR_LINES + 1)]
    far = [
        place for away in lines for place in ((left, top - height - away), (left, bottom + away))
    ]
    return near + far
