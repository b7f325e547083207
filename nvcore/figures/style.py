"""Shared look of figures: colours, dashes, texts, axes and layout, for light and dark pages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from textwrap import wrap
from typing import Any, Final, TypeAlias

import numpy as np
import plotly.graph_objects as go

from nvcore.common.palette import (
    TRUTH_COLOUR,
    X_COLOUR,
    Y_COLOUR,
    Scheme,
    Shade,
    Theme,
    rgb,
    scheme_of,
)
from nvcore.figures.marks import marks

Names: TypeAlias = tuple[str, str]
"""Names of X and Y."""

FONT: Final = "Source Sans, Source Sans Pro, sans-serif"
MAX_NAME: Final = 32
"""Maximum number of characters that are shown of a name from a file."""
EMPTY_LINE: Final = 42
"""Characters in a line of a figure without data: it may be in the sidebar."""
CONFIG: Final[dict[str, Any]] = {
    "displayModeBar": False,
    "displaylogo": False,
    "scrollZoom": False,
    "doubleClick": "reset",
    "showTips": False,
}
"""Plotly's configuration for every figure: no tool bar, double click resets the view."""
LOSS_COLOURS: Final[dict[Shade, tuple[str, ...]]] = {
    "light": ("#F1F3F6", "#D3B8E0", "#9A5FB5", "#4A1162"),
    "dark": ("#222933", "#5C3A73", "#A56CC4", "#F4DCFF"),
}
"""Colours from no loss to the largest, other than those of X and Y."""
LABEL_GAP_PX: Final = 5
"""Gap between the label of a row and its marks, which may begin at the axis."""
HEADING_PX: Final = 54
"""Height of a figure's title and subtitle."""
EDGE_PX: Final = 8
"""Gap between a figure's edge and its marks.

Labels and legend that need more room shrink the plot, which takes the browser as long as a second
drawing. So the known space is left free from the start.
"""
AXIS_PX: Final = 45
"""Height of an axis's labels and title."""
LETTER_PX: Final = 7.3
"""Approximate width of a letter of a label."""
HIDDEN_AXIS: Final = {"visible": False, "fixedrange": True}
CLEAR: Final = "rgba(0,0,0,0)"
LEGEND: Final[dict[str, Any]] = {
    "orientation": "h",
    "x": 0,
    "xref": "container",
    "xanchor": "left",
    "yref": "container",
    "yanchor": "top",
    "font": {"size": 12},
    "bgcolor": CLEAR,
}
"""Legend on the left below the heading, in as many rows as it needs."""
ENTITIES: Final = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", "{": "&#123;", "$": "&#36;"}
)


@dataclass(frozen=True)
class ChartLook:
    """Colours of one theme, and what is drawn in them."""

    ink: str
    muted: str
    grid: str
    pale: str
    surface: str
    x: str
    y: str
    truth: str
    scheme: Scheme

    def of(self, letter: str) -> str:
        """Return the colour of system "x" or "y", or of the "truth"."""
        colour: str = getattr(self, letter)
        return colour

    def dash(self, letter: str) -> str:
        """Return Plotly's dash of system "x" or "y", or of the "truth"."""
        return "dot" if letter == "truth" else self.scheme.style(letter).dash

    def symbol(self, letter: str) -> str:
        """Return Plotly's mark of system "x" or "y"."""
        return self.scheme.style(letter).symbol

    @property
    def dotted(self) -> dict[str, Any]:
        """A thin line of limits."""
        return {"color": self.muted, "width": 1, "dash": "dot"}

    def line(self, letter: str) -> dict[str, Any]:
        """Return a system's line in its colour and dash."""
        return {"width": 2.4, "color": self.of(letter), "dash": self.dash(letter)}

    def marker(self, letter: str, size: float, *, rim: float = 1) -> dict[str, Any]:
        """Return a system's marker in its colour and shape, with a rim of the page's colour."""
        line = {"width": rim, "color": self.surface}
        looks = {"color": self.of(letter), "symbol": self.symbol(letter)}
        return {**looks, "size": size, "line": line}

    def hatching(self, letter: str, size: float, solidity: float) -> dict[str, Any]:
        """Return Plotly's pattern of a system's hatched areas."""
        looks = {"shape": "/", "size": size, "solidity": solidity, "fillmode": "replace"}
        return looks | {"fgcolor": self.of(letter), "bgcolor": faded(self.of(letter), 0.08)}

    def marks(
        self, letter: str, system: str, size: float, x: Any, y: Any, texts: Any, **more: Any
    ) -> go.Scatter:
        """Return the markers of a system, in the legend by its label unless `more` has a name."""
        looks = {"name": system_label(letter, system), "marker": self.marker(letter, size)}
        return marks(x, y, texts, **(looks | more))

    @property
    def loss_scale(self) -> list[tuple[float, str]]:
        """Plotly's colour scale of losses and costs, 0 first."""
        colours = LOSS_COLOURS[self.scheme.shade]
        return list(zip(np.linspace(0, 1, len(colours)).tolist(), colours, strict=True))

    def axis(
        self, title: str = "", *, begins: float = 0, can_zoom: bool = False, **more: Any
    ) -> dict[str, Any]:
        """Return an axis whose `title` says the quantity and its unit, and where it `begins`.

        Its range is fixed unless it `can_zoom`.
        """
        text = title + begins_at(begins)
        return {
            "title": {"text": text, "font": {"size": 12, "color": self.muted}, "standoff": 8},
            "automargin": True,
            "fixedrange": None if can_zoom else True,
            "gridcolor": self.grid,
            "zeroline": False,
            "showline": False,
            "tickfont": {"size": 12, "color": self.muted},
            "ticks": "",
            **more,
        }

    def counts_axis(self, **more: Any) -> dict[str, Any]:
        """Return an upright axis of a number of encounters, from 0."""
        return self.axis("encounters", rangemode="tozero", tickformat=",d", **more)

    def rows_axis(self, labels: Sequence[str], *, room: float = 0.6, **more: Any) -> dict[str, Any]:
        """Return an upright axis of labelled rows, the first on top, with `room` at both ends."""
        rows: dict[str, Any] = {
            "range": [len(labels) - (1 - room), -room],
            "tickvals": np.arange(len(labels)),
            "ticktext": labels,
            "ticklabelstandoff": LABEL_GAP_PX,
        }
        return self.axis(**(rows | more))

    def cells_axis(self, title: str, labels: Sequence[str], **more: Any) -> dict[str, Any]:
        """Return an axis of cells with a label each."""
        ticks: dict[str, Any] = {"tickvals": list(range(len(labels))), "ticktext": labels}
        return self.axis(title, showgrid=False, **ticks, **more)

    def colour_bar(self, title: str, px: int, *, side: str = "right", **more: Any) -> Any:
        """Return a bar of that thickness for the colours of a map, with small letters if thin."""
        font = {"size": 11 if px < 12 else 12, "color": self.muted}
        looks = {"tickfont": font, "outlinewidth": 0, "thickness": px}
        name = {"title": {"text": title, "side": side, "font": font}} if title else {}
        return looks | name | more

    def layout(
        self, *, title: str = "", subtitle: str = "", height: int = 320, **more: Any
    ) -> dict[str, Any]:
        """Return the layout of a figure: transparent, title and legend on the left above the plot.

        Parameters
        ----------
        title, subtitle
            Content of the figure, and the number of frames or encounters behind it. Names in them
            must be escaped by `plain`.
        more
            Further layout settings, such as axes. They replace those given here; margin and legend
            are merged.
        """
        top = EDGE_PX + (HEADING_PX if title else 0)
        labels = more.get("yaxis", {}).get("ticktext", ())
        left = (
            EDGE_PX + LABEL_GAP_PX + LETTER_PX * max(map(len, labels)) if len(labels) else EDGE_PX
        )
        bottom = AXIS_PX if more.get("xaxis", {}).get("title", {}).get("text") else EDGE_PX
        margin = {"l": left, "r": 2 * EDGE_PX, "t": top, "b": bottom}
        font = {"family": FONT, "size": 13, "color": self.ink}
        second = f'<br><span style="font-size:12.5px;color:{self.muted}">{subtitle}</span>'
        return {
            "height": height,
            "autosize": True,
            "template": "none",
            "paper_bgcolor": CLEAR,
            "plot_bgcolor": CLEAR,
            "font": font,
            "title": {
                "text": f"{title}{second if subtitle else ''}",
                "font": {"size": 16, "color": self.ink},
                "x": 0,
                "xref": "container",
                "xanchor": "left",
                "y": 1,
                "yref": "container",
                "yanchor": "top",
                "pad": {"t": 20, "l": 4},
            },
            "legend": LEGEND | {"y": 1 - top / height} | more.pop("legend", {}),
            "margin": margin | more.pop("margin", {}),
            "hoverlabel": {
                "bgcolor": self.surface,
                "bordercolor": self.pale,
                "font": font,
                "align": "left",
            },
            "hovermode": "closest",
            **more,
        }

    def draw(self, traces: Any, **settings: Any) -> go.Figure:
        """Return a figure of traces with its `layout`."""
        return go.Figure(traces, self.layout(**settings))

    def empty(self, text: str, *, height: int = 200) -> go.Figure:
        """Draw a figure without data: a sentence that says why and what to do, also its name."""
        axes = {"xaxis": HIDDEN_AXIS, "yaxis": HIDDEN_AXIS}
        figure = self.draw([], height=height, meta=("", text), **axes)
        lines, place = "<br>".join(wrap(text, EMPTY_LINE)), {"x": 0.5, "y": 0.5}
        write(figure, lines, size=14, color=self.muted, xref="paper", yref="paper", **place)
        return figure


class _Looks(dict[Theme, ChartLook]):
    """Looks of both shades. A scheme has the look of its shade in the systems' own colours."""

    def __missing__(self, theme: Theme) -> ChartLook:
        scheme = scheme_of(theme)
        if any(scheme.names):  # no look of its own: names are many
            return self[scheme._replace(names=("", ""))]
        x, y = (scheme.style(letter).colour(scheme.shade) for letter in "xy")
        look = self[theme] = replace(self[scheme.shade], x=x, y=y, scheme=scheme)
        return look


PAGES: Final[dict[Shade, tuple[str, str, str, str, str]]] = {
    "light": ("#1F2630", "#57606A", "#E4E8ED", "#CBD2DA", "#FFFFFF"),
    "dark": ("#E6EAF0", "#A3AEBB", "#2A323D", "#46515F", "#151A21"),
}
"""Ink, muted ink, grid, pale lines and surface of a page."""
LOOK: Final = _Looks(
    (of, ChartLook(*page, X_COLOUR[of], Y_COLOUR[of], TRUTH_COLOUR[of], Scheme(of)))
    for of, page in PAGES.items()
)


def plain(text: object, *, max_length: int = MAX_NAME) -> str:
    """Escape a name from a file for Plotly, and cut long names in the middle.

    Markup, hover templates (``%{x}``) and formulas (``$...$``) lose their meaning; invisible
    characters become spaces.
    """
    printable = "".join(char if char.isprintable() else " " for char in str(text)).strip()
    if len(printable) > max_length:
        head = (max_length - 1) // 2
        printable = f"{printable[:head]}…{printable[len(printable) - (max_length - 1 - head) :]}"
    return printable.translate(ENTITIES)


def system_label(letter: str, name: str) -> str:
    """Return a system's name in legends, such as "X: FIR", as plain text."""
    return f"{letter.upper()}: {plain(name)}" if name else letter.upper()


def which_is_which(theme: Theme) -> str:
    """Return the names of X and Y, if known, as the end of a subtitle without a legend."""
    x, y = scheme_of(theme).names
    return f"; {system_label('x', x)}, {system_label('y', y)}" if x and y else ""


def faded(colour: str, opacity: float) -> str:
    """Return a colour ``#RRGGBB`` with an opacity of 0..1."""
    red, green, blue = rgb(colour)
    return f"rgba({red},{green},{blue},{opacity:g})"


def begins_at(low: float) -> str:
    """Return the end of the title of an axis, which says where it begins unless at 0.

    Examples
    --------
    >>> begins_at(0.6), begins_at(0.0)
    (', from 0.6', '')
    """
    return f", from {low:.2g}" if low > 0 else ""


def take_heading(figure: go.Figure) -> tuple[str, str]:
    """Take title and subtitle, as HTML, out of a figure with their room.

    As text of the page that the figure is on they wrap.
    """
    layout = figure.layout
    title, _, second = (layout.title.text or "").partition("<br><span")
    if title:
        height, top = layout.height - HEADING_PX, layout.margin.t - HEADING_PX
        if layout.legend.yref == "container":
            layout.legend.y = 1 - ((1 - layout.legend.y) * layout.height - HEADING_PX) / height
        else:
            top = EDGE_PX  # above the plot it makes the room that it needs
        layout.update(margin_t=top, height=height)
    figure.update_layout(title_text=None)
    return title, second.partition(">")[2].removesuffix("</span>")


def written(text: str, *, size: float, color: str, **place: Any) -> dict[str, Any]:
    """Return a text for a layout's ``annotations``, without an arrow unless `place` has one."""
    font = {"size": size, "color": color}
    return {"text": text, "showarrow": False, "font": font, **place}


def write(figure: go.Figure, text: str, *, size: float, color: str, **place: Any) -> None:
    """Add a text to a figure. Many are faster by `written`: Plotly checks all for each new one."""
    figure.add_annotation(**written(text, size=size, color=color, **place))
