"""Intermediate results of a model as arrays to draw: channels, window paths and trees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import ParameterError
from nvcore.pictures import Picture
from nvcore.subjects.detectors.icf.cascade import floors, passes
from nvcore.subjects.detectors.icf.channels import (
    Bytes,
    PyramidLevel,
    blurred,
    check_picture,
    equalised,
    integral_images,
    levels,
    planes_of,
    resized,
)
from nvcore.subjects.detectors.icf.detector import IcfDetector, ScoreMap
from nvcore.subjects.detectors.icf.features import values_at
from nvcore.subjects.detectors.icf.model import IcfModel
from nvcore.subjects.detectors.icf.settings import IcfSettings
from nvcore.subjects.detectors.icf.windows import Scene, is_background

Number = TypeVar("Number", bound=np.generic)

LEAST_IOU: Final = 0.5
"""Minimum IoU of a window with the object that it represents."""
MOST_CELLS: Final = 200
"""Maximum number of cells of a coarse map along each side."""


@dataclass(frozen=True, eq=False)
class CoarseMap:
    """Score map reduced to few cells for drawing. Each cell shows its highest window.

    Attributes
    ----------
    level
        Picture at that scale.
    step
        Windows per cell along each side.
    score, depth
        Same as in `ScoreMap`, (n_cells_down, n_cells_across).
    n_windows, n_through, n_features
        Total numbers of evaluated windows, accepted windows and evaluated features.
    """

    level: PyramidLevel
    step: int
    score: NDArray[np.float64]
    depth: NDArray[np.int32]
    n_windows: int
    n_through: int
    n_features: int


@dataclass(frozen=True, eq=False)
class WindowPath:
    """Running confidence of one window over the trees.

    Attributes
    ----------
    confidence
        Running sum after each tree, ignoring rejection; float64, (n_trees,).
    floor
        Minimum of the same sum, or in a hard cascade of the sum since the start of the stage, below
        which the window is rejected; float64, (n_trees,). -inf: no rejection.
    rejected_after
        Number of trees after which the window is rejected. None: it is accepted.
    leaf
        Leaf that the window reaches in each tree, 0..3 from left to right; int64, (n_trees,).
    """

    confidence: NDArray[np.float64]
    floor: NDArray[np.float64]
    rejected_after: int | None
    leaf: NDArray[np.int64]


@dataclass(frozen=True)
class Node:
    """Decision of a tree: go right if the mean of a channel over a rectangle is high enough.

    Attributes
    ----------
    channel, left, top, right, bottom
        Channel, and rectangle in the window, px.
    minus
        Same for the subtracted rectangle. None if there is none.
    threshold
        Minimum mean, or minimum difference of means, to go right, in units of the channel's 0..1.
    """

    channel: str
    left: int
    top: int
    right: int
    bottom: int
    minus: tuple[str, int, int, int, int] | None
    threshold: float


@dataclass(frozen=True)
class Tree:
    """Tree to draw: its decisions, and the confidence of each leaf from left to right."""

    root: Node
    left: Node
    right: Node
    leaves: tuple[float, ...]


def preparation(model: IcfModel, picture: Picture, scale: float) -> dict[str, Bytes]:
    """Return the picture at one scale and the results of its blur and equalisation, if enabled.

    Raises
    ------
    DetectorError
        If the model cannot process the picture.
    ParameterError
        If no window fits into the picture at that scale.
    """
    (level, *_), picture = _group_of(model, picture, scale, alone=True)
    small = resized(picture, level.width, level.height)
    steps = {"as it comes": small}
    if model.settings.blur:
        steps["after the blur"] = small = blurred(small, model.settings)
    if model.settings.clahe_clip > 0:
        steps["after CLAHE"] = equalised(small, model.settings)
    return steps


def channels_of(model: IcfModel, picture: Picture, scale: float) -> dict[str, Bytes]:
    """Return every channel by name at one scale as a run computes it: (h, w), 0..255.

    Errors as for `preparation`.
    """
    _, planes = _planes_at(model, picture, scale)
    return dict(zip(model.channels, planes, strict=True))


def usable_scales(settings: IcfSettings, width: int, height: int) -> tuple[float, ...]:
    """Return scales at which a picture of this size, px, holds a window. Errors as for `levels`."""
    return tuple(level.scale for group in levels(width, height, settings) for level in group)


def computed_scale(model: IcfModel, picture: Picture, scale: float) -> float:
    """Return the scale whose channels a run uses for this scale. Errors as for `preparation`."""
    return _group_of(model, picture, scale)[0][0].scale


def map_at(model: IcfModel, picture: Picture, scale: float) -> CoarseMap:
    """Return the results for the windows of one scale. Errors as for `preparation`."""
    return coarse_map(_windows_at(model, picture, scale))


def coarse_map(score_map: ScoreMap, most: int = MOST_CELLS) -> CoarseMap:
    """Reduce a map to at most `most` cells along each side."""
    step = max(1, -(-max(score_map.score.shape) // most))
    score = _highest(np.nan_to_num(score_map.score, nan=-np.inf), step, -np.inf)
    return CoarseMap(
        level=score_map.level,
        step=step,
        score=np.where(np.isneginf(score), np.nan, score),
        depth=_highest(score_map.depth, step, 0),
        n_windows=score_map.n_windows,
        n_through=int(np.isfinite(score_map.score).sum()),
        n_features=score_map.n_features,
    )


def window_path(
    model: IcfModel, picture: Picture, scale: float, row: int, column: int
) -> WindowPath:
    """Return the path of one window over the trees. Errors as for `preparation`.

    Parameters
    ----------
    row, column
        Position of the window in the grid of that scale.
    """
    level, planes = _planes_at(model, picture, scale)
    rows, columns = level.grid(model.settings)
    if not (0 <= row < rows and 0 <= column < columns):
        raise ParameterError(
            f"window {row}, {column}: at scale {scale:g} there are {rows} rows of {columns} windows"
        )
    base = (row * (level.width + 1) + column) * model.settings.stride
    values = values_at(integral_images(planes), np.array([base], np.int64), model.features)
    sums = model.trees.running_sums(values)
    lowest, _ = floors(model.settings, model.calibration)
    is_below = ~passes(model.settings, model.calibration, sums)[0]
    rejected = int(is_below.argmax()) + 1 if is_below.any() else None
    return WindowPath(sums[0], lowest, rejected, model.trees.leaves_of(values)[0])


def truth_paths(model: IcfModel, picture: Picture, boxes: NDArray[np.float64]) -> list[WindowPath]:
    """Return the paths of the windows nearest to objects, skipping objects that no window fits.

    Parameters
    ----------
    boxes
        Left, top, width, height, px of the picture; (n, 4). Only height and centre matter.

    Raises
    ------
    DetectorError, ParameterError
        As for `preparation` and `window_of`.
    """
    settings, height, width = model.settings, *picture.shape[:2]
    paths = []
    for x, y, w, h in boxes.tolist():
        wide = h * settings.aspect
        scale, row, column = window_of(model, width, height, (x + (w - wide) / 2, y, wide))
        ((level, *_), _) = _group_of(model, picture, scale, alone=True)
        window = level.boxes(np.array([row]), np.array([column]), settings)
        scene = Scene(picture, np.array([[x + (w - wide) / 2, y, wide, h]]))
        if not is_background(window, scene, most_shared=LEAST_IOU).any():
            paths.append(window_path(model, picture, scale, row, column))
    return paths


def rejected_paths(
    model: IcfModel, picture: Picture, boxes: NDArray[np.float64], scale: float
) -> list[WindowPath]:
    """Return the paths of up to six rejected background windows, from early to late rejection.

    The wanted rejection depths are spread evenly on a logarithmic scale. For each, the window with
    the nearest depth is taken.

    Parameters
    ----------
    boxes
        Objects, as in `truth_paths`. Windows on them are skipped.
    """
    windows = _windows_at(model, picture, scale)
    row, column = np.nonzero((windows.depth > 0) & np.isnan(windows.score))
    is_free = is_background(windows.level.boxes(row, column, model.settings), Scene(picture, boxes))
    row, column = row[is_free], column[is_free]
    if not len(row):
        return []
    depth = np.log(windows.depth[row, column])
    wanted = np.linspace(depth.min(), depth.max(), 6)
    nearest = np.unique([np.abs(depth - value).argmin() for value in wanted])
    return [window_path(model, picture, scale, int(row[k]), int(column[k])) for k in nearest]


def window_of(
    model: IcfModel, width: int, height: int, box: tuple[float, float, float]
) -> tuple[float, int, int]:
    """Return scale, row and column of the window that gave a box.

    Parameters
    ----------
    width, height
        Size of the picture, px.
    box
        Left, top and width, px of the picture.

    Raises
    ------
    ParameterError
        If no window fits into the picture.
    """
    settings = model.settings
    every = [level for group in levels(width, height, settings) for level in group]
    if not every:
        raise ParameterError("the picture is smaller than the window at every scale")
    left, top, wide = box
    level = min(every, key=lambda level: abs(settings.object_width * level.across - wide))
    rows, columns = level.grid(settings)
    across = (settings.window_width - settings.object_width) / 2
    down = (settings.window_height - settings.object_height) / 2
    places = (top / level.down - down, rows), (left / level.across - across, columns)
    row, column = (min(max(round(px / settings.stride), 0), n - 1) for px, n in places)
    return level.scale, row, column


def tree(model: IcfModel, index: int) -> Tree:
    """Return one tree of a model for drawing.

    Raises
    ------
    ParameterError
        If there is no such tree.
    """
    if not 0 <= index < len(model.trees):
        raise ParameterError(f"tree {index}: there are {len(model.trees)}, counted from 0")
    root, left, right = (_node(model, index, k) for k in range(3))
    return Tree(root, left, right, tuple(model.trees.leaves[index].tolist()))


def _group_of(
    model: IcfModel, picture: Picture, scale: float, *, alone: bool = False
) -> tuple[tuple[PyramidLevel, ...], Bytes]:
    """Return the picture, and a level preceded by the level whose channels a run uses for it.

    Parameters
    ----------
    alone
        Compute the channels at the scale itself in any case.
    """
    picture = check_picture(picture, model.is_colour)
    size = picture.shape[1], picture.shape[0]
    groups = levels(*size, model.run_with(scales=(float(scale),)).settings)
    if not groups:
        raise ParameterError(f"scale {scale:g}: the picture is smaller than the window there")
    if not alone:
        for first, *others in levels(*size, model.settings):
            groups += [(first, level) for level in others if level.scale == scale]
    return groups[-1], picture


def _windows_at(model: IcfModel, picture: Picture, scale: float) -> ScoreMap:
    """Return the results of a run for every window of a scale."""
    scales = tuple(level.scale for level in _group_of(model, picture, scale)[0])
    return IcfDetector(model.run_with(scales=scales)).score_maps(picture)[-1]


def _planes_at(model: IcfModel, picture: Picture, scale: float) -> tuple[PyramidLevel, Bytes]:
    """Return the level of a scale and its channels as a run computes them."""
    group, pixels = _group_of(model, picture, scale)
    *_, last = planes_of(pixels, group, model.settings, model.powers)
    return last


def _highest(values: NDArray[Number], step: int, least: float) -> NDArray[Number]:
    """Return the highest value of each square of `step` cells, padding with `least`."""
    rows, columns = (-(-side // step) for side in values.shape)
    padded = np.full((rows * step, columns * step), least, values.dtype)
    padded[: values.shape[0], : values.shape[1]] = values
    highest: NDArray[Number] = padded.reshape(rows, step, columns, step).max(axis=(1, 3))
    return highest


def _node(model: IcfModel, index: int, k: int) -> Node:
    feature = model.features[model.trees.feature[index, k]].tolist()
    (channel, *sides), (second, *other) = feature[:5], feature[5:]
    left, top, right, bottom = sides
    minus = None if second < 0 else (model.channels[second], *other)
    threshold = float(model.trees.threshold[index, k]) / (255 * (right - left) * (bottom - top))
    return Node(model.channels[channel], left, top, right, bottom, minus, threshold)
