"""Colours and line styles of systems and truth, the same in all figures, pictures and videos.

A style belongs to a system, by its position in the session, whether it is compared as X or as Y.
Colour-blind people can tell the colours apart. Dash and marker distinguish the systems as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

Shade = Literal["light", "dark"]


class SystemStyle(NamedTuple):
    """Drawing style of a system.

    Attributes
    ----------
    name
        Name of the colour.
    light, dark
        Colour on a light and on a dark background.
    line
        Name of the line style: solid, dashed ...
    dash, css
        Line style for Plotly and for CSS.
    pattern
        Lengths of dashes and gaps around boxes, px; empty for solid lines.
    symbol
        Marker in Plotly.
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
        """Return the colour for a background."""
        return self.light if shade == "light" else self.dark

    @property
    def words(self) -> str:
        """Line and colour, such as "solid blue"."""
        return f"{self.line} {self.name}"


STYLES: Final = (
    SystemStyle("blue", "#0067B1", "#4DA3FF", "solid", "solid", "solid", (), "circle"),
    SystemStyle("orange", "#C45A00", "#FFA033", "dashed", "dash", "dashed", (6, 4), "diamond"),
    SystemStyle(
        *("green", "#1B7F4B", "#4CC38A", "long-dashed"),
        *("longdash", "dashed", (12, 4), "pentagon"),
    ),
    SystemStyle(
        *("magenta", "#B0307A", "#F478B8", "dash-dotted"), *("dashdot", "double", (8, 3), "cross")
    ),
    SystemStyle("teal", "#00767A", "#45CBCB", "dotted", "dot", "dotted", (2, 3), "star"),
)
"""Styles by system, in session order; they repeat after the last one."""

X_COLOUR: Final[dict[Shade, str]] = {"light": STYLES[0].light, "dark": STYLES[0].dark}
"""Colour of the first system, which is X by default."""

Y_COLOUR: Final[dict[Shade, str]] = {"light": STYLES[1].light, "dark": STYLES[1].dark}
"""Colour of the second system, which is Y by default."""

TRUTH_COLOUR: Final[dict[Shade, str]] = {"light": "#3D4650", "dark": "#E6EAF0"}
"""Colour of the ground truth, drawn thin."""


class Scheme(NamedTuple):
    """Shade, indices of X and Y in `STYLES`, and their names if known."""

    shade: Shade
    x: int = 0
    y: int = 1
    names: tuple[str, str] = ("", "")

    def style(self, letter: str) -> SystemStyle:
        """Return the style of ``x`` or ``y``."""
        return STYLES[self.x if letter == "x" else self.y]


Theme = Shade | Scheme
"""Colours of figures. A shade alone draws X as the first system and Y as the second."""


def scheme_of(theme: Theme) -> Scheme:
    """Convert a theme to a scheme."""
    return theme if isinstance(theme, Scheme) else Scheme(theme)


def scheme_for(shade: Shade, systems: Sequence[str], x: str, y: str | None) -> Scheme:
    """Return the scheme in which each system keeps the style of its position in the session.

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
    """Return red, green and blue, 0..255.

    Examples
    --------
    >>> rgb("#0067B1")
    (0, 103, 177)
    """
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
