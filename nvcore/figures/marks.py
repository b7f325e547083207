"""Lines and points that several figures draw."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import plotly.graph_objects as go

from nvcore.figures.style import LOOK
from nvcore.palette import Theme

HOVER: Final = "%{text}<extra></extra>"
"""Template of hover texts that are given for each point."""


def with_gaps(*corners: np.ndarray) -> np.ndarray:
    """Return the corners of many lines as one path, with NaN between them."""
    path: np.ndarray = np.column_stack([*corners, np.full(len(corners[0]), np.nan)]).ravel()
    return path


def still_line(
    x: Any, y: Any, name: str | None, *, showlegend: bool | None = False, **more: Any
) -> Any:
    """Return a line that does not answer to the mouse, with ``line`` or ``fillcolor`` in `more`."""
    return go.Scatter(
        x=x, y=y, name=name, mode="lines", hoverinfo="skip", showlegend=showlegend, **more
    )


def marks(x: Any, y: Any, texts: Any, *, hover: str = HOVER, **more: Any) -> go.Scatter:
    """Return markers, each with a text for the mouse, or points of another ``mode``."""
    return go.Scatter(x=x, y=y, text=texts, hovertemplate=hover, **{"mode": "markers", **more})


def system_marker(letter: str, size: float, theme: Theme, *, rim: float = 1) -> dict[str, Any]:
    """Return a system's marker in its colour and shape, with a rim of the page's colour."""
    look = LOOK[theme]
    line = {"width": rim, "color": look.surface}
    return {"color": look.of(letter), "size": size, "symbol": look.symbol(letter), "line": line}


def click_markers(x: Any, y: Any, texts: Any, **more: Any) -> go.Scatter:
    """Return invisible markers: Plotly reports clicks on markers only, not on lines or areas.

    All answer to the mouse. One is drawn, as hundreds would take longer than all the rest.
    """
    looks = {"opacity": 0, "size": 8, "color": "#000", "maxdisplayed": 1}
    return marks(x, y, texts, showlegend=False, marker=looks, **more)


def line_up(figure: go.Figure, x: float, name: str, theme: Theme) -> None:
    """Add a line over the whole height at `x`."""
    rule(figure, "x", x, name=name, line={"color": LOOK[theme].ink, "width": 1.5})


def row_texts(template: str, **columns: Any) -> list[str]:
    """Fill a template once for each row of columns of one length. A text is the same in all rows.

    Examples
    --------
    >>> row_texts("{who} {track}: {left:.1f} s", who="pedestrian", track=[3, 8], left=[1.25, 0])
    ['pedestrian 3: 1.2 s', 'pedestrian 8: 0.0 s']
    """
    texts = {name: value for name, value in columns.items() if isinstance(value, str)}
    names = [name for name in columns if name not in texts]
    rows = zip(*(columns[name] for name in names), strict=True)
    return [template.format(**texts, **dict(zip(names, row, strict=True))) for row in rows]


def rule(
    figure: go.Figure,
    direction: str,
    at: float,
    *,
    ref: str | None = None,
    over: str = "paper",
    **looks: Any,
) -> None:
    """Draw a line at one value of the axis `direction` ("x" or "y"), over all of `over`."""
    other = "y" if direction == "x" else "x"
    ends = {f"{direction}0": at, f"{direction}1": at, f"{direction}ref": ref}
    ends |= {f"{other}0": 0, f"{other}1": 1, f"{other}ref": over}
    figure.add_shape(type="line", **looks, **ends)


def system_line(letter: str, theme: Theme) -> dict[str, Any]:
    """Return a system's line in its colour and dash."""
    return {"width": 2.4, "color": LOOK[theme].of(letter), "dash": LOOK[theme].dash(letter)}


def curve_line(x: Any, y: Any, texts: Any, **looks: Any) -> go.Scatter:
    """Return a line with a marker at each value, each with a text for the mouse."""
    return marks(x, y, texts, **{"mode": "lines+markers", "cliponaxis": False, **looks})
