"""The colours and lines of the systems and the truth: the same in every figure, picture and video.

They belong to a system, by its place in the session: whether it is compared as X or as Y changes
none of them. Colour-blind people can tell them apart; dash and mark distinguish them a second time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

Shade = Literal["light", "dark"]


class SystemStyle(NamedTuple):
    """How one system is drawn.

    Attributes
    ----------
    name
        The colour in a word.
    light, dark
        The colour on a light and on a dark ground.
    line
        The line in a word: solid, dashed ...
    dash, css
        The same for Plotly and for CSS.
    pattern
        Lengths of dashes and gaps around boxes, px; empty: solid.
    symbol
        Plotly's mark.
    """

    name: str
    light: str
    dark: str
    line: str
    dash: str
    css: str
    pattern: tuple[int, ...]
    symbol: str

    def colour(self, shade: Shade) -> str:
        """The colour on this ground."""
        return self.light if shade == "light" else self.dark

    @property
    def words(self) -> str:
        """Line and colour: "solid blue"."""
        return f"{self.line} {self.name}"


STYLES: Final = (
    SystemStyle("blue", "#0067B1", "#4DA3FF", "solid", "solid", "solid", (), "circle"),
    SystemStyle("orange", "#C45A00", "#FFA033", "dashed", "dash", "dashed", (6, 4), "diamond"),
    SystemStyle(
        *("green", "#1B7F4B", "#4CC38A", "long-dashed"),
        *("longdash", "dashed", (12, 4), "pentagon"),
    ),
    SystemStyle(
        *("magenta", "#B0307A", "#F478B8", "dash-dotted"),
        *("dashdot", "double", (8, 3), "cross"),
    ),
    SystemStyle("teal", "#00767A", "#45CBCB", "dotted", "dot", "dotted", (2, 3), "star"),
)
"""Of the systems of a session in their order; those of a longer session begin again."""

X_COLOUR: Final[dict[Shade, str]] = {"light": STYLES[0].light, "dark": STYLES[0].dark}
"""The first system, which is X unless another is chosen."""

Y_COLOUR: Final[dict[Shade, str]] = {"light": STYLES[1].light, "dark": STYLES[1].dark}
"""The second."""

TRUTH_COLOUR: Final[dict[Shade, str]] = {"light": "#3D4650", "dark": "#E6EAF0"}
"""Ground truth, drawn thin."""


class Scheme(NamedTuple):
    """A shade, which of the `STYLES` X and Y have, and what they are called, where it is known."""

    shade: Shade
    x: int = 0
    y: int = 1
    names: tuple[str, str] = ("", "")

    def style(self, letter: str) -> SystemStyle:
        """How ``x`` or ``y`` is drawn."""
        return STYLES[self.x if letter == "x" else self.y]


Theme = Shade | Scheme
"""What figures are drawn in; a shade alone: X as the first system, Y as the second."""


def scheme_of(theme: Theme) -> Scheme:
    """The theme as a scheme."""
    return theme if isinstance(theme, Scheme) else Scheme(theme)


def scheme_for(shade: Shade, systems: Sequence[str], x: str, y: str | None) -> Scheme:
    """The scheme in which each system keeps what its place in the session gives it.

    Parameters
    ----------
    systems
        Names of all systems of the session, in order.

    Examples
    --------
    >>> scheme_for("light", ["FIR", "NIR"], "NIR", "FIR")
    Scheme(shade='light', x=1, y=0, names=('NIR', 'FIR'))
    """
    places = {name: i % len(STYLES) for i, name in reversed([*enumerate(systems)])}
    of_x = places.get(x, 0)
    of_y = places.get(y or "", 1 if of_x == 0 else 0)
    of_y = (of_x + 1) % len(STYLES) if of_y == of_x else of_y
    return Scheme(shade, of_x, of_y, (x, y or ""))


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green, blue, 0..255.

    Examples
    --------
    >>> rgb("#0067B1")
    (0, 103, 177)
    """
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
