"""Figures of detectors: boxes and score maps on a picture, and the trees of an ICF model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nvcore.common.extras import needs
from nvcore.common.palette import Theme, scheme_of
from nvcore.common.wording import count_text, minus
from nvcore.dataset.schema import DetectionState
from nvcore.metrics.matching import iou_of_pairs
from nvcore.pictures import Picture, jpeg, picture_address, stretch
from nvcore.pictures.stretch import STRETCH

with needs("report", "figures need"):
    import cv2
    import plotly.graph_objects as go

    from nvcore.figures.marks import click_markers, marks, outlines, still_line
    from nvcore.figures.style import HEADING_PX, HIDDEN_AXIS, LOOK, ChartLook, faded, plain, written

if TYPE_CHECKING:
    from nvcore.subjects.detectors.base import Detections
    from nvcore.subjects.detectors.icf.displays import CoarseMap, Node, Tree, WindowPath
    from nvcore.subjects.detectors.icf.settings import IcfSettings

WIDEST_PX: Final = 1280
"""Maximum width of a picture in a figure."""
SMALL_PX: Final = 320
"""Width of a picture that is one of several."""
ROW_PX: Final = 165
FEW_COLUMNS: Final = 3
WIDE_LABEL: Final = (0.16, 12)
NARROW_LABEL: Final = (0.38, 11)
"""Label height as a share of its picture's height and font size, by number of columns."""
BOXES_PX: Final = 560
SUPPRESSED: Final = 0.25
"""Opacity of suppressed boxes."""
MARK_PX: Final = (3, 8)
"""Size of the centre mark of the smallest and of large boxes."""
CHOSEN: Final = "#FFE600"
"""Colour of the selected box, distinct from those of truth and systems."""
OUTCOMES: Final = {
    DetectionState.MATCHED: "matched",
    DetectionState.FALSE_ALARM: "a false alarm",
    DetectionState.ABSORBED: "on ignored truth",
    DetectionState.BELOW: "of a class that does not count",
}
"""Text for the outcome of a box that counts in a comparison."""
MapOf: TypeAlias = Literal["trees", "confidence"]
MAP_TITLES: Final[dict[MapOf, str]] = {
    "trees": "Trees that each window came through",
    "confidence": "Confidence of the windows that came through",
}
OPACITY: Final = 0.9
"""Opacity of the highest value of a map. The lowest value is transparent."""
BAR_PX: Final = 40
TREES_PX: Final = 340
DASHES: Final = ("dot", "dash", "longdash")
"""Line dashes for the training rounds before the last one."""
QUESTIONS: Final = {"root": (4.0, 3.0), "left": (2.0, 1.65), "right": (6.0, 1.65)}
LEAVES: Final = ((1.0, 0.3), (3.0, 0.3), (5.0, 0.3), (7.0, 0.3))
"""Centre of each question and of each leaf of a tree, in plot units."""
HIGHEST: Final = 0.9
"""Longer side of the window drawn beside a question, in units of the plot's height."""
SHAPE: Final = 0.75
"""Horizontal units per vertical unit of equal length, on a page of usual width."""
GAP: Final = 0.06
"""Gap between a window and its question."""


def boxes_plot(
    picture: Picture,
    boxes: Detections,
    is_counting: NDArray[np.bool_],
    *,
    theme: Theme,
    threshold: float,
    title: str = "Boxes",
    truth: NDArray[np.float64] | None = None,
    ignored: NDArray[np.float64] | None = None,
    states: NDArray[np.int8] | None = None,
    size: tuple[float, float] | None = None,
    chosen: int | None = None,
) -> go.Figure:
    """Draw the boxes of one picture before and after suppression, beside the truth.

    The `customdata` of a box's centre mark is the row of the box in `boxes`.

    Parameters
    ----------
    picture
        Input of the detector.
    boxes
        Candidates in pixels of the picture (`nvcore.subjects.detectors.candidates`).
    is_counting
        Boxes that count at the current settings, shape (n,).
    theme
        Theme whose Y is the detector.
    threshold
        Minimum score of drawn boxes.
    truth
        Left, top, width and height of truth boxes, px of the recording, (n, 4). None: unknown.
    ignored
        Same for ignored truth, which causes neither misses nor false alarms. None: no boxes.
    states
        Outcome of each box that counts in a comparison (`nvcore.dataset.schema.DetectionState`;
        BELOW if its class does not count), int8, (n,). None: unknown.
    size
        Width and height of the recording, px. None: those of the picture.
    chosen
        Row of the highlighted box.
    """
    own_size = size or (float(picture.shape[1]), float(picture.shape[0]))
    sides = sides_in(boxes, picture, own_size)
    is_above = boxes.score >= threshold
    is_gone = is_above & ~is_counting
    # pictures are dark, whatever the page's background
    look = LOOK[scheme_of(theme)._replace(shade="dark")]
    faint = _outlines(sides[is_gone], "suppressed boxes", color=faded(look.y, SUPPRESSED), width=1)
    traces = [faint.update(showlegend=False)]
    if chosen is not None:  # filled, so that it is recognisable without colour
        outline = _outlines(sides[[chosen]], "chosen", color=CHOSEN, width=6)
        traces.append(outline.update(fill="toself", fillcolor=faded(CHOSEN, 0.25)))
    # legend entry; the line itself is too faint
    swatch = {"color": faded(look.y, 0.7), "width": 1.5, "showlegend": bool(is_gone.any())}
    traces.append(still_line([None], [None], "suppressed", **swatch))
    if truth is not None:
        traces.append(_outlines(truth, "truth", color=look.truth, width=1.5))
    # solid, as the dashes of the system's line are longer than a distant box
    traces.append(_outlines(sides[is_counting], "detected", color=look.y, width=2.4))
    if ignored is not None:
        traces.append(_outlines(ignored, "ignored", color=look.truth, width=1.5, dash="dot"))
    iou, middle = iou_with(sides, truth), sides[:, :2] + sides[:, 2:] / 2

    def in_the_middle(name: str, is_shown: NDArray[np.bool_]) -> dict[str, Any]:
        row, counts = np.flatnonzero(is_shown), name == "counting"
        texts = [
            box_text(boxes, k, iou=iou[k], is_counting=counts, states=states) for k in row.tolist()
        ]
        x, y = middle[row].T
        return {"x": x, "y": y, "texts": texts, "name": name, "customdata": row}

    # approximate size on the screen
    across_px = sides[is_counting, 2:].min(axis=1) * BOXES_PX / own_size[1]
    marker = {"size": np.clip(across_px / 2, *MARK_PX), "color": look.y}
    marker["line"] = {"width": 1, "color": look.surface}
    traces.append(click_markers(**in_the_middle("gone", is_gone)))
    on_top = in_the_middle("counting", is_counting)
    traces.append(marks(**on_top, showlegend=False, marker=marker))
    return LOOK[theme].draw(
        traces,
        title=title,
        subtitle=_counts(int(is_above.sum()), is_counting, truth, states),
        height=BOXES_PX,
        margin={"l": 0, "r": 0},
        legend={"bgcolor": look.surface, "font": {"size": 12, "color": look.ink}},
        **_below(picture, *own_size, can_zoom=True),
        dragmode="zoom",
        uirevision=f"{title} {own_size}",  # keep the zoom while thresholds change
    )


def sides_in(boxes: Detections, picture: Picture, size: tuple[float, float]) -> NDArray[np.float64]:
    """Return boxes of a picture as left, top, width, height in pixels of the recording, (n, 4).

    Parameters
    ----------
    size
        Width and height of the recording, px.
    """
    scale = size[0] / picture.shape[1], size[1] / picture.shape[0]
    in_picture = np.column_stack([boxes.x, boxes.y, boxes.w, boxes.h])
    sides: NDArray[np.float64] = in_picture * np.tile(scale, 2)
    return sides


def iou_with(sides: NDArray[np.float64], truth: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """Return each box's largest IoU with a box of the truth, (n,), NaN without truth."""
    if truth is None or not len(truth):
        return np.full(len(sides), np.nan)
    left, top, width, height = sides.T[:, :, np.newaxis]
    iou: NDArray[np.float64] = iou_of_pairs((left, top, width, height), tuple(truth.T)).max(axis=1)
    return iou


def box_text(
    boxes: Detections,
    k: int,
    *,
    iou: float,
    is_counting: bool,
    states: NDArray[np.int8] | None = None,
) -> str:
    """Describe one box: score, size, class, overlap with the truth, outcome in a comparison."""
    text = f"score {boxes.score[k]:.3g}, {boxes.w[k]:.0f} × {boxes.h[k]:.0f} px"
    text += "" if boxes.label is None else f", {plain(boxes.label[k])}"
    text += "" if np.isnan(iou) else f", IoU with the truth {iou:.2f}"
    if not is_counting:
        return f"{text}: suppressed"
    return text if states is None else f"{text}: {OUTCOMES[DetectionState(int(states[k]))]}"


def _counts(
    n_above: int,
    is_counting: NDArray[np.bool_],
    truth: NDArray[np.float64] | None,
    states: NDArray[np.int8] | None,
) -> str:
    """Return the number of boxes and of their outcomes in a comparison."""
    text = f"{count_text(n_above, 'box', 'boxes')} before suppression, "
    text += f"{int(is_counting.sum()):,} after"
    n_matched = 0
    if states is not None:
        of_state = np.bincount(states[is_counting], minlength=len(DetectionState))
        n_matched = int(of_state[DetectionState.MATCHED])
        text += f": {n_matched:,} matched, {of_state[DetectionState.FALSE_ALARM]:,} false"
        for other in (DetectionState.ABSORBED, DetectionState.BELOW):
            text += f", {of_state[other]:,} {OUTCOMES[other]}" if of_state[other] else ""
    if truth is not None:
        text += f"; the truth has {len(truth):,}"
        text += "" if states is None else f", {len(truth) - n_matched:,} missed"
    return text


def _outlines(sides: NDArray[np.float64], name: str, **line: Any) -> go.Scatter:
    """Return all boxes as one line."""
    left, top, width, height = sides.T
    path = outlines(left, left + width, top, top + height)
    return still_line(*path, name, showlegend=len(sides) > 0, **line)


def score_map_plot(
    windows: CoarseMap,
    settings: IcfSettings,
    picture: Picture,
    *,
    theme: Theme,
    of: MapOf = "trees",
) -> go.Figure:
    """Draw the windows of one scale over the picture, each at its middle.

    Parameters
    ----------
    windows
        Windows from `nvcore.subjects.detectors.icf.displays.map_at`.
    settings
        Settings of the run.
    of
        ``"trees"``: the number of trees that each window passed, on a logarithmic scale.
        ``"confidence"``: the confidence of windows that passed all trees.
    """
    look = LOOK[theme]
    height, width = picture.shape[:2]
    level, step = windows.level, windows.step
    place: dict[str, Any] = {"x": 0, "xanchor": "left", "y": 0, "yanchor": "top"}
    bar = look.colour_bar(of, 8, orientation="h", len=0.3, **place)
    values, unit, more = windows.score, "confidence %{z:.3g}", {}
    if of == "trees":
        values = np.log10(np.where(windows.depth > 0, windows.depth, np.nan))  # NaN: not looked at
        unit, more = "%{customdata} trees", {"customdata": windows.depth, "zmin": 0}
        ticks = [1, 10, 100, 1000, 10_000]
        bar |= {"tickvals": np.log10(ticks), "ticktext": [f"{tick:,}" for tick in ticks]}
    down, across = ((np.arange(n) * step + (step - 1) / 2) * settings.stride for n in values.shape)
    wide, high = settings.window_width, settings.window_height
    heat = go.Heatmap(
        x=(across + wide / 2) * level.across,
        y=(down + high / 2) * level.down,
        z=values.astype(np.float32),
        colorscale=[(share, faded(look.y, share * OPACITY)) for share in (0.0, 0.5, 1.0)],
        colorbar=bar,
        hovertemplate=f"{unit}<extra></extra>",
        name=MAP_TITLES[of],
        **more,
    )
    return look.draw(
        heat,
        title=MAP_TITLES[of],
        subtitle=f"scale {level.scale:g}: {count_text(windows.n_windows, 'window')} of "
        f"{wide * level.across:.0f} × {high * level.down:.0f} px, "
        f"{windows.n_through:,} came through",
        height=460,
        margin={"l": 0, "r": 0, "b": BAR_PX},
        **_below(picture, width, height),
    )


def pictures_plot(
    pictures: Mapping[str, Picture],
    *,
    theme: Theme,
    title: str,
    subtitle: str = "",
    columns: int = 5,
    stretched: bool = False,
) -> go.Figure:
    """Draw small pictures side by side, each below its name.

    Parameters
    ----------
    pictures
        8-bit pictures of equal shape.
    stretched
        Stretch the contrast of each picture, as most gradients are faint.
    """
    look = LOOK[theme]
    height, width = next(iter(pictures.values())).shape[:2]
    columns = min(columns, len(pictures))
    rows = -(-len(pictures) // columns)
    share, size = WIDE_LABEL if columns <= FEW_COLUMNS else NARROW_LABEL
    label = share * height
    across, down = 1.04 * width, label + height + 0.04 * height
    corner, color = {"xanchor": "left", "yanchor": "bottom", "xshift": -2}, look.ink
    images, labels = [], []
    for index, (name, picture) in enumerate(pictures.items()):
        place = {"x": index % columns * across, "y": index // columns * down + label}
        shown = stretch(picture, 0, STRETCH[1]) if stretched else picture
        images.append(_layer(shown, SMALL_PX, width, height, **place))
        labels.append(written(plain(name), size=size, color=color, **corner, **place))
    return look.draw(
        [],
        title=title,
        subtitle=subtitle,
        height=HEADING_PX + 12 + ROW_PX * rows,
        margin={"l": 0, "r": 0},
        showlegend=False,
        images=images,
        annotations=labels,
        **_picture_axes(columns * across - 0.04 * width, rows * down),
    )


def _below(picture: Picture, width: float, height: float, **more: bool) -> dict[str, Any]:
    """Return layout settings that draw a picture below the marks, stretched as in the viewer."""
    layer = _layer(stretch(picture, *STRETCH), WIDEST_PX, width, height)
    return {"images": [layer], **_picture_axes(width, height, **more)}


def _layer(
    picture: Picture, widest: int, width: float, height: float, **place: float
) -> dict[str, Any]:
    """Return an 8-bit picture for a layout's ``images``, with the given size in axis units."""
    rows, columns = picture.shape[:2]
    shown = np.ascontiguousarray(picture)
    if columns > widest:
        size = widest, max(1, round(rows * widest / columns))
        shown = cv2.resize(shown, size, interpolation=cv2.INTER_AREA)
    corner = {"xref": "x", "yref": "y", "x": 0, "y": 0, **place}
    extent = {"sizex": width, "sizey": height, "sizing": "stretch"}
    return {"source": picture_address(jpeg(shown)), "layer": "below", **corner, **extent}


def _picture_axes(width: float, height: float, *, can_zoom: bool = False) -> dict[str, Any]:
    """Return axes that preserve the aspect ratio of a picture, with rows pointing downwards."""
    common = {**HIDDEN_AXIS, "fixedrange": not can_zoom, "constrain": "domain"}
    return {
        "xaxis": {**common, "range": [0, width], "constraintoward": "left"},
        "yaxis": {**common, "range": [height, 0], "scaleanchor": "x", "constraintoward": "top"},
    }


def confidence_plot(path: WindowPath, *, theme: Theme) -> go.Figure:
    """Draw the running confidence of a window against the rejection trace.

    The line continues dotted after a rejection. A hard cascade compares the sum of each stage
    separately, so its floors are drawn at the end of each stage.
    """
    look, n_trees = LOOK[theme], len(path.confidence)
    trees, all_trees = np.arange(1, n_trees + 1), count_text(n_trees, "tree")
    end = path.rejected_after or n_trees
    line: dict[str, Any] = {"width": 2.4, "color": look.y}
    traces = [_over_trees(trees[:end], path.confidence[:end], "this window", line=line)]
    if end < n_trees:
        ahead = trees[end - 1 :], path.confidence[end - 1 :], "had it not been rejected"
        dotted: dict[str, Any] = {"color": look.y, "width": 1.4, "dash": "dot", "showlegend": None}
        traces.append(still_line(*ahead, **dotted))
    has_floor = np.isfinite(path.floor)
    if has_floor.any():
        is_trace = bool(has_floor.all())
        traces.append(
            _over_trees(
                trees[has_floor],
                path.floor[has_floor],
                "rejected below" if is_trace else "least sum of a stage by itself",
                hover="tree %{x}: rejected below %{y:.3g}",
                mode="lines" if is_trace else "markers",
                line={"width": 1.8, "color": look.ink, "dash": "dash"},
                marker={"symbol": "line-ew", "size": 12, "line": {"width": 2, "color": look.ink}},
            )
        )
    outcome = f"came through all {all_trees} with {path.confidence[-1]:.3g}"
    if path.rejected_after is not None:
        traces.append(_rejected([path], "rejected", size=11, color=look.ink))
        outcome = f"rejected after {end:,} of {all_trees}"
    return look.draw(
        traces,
        title="Running confidence of the window",
        subtitle=outcome,
        height=TREES_PX,
        xaxis=look.axis("trees", range=[0, n_trees + 1]),
        yaxis=look.axis("confidence", zeroline=True, zerolinecolor=look.pale),
    )


def traces_plot(
    objects: Sequence[WindowPath], background: Sequence[WindowPath], *, theme: Theme
) -> go.Figure:
    """Draw the running confidence of windows on objects and background, until their rejection.

    Parameters
    ----------
    objects, background
        Windows of one model; each may be empty.
    """
    look, traces = LOOK[theme], []
    floor = next((path.floor for path in (*objects, *background)), np.array([np.nan]))
    if np.isfinite(floor).all():
        looks = {"width": 1.8, "color": look.ink, "dash": "dash", "showlegend": True}
        traces.append(still_line(np.arange(1, len(floor) + 1), floor, "rejected below", **looks))
    for name, windows, width, color in (
        ("objects", objects, 2, look.y),
        ("background", background, 1.4, look.muted),
    ):
        runs = [path.confidence[: path.rejected_after] for path in windows]
        x = [of for run in runs for of in (np.arange(1.0, len(run) + 1), [np.nan])]
        y = [of for run in runs for of in (run, [np.nan])]
        traces += [
            _over_trees(
                np.concatenate([*x, []]),
                np.concatenate([*y, []]),
                name,
                hover=f"{name}, tree %{{x}}: %{{y:.3g}}",
                line={"width": width, "color": color},
            ),
            _rejected(windows, f"{name}, rejected", size=9, color=color),
        ]
    n_through = sum(path.rejected_after is None for path in objects)
    return look.draw(
        traces,
        title="Objects and background over the trees",
        subtitle=f"{n_through} of {count_text(len(objects), 'object')} came through; "
        f"{count_text(len(background), 'window')} of background rejected",
        height=TREES_PX,
        xaxis=look.axis("trees, logarithmic", type="log", dtick="D2"),
        yaxis=look.axis("confidence", zeroline=True, zerolinecolor=look.pale),
    )


def training_plot(error: np.ndarray, round_ends: np.ndarray, *, theme: Theme) -> go.Figure:
    """Draw the training error over the trees of each round. Lower is better.

    Parameters
    ----------
    error
        Share of the training windows on the wrong side of 0 after each tree, for all rounds one
        after another (`IcfModel.error`).
    round_ends
        Index in `error` at which each round ends.
    """
    look, rounds = LOOK[theme], np.split(error, round_ends[:-1])
    earlier = [{"dash": dash, "width": 1.6, "color": look.muted} for dash in DASHES]
    lines = [earlier[number % len(DASHES)] for number in range(len(rounds) - 1)]
    lines.append({"dash": "solid", "width": 2.4, "color": look.x})
    traces = [
        _over_trees(
            np.arange(1, len(errors) + 1),
            errors,
            f"round {number}: {count_text(len(errors), 'tree')}",
            hover=f"round {number}, tree %{{x}}: %{{y:.3%}}",
            line=line,
        )
        for number, (errors, line) in enumerate(zip(rounds, lines, strict=True), start=1)
    ]
    return look.draw(
        traces,
        title="Training error over the rounds",
        subtitle="each round begins anew, with the background that the last one took for objects",
        height=TREES_PX,
        xaxis=look.axis("trees of the round", rangemode="tozero"),
        yaxis=look.axis("training error", rangemode="tozero", tickformat=".0%"),
    )


def _over_trees(
    x: np.ndarray, y: np.ndarray, name: str, *, hover: str = "tree %{x}: %{y:.3g}", **more: Any
) -> go.Scatter:
    """Return a line over the trees."""
    hover += "<extra></extra>"
    return marks(x, y, None, hover=hover, name=name, **{"mode": "lines", **more})


def _rejected(windows: Sequence[WindowPath], name: str, *, size: float, color: str) -> go.Scatter:
    """Return crosses at the trees that rejected the windows."""
    ends = [(end, path.confidence[end - 1]) for path in windows if (end := path.rejected_after)]
    x, y = zip(*ends, strict=True) if ends else ((), ())
    texts = [f"rejected after {count_text(end, 'tree')}" for end in x]
    return marks(x, y, texts, name=name, marker={"symbol": "x", "size": size, "color": color})


def tree_plot(
    tree: Tree, *, theme: Theme, window: tuple[int, int], number: int, leaf: int | None = None
) -> go.Figure:
    """Draw a tree: three questions with their rectangles in the window, and four leaves.

    Parameters
    ----------
    window
        Width and height of the classifier's window, px.
    number
        Number of the tree, from 1.
    leaf
        Leaf that the selected window reaches, 0..3 from left to right. None: no selection.
    """
    look = LOOK[theme]
    taken = () if leaf is None else (("root", leaf // 2), (("left", "right")[leaf // 2], leaf % 2))
    thick, thin = (look.y, 3), (look.pale, 1.4)
    lines, answers, questions = [], [], []
    shapes: list[dict[str, Any]] = []
    for name, node, ends, below in (
        ("root", tree.root, (QUESTIONS["left"], QUESTIONS["right"]), 0.48),
        ("left", tree.left, LEAVES[:2], 0.16),
        ("right", tree.right, LEAVES[2:], 0.16),
    ):
        x, y = QUESTIONS[name]
        for side, (end_x, end_y) in enumerate(ends):
            answer, anchor = (("below", "right"), ("at least", "left"))[side]
            color, width = thick if (name, side) in taken else thin
            ends_y = [y - 0.48, end_y + below]
            lines.append(still_line([x, end_x], ends_y, answer, color=color, width=width))
            middle = {"x": (x + end_x) / 2, "y": sum(ends_y) / 2, "xshift": 24 * side - 12}
            answers.append(written(answer, size=11, color=look.muted, xanchor=anchor, **middle))
        shapes += _window(node, (x, y), window, look)
        left = {"xanchor": "left", "align": "left"}
        questions.append(written(_question(node), size=12, color=look.ink, x=x + GAP, y=y, **left))
    leaves = []
    for index, (value, (x, y)) in enumerate(zip(tree.leaves, LEAVES, strict=True)):
        text, color = minus(f"{value:+.3f}"), look.ink
        if index == leaf:
            text, color = f"<b>{text}</b>", look.y
        leaves.append(written(text, size=14, color=color, x=x, y=y))
    outcome = "" if leaf is None else "; the chosen window takes the thick way"
    return look.draw(
        lines,
        title=f"Tree {number:,}",
        subtitle=f"what each leaf adds to the confidence{outcome}",
        height=400,
        showlegend=False,
        shapes=shapes,
        annotations=[*answers, *questions, *leaves],
        xaxis={**HIDDEN_AXIS, "range": [0.4, 7.6]},
        yaxis={**HIDDEN_AXIS, "range": [0.05, 3.6]},
    )


def _question(node: Node) -> str:
    """Return a node's question about the mean of a channel in the range 0..1."""
    size = f"{node.right - node.left} × {node.bottom - node.top} px"
    if node.minus is None:
        return f"mean of {plain(node.channel)}<br>over {size}<br>{node.threshold:.3f}?"
    both = f"{plain(node.channel)} minus<br>that of {plain(node.minus[0])} (dotted)"
    return f"mean of {both}, {size}<br>{minus(f'{node.threshold:.3f}')}?"


def _window(
    node: Node, place: tuple[float, float], window: tuple[int, int], look: ChartLook
) -> list[dict[str, Any]]:
    """Return the shapes of the window and of its rectangles."""
    (width, height) = window
    down = HIGHEST / max(height, width)
    across = SHAPE * down
    left, top = place[0] - GAP - across * width, place[1] + down * height / 2
    inside = {"width": 1.5, "color": look.x}
    looks: dict[str, dict[str, Any]] = {
        "window": {"line": {"width": 1, "color": look.muted}},
        "rectangle": {"fillcolor": faded(look.x, 0.5), "line": inside},
        "subtracted": {"line": {**inside, "dash": "dot"}},
    }
    rectangles: list[Sequence[Any]] = [
        ("window", 0, 0, width, height),
        ("rectangle", node.left, node.top, node.right, node.bottom),
        *([] if node.minus is None else [("subtracted", *node.minus[1:])]),
    ]
    return [
        {
            "type": "rect",
            "name": name,
            "x0": left + across * x0,
            "x1": left + across * x1,
            "y0": top - down * y0,
            "y1": top - down * y1,
            **looks[name],
        }
        for name, x0, y0, x1, y1 in rectangles
    ]
