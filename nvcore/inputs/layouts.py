"""What the four numbers of a box mean, and boxes whose numbers mean something else.

A reader knows the meaning from its format, and a file may mean another: corners where width and
height belong, the vertical axis first, shares of the picture. A box that was read by the wrong
meaning still holds its four numbers, so it is read again without the file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from nvcore.errors import SessionError

if TYPE_CHECKING:
    import numpy as np

Box = tuple["np.ndarray", "np.ndarray", "np.ndarray", "np.ndarray"]
"""Four numbers of each box, or its x, y, w, h in pixels; each of shape (n,)."""

KINDS: Final = {
    "sizes": (("left", "top", "width", "height"), ("top", "left", "height", "width")),
    "corners": (("left", "top", "right", "bottom"), ("top", "left", "bottom", "right")),
    "centres": (
        ("centre x", "centre y", "width", "height"),
        ("centre y", "centre x", "height", "width"),
    ),
}
"""What the numbers are, in their order: the horizontal one of each pair first, or second."""
UNITS: Final = {
    "": (None, ""),
    "shares": (1.0, "shares of the picture (0 to 1)"),
    "percent": (100.0, "percent of the picture"),
    "thousandths": (1000.0, "thousandths of the picture"),
}
"""What the whole width (or height) of the picture is in each unit; None: pixels."""
YX: Final = "yx"
SCORE_FIRST: Final = "score"


@dataclass(frozen=True)
class BoxLayout:
    """What the numbers of a box are.

    Attributes
    ----------
    kind
        A key of `KINDS`.
    is_yx
        Whether the vertical number of each pair comes first.
    unit
        A key of `UNITS`.
    is_score_first
        Whether the score stands before the four numbers, where the reader took it from behind.
    """

    kind: str = "sizes"
    is_yx: bool = False
    unit: str = ""
    is_score_first: bool = False

    def __str__(self) -> str:
        """As a session file and a flag say it, such as ``corners-yx-thousandths``."""
        words = (SCORE_FIRST * self.is_score_first, self.kind, YX * self.is_yx, self.unit)
        return "-".join(filter(None, words))

    @property
    def text(self) -> str:
        """In words, such as ``left, top, right, bottom in percent of the picture``."""
        text = ", ".join(KINDS[self.kind][self.is_yx])
        if self.is_score_first:
            text = f"score, {text}"
        return f"{text} in {UNITS[self.unit][1]}" if self.unit else text

    def numbers(self, box: Box, score: np.ndarray, size: Box | None) -> tuple[np.ndarray, ...]:
        """The numbers that a box in pixels was made from, and the score; inverse of `boxes`."""
        x, y, w, h = box
        if self.kind == "corners":
            w, h = x + w, y + h
        elif self.kind == "centres":
            x, y = x + w / 2, y + h / 2
        a, b, c, d = self._scaled((x, y, w, h), size, is_back=True)
        numbers = (b, a, d, c) if self.is_yx else (a, b, c, d)
        return (score, *numbers) if self.is_score_first else (*numbers, score)

    def boxes(self, numbers: tuple[np.ndarray, ...], size: Box | None) -> tuple[Box, np.ndarray]:
        """x, y, w, h (px) and score from the four numbers and the score in their order.

        Parameters
        ----------
        size
            Width and height (px) of the picture of each box; not needed for pixels.
        """
        score, a, b, c, d = numbers if self.is_score_first else (numbers[4], *numbers[:4])
        x, y, w, h = self._scaled((b, a, d, c) if self.is_yx else (a, b, c, d), size)
        if self.kind == "corners":
            w, h = w - x, h - y
        elif self.kind == "centres":
            x, y = x - w / 2, y - h / 2
        return (x, y, w, h), score

    def _scaled(self, box: Box, size: Box | None, *, is_back: bool = False) -> Box:
        whole = UNITS[self.unit][0]
        if whole is None:
            return box
        assert size is not None
        width, height = size[0] / whole, size[1] / whole
        if is_back:
            width, height = 1 / width, 1 / height
        x, y, w, h = box
        return x * width, y * height, w * width, h * height


def parse_layout(text: str) -> BoxLayout:
    """The layout that a session file or a flag names.

    Raises
    ------
    SessionError
        If it is none.

    Examples
    --------
    >>> parse_layout("corners-yx-thousandths").text
    'top, left, bottom, right in thousandths of the picture'
    """
    pattern = rf"(score-)?({'|'.join(KINDS)})(-yx)?(?:-({'|'.join(filter(None, UNITS))}))?"
    match = re.fullmatch(pattern, text.strip().lower())
    if match is None:
        raise SessionError(
            f"boxes: expected {', '.join(KINDS)}, behind it -yx where the vertical number comes "
            f"first, and -{', -'.join(filter(None, UNITS))} where they are such, as in "
            f"corners-yx-shares; found {text!r}"
        )
    score, kind, yx, unit = match.groups(default="")
    return BoxLayout(kind, bool(yx), unit, bool(score))
