"""One tree of an ICF model: what it asks, and the confidence that each answer gives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import plotly.graph_objects as go

from nvcore.figures.marks import still_line
from nvcore.figures.style import HIDDEN_AXIS, LOOK, draw, faded, plain, written
from nvcore.palette import Theme
from nvcore.wording import minus

if TYPE_CHECKING:
    from nvcore.detectors.icf.displays import Node, Tree

HEIGHT_PX: Final = 400
PLACES: Final = {"root": (4.0, 3.0), "left": (2.0, 1.65), "right": (6.0, 1.65)}
"""Middle of each question."""
LEAVES: Final = ((1.0, 0.3), (3.0, 0.3), (5.0, 0.3), (7.0, 0.3))
HIGHEST: Final = 0.9
"""Longer side of a window that is drawn beside a question, in units of the plot's height."""
SHAPE: Final = 0.75
"""Units across of what is as long as one upright, on a page of usual width."""
GAP: Final = 0.06
"""Between a window and its question."""
ANSWERS: Final = ("below", "at least")


def tree_plot(
    tree: Tree, *, theme: Theme, window: tuple[int, int], number: int, leaf: int | None = None
) -> go.Figure:
    """The three questions with their rectangles in the window, and the four leaves.

    Parameters
    ----------
    window
        Width and height of the classifier's window, px.
    number
        Of the tree, from 1.
    leaf
        Where the chosen window comes to, 0..3 from left to right; None: no window is chosen.
    """
    look = LOOK[theme]
    took = (
        set() if leaf is None else {("root", leaf // 2), (("left", "right")[leaf // 2], leaf % 2)}
    )
    traces, texts = [], []
    for name, ends in {
        "root": (PLACES["left"], PLACES["right"]),
        "left": LEAVES[:2],
        "right": LEAVES[2:],
    }.items():
        x, y = PLACES[name]
        for answer, (end_x, end_y) in enumerate(ends):
            is_taken = (name, answer) in took
            line = {
                "width": 3 if is_taken else 1.4,
                "color": look.y if is_taken else look.pale,
            }
            ends_y = [y - 0.48, end_y + (0.48 if name == "root" else 0.16)]
            traces.append(still_line([x, end_x], ends_y, ANSWERS[answer], line=line))
            where = {"x": (x + end_x) / 2, "y": sum(ends_y) / 2}
            anchor = {"xanchor": "right" if answer == 0 else "left", "xshift": 24 * answer - 12}
            texts.append(written(ANSWERS[answer], size=11, color=look.muted, **where, **anchor))
    shapes: list[dict[str, Any]] = []
    for name, node in {"root": tree.root, "left": tree.left, "right": tree.right}.items():
        shapes += _window(node, PLACES[name], window, theme)
        x, y = PLACES[name]
        texts.append(
            written(
                _question(node),
                size=12,
                color=look.ink,
                x=x + GAP,
                y=y,
                xanchor="left",
                align="left",
            )
        )
    for place, (value, (x, y)) in enumerate(zip(tree.leaves, LEAVES, strict=True)):
        is_reached = place == leaf
        text = minus(f"{value:+.3f}")
        text = f"<b>{text}</b>" if is_reached else text
        color = look.y if is_reached else look.ink
        texts.append(written(text, size=14, color=color, x=x, y=y))
    outcome = "" if leaf is None else "; the chosen window takes the thick way"
    return draw(
        traces,
        theme,
        title=f"Tree {number:,}",
        subtitle=f"what each leaf adds to the confidence{outcome}",
        height=HEIGHT_PX,
        showlegend=False,
        shapes=shapes,
        annotations=texts,
        xaxis={**HIDDEN_AXIS, "range": [0.4, 7.6]},
        yaxis={**HIDDEN_AXIS, "range": [0.05, 3.6]},
    )


def _question(node: Node) -> str:
    """What a node asks: mean of a channel, in units of its 0..1."""
    size = f"{node.right - node.left} × {node.bottom - node.top} px"
    if node.minus is None:
        return f"mean of {plain(node.channel)}<br>over {size}<br>{node.threshold:.3f}?"
    other = plain(node.minus[0])
    return (
        f"mean of {plain(node.channel)} minus<br>that of {other} (dotted), {size}"
        f"<br>{minus(f'{node.threshold:.3f}')}?"
    )


def _window(
    node: Node, place: tuple[float, float], window: tuple[int, int], theme: Theme
) -> list[dict[str, Any]]:
    """The window, and the rectangles in it."""
    look = LOOK[theme]
    width, height = window
    down = HIGHEST / max(height, width)
    across = SHAPE * down
    left, top = place[0] - GAP - across * width, place[1] + down * height / 2

    def part(sides: tuple[int, int, int, int], name: str, **more: Any) -> dict[str, Any]:
        return {
            "type": "rect",
            "name": name,
            "x0": left + across * sides[0],
            "x1": left + across * sides[2],
            "y0": top - down * sides[1],
            "y1": top - down * sides[3],
            **more,
        }

    parts = [part((0, 0, width, height), "window", line={"width": 1, "color": look.muted})]
    inside = {"width": 1.5, "color": look.x}
    sides = (node.left, node.top, node.right, node.bottom)
    parts.append(part(sides, "rectangle", fillcolor=faded(look.x, 0.5), line=inside))
    if node.minus is not None:
        _, *other = node.minus
        minuend = (other[0], other[1], other[2], other[3])
        parts.append(part(minuend, "subtracted", line={**inside, "dash": "dot"}))
    return parts
