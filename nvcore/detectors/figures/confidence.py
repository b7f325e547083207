"""How the confidence of a window runs over the trees, and what would reject it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import plotly.graph_objects as go

from nvcore.figures.marks import marks, still_line
from nvcore.figures.style import LOOK, axis, draw
from nvcore.palette import Theme
from nvcore.wording import count_text

if TYPE_CHECKING:
    from nvcore.detectors.icf.displays import WindowPath

HEIGHT_PX: Final = 340


def confidence_plot(path: WindowPath, *, theme: Theme) -> go.Figure:
    """Running confidence of a window against the rejection trace.

    The line goes on, dotted, where the window was rejected before. A hard cascade compares the sum
    of each stage by itself: its floors are drawn where a stage ends.
    """
    look, n_trees = LOOK[theme], len(path.confidence)
    trees = np.arange(1, n_trees + 1)
    end = n_trees if path.rejected_after is None else path.rejected_after
    line: dict[str, Any] = {"width": 2.4, "color": look.y}
    traces = [
        go.Scatter(
            x=trees[:end],
            y=path.confidence[:end],
            mode="lines",
            line=line,
            name="this window",
            hovertemplate="tree %{x}: %{y:.3g}<extra></extra>",
        )
    ]
    if end < n_trees:
        rest = {**line, "width": 1.4, "dash": "dot"}
        traces.append(
            still_line(
                trees[end - 1 :],
                path.confidence[end - 1 :],
                "had it not been rejected",
                showlegend=None,
                line=rest,
            )
        )
    has_floor = np.isfinite(path.floor)
    if has_floor.any():
        is_trace = bool(has_floor.all())
        traces.append(
            go.Scatter(
                x=trees[has_floor],
                y=path.floor[has_floor],
                mode="lines" if is_trace else "markers",
                line={"width": 1.8, "color": look.ink, "dash": "dash"},
                marker={"symbol": "line-ew", "size": 12, "line": {"width": 2, "color": look.ink}},
                name="rejected below" if is_trace else "least sum of a stage by itself",
                hovertemplate="tree %{x}: rejected below %{y:.3g}<extra></extra>",
            )
        )
    if path.rejected_after is not None:
        place = [end], [path.confidence[end - 1]]
        text = [f"rejected after {count_text(end, 'tree')}"]
        marker = {"symbol": "x", "size": 11, "color": look.ink}
        traces.append(marks(*place, text, name="rejected", marker=marker))
        outcome = f"rejected after {end:,} of {count_text(n_trees, 'tree')}"
    else:
        outcome = f"came through all {count_text(n_trees, 'tree')} with {path.confidence[-1]:.3g}"
    return draw(
        traces,
        theme,
        title="Running confidence of the window",
        subtitle=outcome,
        height=HEIGHT_PX,
        xaxis=axis(theme, "trees", range=[0, n_trees + 1], fixedrange=True),
        yaxis=axis(theme, "confidence", fixedrange=True, zeroline=True, zerolinecolor=look.pale),
    )


def traces_plot(
    objects: Sequence[WindowPath], background: Sequence[WindowPath], *, theme: Theme
) -> go.Figure:
    """Running confidence of windows on objects and on background, until they are rejected.

    Parameters
    ----------
    objects, background
        Windows of one model; each may be empty.
    """
    look = LOOK[theme]
    kinds = (
        ("objects", objects, {"width": 2, "color": look.y}),
        ("background", background, {"width": 1.4, "color": look.muted}),
    )
    paths = [*objects, *background]
    traces = []
    if paths and np.isfinite(paths[0].floor).all():
        floor = paths[0].floor
        line = {"width": 1.8, "color": look.ink, "dash": "dash"}
        traces.append(still_line(np.arange(1, len(floor) + 1), floor, "rejected below", line=line))
        traces[-1].update(showlegend=True)
    for name, windows, line in kinds:
        ends = [path.rejected_after or len(path.confidence) for path in windows]
        x = [np.append(np.arange(1.0, end + 1), np.nan) for end in ends]
        y = [
            np.append(path.confidence[:end], np.nan)
            for path, end in zip(windows, ends, strict=True)
        ]
        traces.append(
            go.Scatter(
                x=np.concatenate([*x, np.empty(0)]),
                y=np.concatenate([*y, np.empty(0)]),
                mode="lines",
                line=line,
                name=name,
                hovertemplate=f"{name}, tree %{{x}}: %{{y:.3g}}<extra></extra>",
            )
        )
        out = [path.rejected_after is not None for path in windows]
        place = (
            [end for end, is_out in zip(ends, out, strict=True) if is_out],
            [
                path.confidence[end - 1]
                for path, end, is_out in zip(windows, ends, out, strict=True)
                if is_out
            ],
        )
        text = [f"rejected after {count_text(end, 'tree')}" for end in place[0]]
        marker = {"symbol": "x", "size": 9, "color": line["color"]}
        traces.append(marks(*place, text, name=f"{name}, rejected", marker=marker))
    n_through = sum(path.rejected_after is None for path in objects)
    return draw(
        traces,
        theme,
        title="Objects and background over the trees",
        subtitle=f"{n_through} of {count_text(len(objects), 'object')} came through; "
        f"{count_text(len(background), 'window')} of background rejected",
        height=HEIGHT_PX,
        xaxis=axis(theme, "trees, logarithmic", type="log", dtick="D2", fixedrange=True),
        yaxis=axis(theme, "confidence", fixedrange=True, zeroline=True, zerolinecolor=look.pale),
    )


def training_plot(error: np.ndarray, round_ends: np.ndarray, *, theme: Theme) -> go.Figure:
    """Training error over the trees of each round; lower is better, each round is harder.

    Parameters
    ----------
    error
        Share of the training's windows on the wrong side of 0 after each tree, all rounds one
        after another (`IcfModel.error`).
    round_ends
        Where each round ends in it.
    """
    look = LOOK[theme]
    starts = [0, *round_ends[:-1].tolist()]
    n_rounds = len(round_ends)
    dashes = ("dot", "dash", "longdash")
    traces = [
        go.Scatter(
            x=np.arange(1, end - start + 1),
            y=error[start:end],
            mode="lines",
            line={
                "width": 2.4 if number == n_rounds else 1.6,
                "color": look.x if number == n_rounds else look.muted,
                "dash": "solid" if number == n_rounds else dashes[(number - 1) % len(dashes)],
            },
            name=f"round {number}: {count_text(end - start, 'tree')}",
            hovertemplate=f"round {number}, tree %{{x}}: %{{y:.3%}}<extra></extra>",
        )
        for number, (start, end) in enumerate(
            zip(starts, round_ends.tolist(), strict=True), start=1
        )
    ]
    return draw(
        traces,
        theme,
        title="Training error over the rounds",
        subtitle="each round begins anew, with the background that the last one took for objects",
        height=HEIGHT_PX,
        xaxis=axis(theme, "trees of the round", rangemode="tozero", fixedrange=True),
        yaxis=axis(theme, "training error", rangemode="tozero", tickformat=".0%", fixedrange=True),
    )
