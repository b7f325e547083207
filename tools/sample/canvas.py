"""Antialiased drawing of polygons and sprites on a grey picture, far objects first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.sample.camera import HEIGHT, WIDTH, Camera, Floats

Picture = NDArray[np.float32]
Shape = tuple[Floats, float]
"""Polygon in pixels, shape (corners, 2), and its grey level."""

NEAR_M: Final = 0.8
FRACTION_BITS: Final = 4
"""Sub-pixel bits of cv2's drawing."""


def project_polygon(camera: Camera, corners: Floats) -> Floats | None:
    """Project a flat polygon, clipped at the near plane. Return None if nothing is ahead."""
    ahead = corners[:, 2] - NEAR_M
    if (ahead <= 0).all():
        return None
    if (ahead < 0).any():
        following = np.roll(corners, -1, axis=0)
        after = np.roll(ahead, -1)
        crosses = (ahead > 0) != (after > 0)
        share = np.where(crosses, ahead / np.where(crosses, ahead - after, 1.0), 0.0)
        cuts = corners + share[:, None] * (following - corners)
        # The cut of an edge follows its kept corner, hence the order 2i, 2i + 1.
        both = np.stack([corners, cuts], axis=1).reshape(-1, 3)
        corners = both[np.stack([ahead > 0, crosses], axis=1).ravel()]
    pixels, _ = camera.project(corners)
    return np.clip(pixels, -4000.0, 4000.0)


def fixed_point(polygon: Floats, left: int, top: int, scale: int) -> NDArray[np.int32]:
    """Return corners in cv2's fixed-point format for a layer at (left, top) with `scale`."""
    place = (polygon - (left, top)) * scale - 0.5
    return np.round(np.clip(place, -8000, 8000) * (1 << FRACTION_BITS)).astype(np.int32)


def placement(
    box: tuple[float, float, float, float], image: NDArray[np.float32], left: int, top: int
) -> Floats:
    """Return the map, (2, 3), from an image's pixels to a box in a layer at (left, top).

    Parameters
    ----------
    box
        Left, top, right, bottom in pixels.
    """
    scale_x = (box[2] - box[0]) / image.shape[1]
    scale_y = (box[3] - box[1]) / image.shape[0]
    return np.array(
        [
            [scale_x, 0.0, box[0] - left + (scale_x - 1) / 2],
            [0.0, scale_y, box[1] - top + (scale_y - 1) / 2],
        ]
    )


class Canvas:
    """Grey picture that shapes are painted on."""

    def __init__(self, picture: Picture):
        self.picture = picture

    def paint(self, shapes: Sequence[Shape], *, soften: float = 0.0, texture: float = 0.0) -> None:
        """Paint polygons in order as one layer.

        Parameters
        ----------
        shapes
            Polygons with greys of 0 to 255.
        soften
            Standard deviation in pixels of the blur of the layer.
        texture
            Amplitude of a soft mottling of the layer.
        """
        if not shapes:
            return
        corners = np.concatenate([polygon for polygon, _ in shapes])
        margin = 2 + int(np.ceil(2.5 * soften))
        left, top = (int(v) for v in np.maximum(np.floor(corners.min(axis=0)) - margin, 0))
        right, bottom = (
            int(v) for v in np.minimum(np.ceil(corners.max(axis=0)) + margin, (WIDTH, HEIGHT))
        )
        if right - left < 1 or bottom - top < 1:
            return
        area = (right - left) * (bottom - top)
        scale = 4 if area < 6000 else 2 if area < 40000 else 1
        layer = np.zeros(((bottom - top) * scale, (right - left) * scale, 2), dtype=np.uint8)
        for polygon, grey in shapes:
            corners_there = [fixed_point(polygon, left, top, scale)]
            value = float(np.clip(grey, 0, 255))
            cv2.fillPoly(layer, corners_there, (value, 255.0), cv2.LINE_AA, FRACTION_BITS)
        if scale > 1:
            size = (right - left, bottom - top)
            layer = cv2.resize(layer, size, interpolation=cv2.INTER_AREA)
        soft = layer.astype(np.float32)
        if soften > 0.2:
            soft = cv2.GaussianBlur(soft, (0, 0), soften)
        cover = np.asarray(soft[..., 1] / 255, dtype=np.float32)
        self._blend(left, top, soft[..., 0], cover, texture)

    def sprite(
        self, image: Picture, cover: Picture, box: tuple[float, float, float, float], tone: float
    ) -> None:
        """Paint an image with its cover (both premultiplied, 0 to 1) into a box, scaled.

        Parameters
        ----------
        box
            Left, top, right, bottom in pixels.
        tone
            Grey of image value 1.
        """
        left, top = max(int(np.floor(box[0])), 0), max(int(np.floor(box[1])), 0)
        right, bottom = min(int(np.ceil(box[2])), WIDTH), min(int(np.ceil(box[3])), HEIGHT)
        if right - left < 1 or bottom - top < 1:
            return
        place = placement(box, image, left, top)
        size = (right - left, bottom - top)
        grey = cv2.warpAffine(image, place, size, flags=cv2.INTER_LINEAR)
        alpha = cv2.warpAffine(cover, place, size, flags=cv2.INTER_LINEAR)
        self._blend(left, top, grey * tone, alpha, 0.0)

    def glow(self, column: float, row: float, radius: float, grey: float) -> None:
        """Add a soft round glow."""
        if not (-radius < column < WIDTH + radius and -radius < row < HEIGHT + radius):
            return
        left, right = max(int(column - 3 * radius), 0), min(int(column + 3 * radius) + 2, WIDTH)
        top, bottom = max(int(row - 3 * radius), 0), min(int(row + 3 * radius) + 2, HEIGHT)
        if right <= left or bottom <= top:
            return
        across = np.exp(-(((np.arange(left, right) + 0.5 - column) / radius) ** 2))
        down = np.exp(-(((np.arange(top, bottom) + 0.5 - row) / radius) ** 2))
        self.picture[top:bottom, left:right] += (grey * np.outer(down, across)).astype(np.float32)

    def _blend(self, left: int, top: int, grey: Picture, alpha: Picture, texture: float) -> None:
        below = self.picture[top : top + grey.shape[0], left : left + grey.shape[1]]
        below *= 1 - alpha
        below += grey
        if texture > 0:
            below += (
                texture * alpha * _mottle()[top : top + grey.shape[0], left : left + grey.shape[1]]
            )


_MOTTLE: list[Picture] = []


def _mottle() -> Picture:
    """Return soft noise of unit amplitude over the picture, computed once."""
    if not _MOTTLE:
        rough = np.random.default_rng(5).standard_normal((HEIGHT, WIDTH)).astype(np.float32)
        soft = cv2.GaussianBlur(rough, (0, 0), 2.5)
        _MOTTLE.append((soft / soft.std()).astype(np.float32))
    return _MOTTLE[0]
