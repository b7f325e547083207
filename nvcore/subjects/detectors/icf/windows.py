"""Training windows: crops of objects, and background from the pyramid."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.pictures import Picture
from nvcore.subjects.detectors.icf.channels import (
    Bytes,
    PyramidLevel,
    channel_planes,
    check_picture,
    halved,
    integral_images,
    levels,
    planes_of,
)
from nvcore.subjects.detectors.icf.features import Features, values_at
from nvcore.subjects.detectors.icf.settings import IcfSettings

NO_BOXES: Final = np.empty((0, 4))
_MOST_SHARED: Final = 0.2
"""Maximum IoU with an object, or share inside an ignored region, of a background window."""
_MARGIN: Final = 4
"""Margin around a window that blur and gradients need, px."""
_BLOCK: Final = 256
_ON_A_SCALE: Final = 50
"""Number of windows of a picture drawn at one scale, as each scale takes time."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Training picture with its objects.

    Attributes
    ----------
    picture
        Grey (h, w) or RGB (h, w, 3), uint8 or uint16.
    boxes
        Left, top, width, height of the objects, px; (n, 4).
    ignored
        Same for regions that are neither object nor background; (n, 4).
    has_background
        Whether the rest of the picture is background to learn from. False for crops.
    labels
        Class of each box, "" if unknown. Empty: no classes.
    """

    picture: Picture
    boxes: NDArray[np.float64] = field(default_factory=lambda: NO_BOXES)
    ignored: NDArray[np.float64] = field(default_factory=lambda: NO_BOXES)
    has_background: bool = True
    labels: tuple[str, ...] = ()


class LazyScenes(Sequence[Scene]):
    """Scenes that are read on each request.

    Parameters
    ----------
    read
        Maps a scene number to its scene.
    numbers
        Numbers of the scenes, in order.
    """

    def __init__(self, read: Callable[[int], Scene], numbers: Sequence[int]) -> None:
        self._read, self._numbers = read, numbers

    def __len__(self) -> int:
        return len(self._numbers)

    def __getitem__(self, index: int) -> Scene:  # type: ignore[override]
        return self._read(self._numbers[index])


def object_values(
    scenes: Iterator[Scene], settings: IcfSettings, features: Features, is_colour: bool, seed: int
) -> NDArray[np.int32]:
    """Return the feature values of objects and their copies, int32, (n_windows, n_features)."""
    rng = np.random.default_rng(seed)
    values = [np.empty((0, len(features)), np.int32)]
    windows: list[Bytes] = []
    for scene in scenes:
        picture = check_picture(scene.picture, is_colour)
        for box in scene.boxes:
            windows += object_windows(picture, box, settings, rng)
        if len(windows) >= _BLOCK:
            values.append(window_values(windows, settings, features))
            windows = []
    if windows:
        values.append(window_values(windows, settings, features))
    return np.concatenate(values)


def object_windows(
    picture: Bytes, box: NDArray[np.float64], settings: IcfSettings, rng: np.random.Generator
) -> list[Bytes]:
    """Cut out the window around an object, by its height and centre, and distorted copies.

    Each result has a margin of 4 px on every side of the window.
    """
    x, y, w, h = (float(value) for value in box)
    scale = h / settings.object_height
    windows = [_cut(picture, x + w / 2, y + h / 2, scale, settings)]
    ratios = np.diff(np.log(settings.scales))
    step = float(np.median(ratios)) / 2 if len(ratios) else 0.0
    for i in range(settings.copies):
        dx, dy = rng.uniform(-0.5, 0.5, 2) * settings.stride * scale
        factor = float(np.exp(rng.uniform(-step, step)))
        shrunk = scale
        if settings.least_object_px and i % 2 == 0:
            low = min(settings.least_object_px, h, settings.object_height)
            height = np.exp(rng.uniform(np.log(low), np.log(min(h, settings.object_height))))
            shrunk = h / float(height)
        window = _cut(picture, x + w / 2 + dx, y + h / 2 + dy, scale * factor, settings, shrunk)
        windows.append(window[:, ::-1] if settings.mirrored and i % 2 == 0 else window)
    return windows


def window_values(
    windows: list[Bytes], settings: IcfSettings, features: Features
) -> NDArray[np.int32]:
    """Return the feature values of windows with a margin of 4 px, int32, (n, n_features)."""
    inside = slice(_MARGIN, -_MARGIN)
    every = (channel_planes(np.ascontiguousarray(window), settings) for window in windows)
    sums = np.stack([integral_images(planes[:, inside, inside].copy()) for planes in every])
    base = np.arange(len(windows), dtype=np.int64) * sums[0].size
    return values_at(sums, base, features)


def random_background(
    scene: Scene,
    settings: IcfSettings,
    features: Features,
    is_colour: bool,
    n: int,
    rng: np.random.Generator,
) -> NDArray[np.int32]:
    """Return the feature values of at most `n` random background windows at random scales."""
    picture = check_picture(scene.picture, is_colour)
    height, width = picture.shape[:2]
    singly = [level for group in levels(width, height, settings) for level in group]
    values = [np.empty((0, len(features)), np.int32)]
    if not singly:
        return values[0]
    area = np.array([np.prod(level.grid(settings)) for level in singly], float)
    n_levels = min(-(-n // _ON_A_SCALE), len(singly))
    # most windows show small objects, so small scales are drawn more often, though less than that
    drawn = rng.choice(len(singly), n_levels, replace=False, p=np.sqrt(area) / np.sqrt(area).sum())
    for i in np.sort(drawn):
        level = singly[i]
        rows, columns = level.grid(settings)
        windows = rng.integers(0, rows * columns, -(-n // n_levels))
        row, column = np.divmod(np.unique(windows), columns)
        is_free = is_background(level.boxes(row, column, settings), scene)
        values.append(
            level_values(picture, level, row[is_free], column[is_free], settings, features)
        )
    return np.concatenate(values)[:n]


def level_values(
    picture: Bytes,
    level: PyramidLevel,
    row: NDArray[np.int64],
    column: NDArray[np.int64],
    settings: IcfSettings,
    features: Features,
) -> NDArray[np.int32]:
    """Return the feature values of windows of one level, int32, (n, n_features)."""
    if not len(row):
        return np.empty((0, len(features)), np.int32)
    ((_, planes),) = planes_of(picture, (level,), settings, np.empty(0))
    base = (row * (level.width + 1) + column) * settings.stride
    return values_at(integral_images(planes), base.astype(np.int64), features)


def is_background(
    boxes: NDArray[np.float64], scene: Scene, most_shared: float = _MOST_SHARED
) -> NDArray[np.bool_]:
    """Return a mask of boxes that overlap no object (IoU of at most 0.2) and no ignored region.

    Parameters
    ----------
    boxes
        Left, top, width, height; (4, n).
    most_shared
        Another maximum IoU.
    """
    is_free = np.ones(boxes.shape[1], np.bool_)
    area = boxes[2] * boxes[3]
    for box in scene.boxes:
        shared = _shared(boxes, box)
        is_free &= shared <= most_shared * (area + box[2] * box[3] - shared)
    for box in scene.ignored:
        is_free &= _shared(boxes, box) <= _MOST_SHARED * area
    return is_free


def _shared(boxes: NDArray[np.float64], box: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the intersection area of each box with another box, px²."""
    corner, size = boxes[:2], boxes[2:]
    ends = np.minimum(corner + size, (box[:2] + box[2:])[:, None])
    sides = np.maximum(ends - np.maximum(corner, box[:2, None]), 0.0)
    shared: NDArray[np.float64] = sides[0] * sides[1]
    return shared


def _cut(
    picture: Bytes, x: float, y: float, scale: float, settings: IcfSettings, shrunk: float = 0.0
) -> Bytes:
    """Cut out a window with its margin, centred at x, y, with `scale` px of the picture per px.

    Edge pixels are repeated outside the picture.

    Parameters
    ----------
    shrunk
        If larger than `scale`, the picture is first shrunk by this factor and loses detail.
    """
    width = settings.window_width + 2 * _MARGIN
    height = settings.window_height + 2 * _MARGIN
    if shrunk > scale:
        w, h = round(width * scale / shrunk) + 2, round(height * scale / shrunk) + 2
        small = _sampled(picture, x, y, shrunk, w, h)
        return _sampled(small, w / 2, h / 2, scale / shrunk, width, height)
    return _sampled(picture, x, y, scale, width, height)


def _sampled(picture: Bytes, x: float, y: float, scale: float, width: int, height: int) -> Bytes:
    """Interpolate width x height px around a point, with `scale` px of the picture per px.

    Pixel centres are at 0.5. Pictures are halved first, as for the pyramid.
    """
    left, top = int(np.floor(x - width * scale)), int(np.floor(y - height * scale))
    left, top = max(left, 0), max(top, 0)
    part = picture[top : int(y + height * scale) + 2, left : int(x + width * scale) + 2]
    if not part.size:  # the box is outside the picture
        part, left, top = picture, 0, 0
    whole = part.shape[1]
    part = halved(np.ascontiguousarray(part), part.shape[1] / scale, part.shape[0] / scale)
    ratio = part.shape[1] / whole
    step = scale * ratio
    x0 = (x - left) * ratio - width * step / 2 + step / 2 - 0.5
    y0 = (y - top) * ratio - height * step / 2 + step / 2 - 0.5
    matrix = np.array([[step, 0, x0], [0, step, y0]])
    return np.asarray(
        cv2.warpAffine(
            part,
            matrix,
            (width, height),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
    )
