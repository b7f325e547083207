"""Lines and points that several figures draw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import plotly.graph_objects as go

HOVER: Final = "%{text}<extra></extra>"
"""Template of hover texts that are given for each point."""


def with_gaps(*corners: np.ndarray) -> np.ndarray:
    """Return the corners of many lines as one path, with NaN between them."""
    path: np.ndarray = np.column_stack([*corners, np.full(len(corners[0]), np.nan)]).ravel()
    return path


def outlines(left: Any, right: Any, top: Any, bottom: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y of one path around many rectangles."""
    return with_gaps(left, right, right, left, left), with_gaps(top, top, bottom, bottom, top)


def still_line(
    x: Any,
    y: Any,
    name: str | None,
    *,
    color: Any = None,
    width: Any = None,
    dash: Any = None,
    showlegend: Any = False,
    **more: Any,
) -> Any:
    """Return a line, or points of another ``mode``, that do not answer to the mouse.

    Parameters
    ----------
    showlegend
        None: shown in the legend of a figure that has one.
    """
    line = {"color": color, "width": width, "dash": dash}
    looks = {"mode": "lines", "hoverinfo": "skip", "line": line, "showlegend": showlegend}
    return go.Scatter(x=x, y=y, name=name, **(looks | more))


def joined(start: Any, stop: Any, row: np.ndarray, name: str, **looks: Any) -> go.Scatter:
    """Return a line from `start` to `stop` in each row."""
    return still_line(with_gaps(start, stop), with_gaps(row, row), name, **looks)


def band(x: np.ndarray, low: np.ndarray, high: np.ndarray, name: str, **more: Any) -> go.Scatter:
    """Return the area between two lines, without an outline unless `more` has one."""
    along, around = np.concatenate([x, x[::-1]]), np.concatenate([high, low[::-1]])
    return still_line(along, around, name, fill="toself", **({"width": 0} | more))


def marks(x: Any, y: Any, texts: Any, *, hover: str = HOVER, **more: Any) -> go.Scatter:
    """Return markers, each with a text for the mouse, or points of another ``mode``."""
    return go.Scatter(x=x, y=y, text=texts, hovertemplate=hover, **{"mode": "markers", **more})


def cells(values: np.ndarray, texts: Sequence[Sequence[str]], **more: Any) -> go.Heatmap:
    """Return a map whose cells say `texts`."""
    looks = {"texttemplate": "%{text}", "showscale": False, "xgap": 1, "ygap": 1}
    return go.Heatmap(z=values, text=texts, **looks, **more)


def click_markers(x: Any, y: Any, texts: Any, **more: Any) -> go.Scatter:
    """Return invisible markers: Plotly reports clicks on markers only, not on lines or areas.

    All answer to the mouse. One is drawn, as hundreds would take longer than all the rest.
    """
    looks = {"opacity": 0, "size": 8, "color": "#000", "maxdisplayed": 1}
    return marks(x, y, texts, showlegend=False, marker=looks, **more)


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
    color: str,
    width: float = 1.5,
    dash: str | None = None,
    ref: str | None = None,
    over: str = "paper",
    **more: Any,
) -> None:
    """Draw a line at one value of the axis `direction` ("x" or "y"), over all of `over`."""
    other = "y" if direction == "x" else "x"
    ends = {f"{direction}0": at, f"{direction}1": at, f"{direction}ref": ref}
    ends |= {f"{other}0": 0, f"{other}1": 1, f"{other}ref": over}
    line = {"color": color, "width": width, "dash": dash}
    figure.add_shape(type="line", line=line, **more, **ends)


def curve_line(x: Any, y: Any, texts: Any, **looks: Any) -> go.Scatter:
    """Return a line with a marker at each value, each with a text for the mouse."""
    return marks(x, y, texts, **{"mode": "lines+markers", "cliponaxis": False, **looks})
