"""Antialiased painting of coloured polygons and sprites on a picture of luminances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.sample.camera import Floats
from tools.sample.canvas import FRACTION_BITS, fixed_point, placement
from tools.sample.visible.view import View

Colours = NDArray[np.float32]
Shape = tuple[Floats, Floats]
"""Polygon in pixels, shape (corners, 2), and its linear red, green, blue, shape (3,)."""

Shading = Callable[[Floats], Floats]
"""Maps rays of pixels, shape (n, 3), to factors for a colour there, shape (n, 3)."""

Veil = tuple[float, Floats]

_SHADE_STEP: Final = 8
"""Step in pixels at which light is computed. It is interpolated linearly in between."""


class Easel:
    """Picture in cd/m2, shape (height, width, 3), that shapes are painted on."""

    def __init__(self, picture: Colours, view: View):
        self.picture, self.view = picture, view

    def paint(
        self,
        shapes: Sequence[Shape],
        *,
        soften: float = 0.0,
        shading: Shading | None = None,
        veil: Veil | None = None,
    ) -> None:
        """Paint polygons in order as one layer.

        Parameters
        ----------
        soften
            Standard deviation in pixels of the blur of the layer.
        shading
            Light by place, for colours that are albedos. None: colours are luminances.
        veil
            Air in front: share of the light that it transmits, and the luminance that it adds.
        """
        if not shapes:
            return
        corners = np.concatenate([polygon for polygon, _ in shapes])
        area = self._area(corners, 2 + int(np.ceil(2.5 * soften)))
        if area is None:
            return
        colours, cover = _drawn(shapes, area)
        if soften > 0.2:
            both = cv2.GaussianBlur(np.dstack([colours, cover]), (0, 0), soften)
            colours, cover = both[..., :3], both[..., 3]
        if shading is not None:
            colours = colours * self._shade(area, shading)
        if veil is not None:
            colours = colours * np.float32(veil[0]) + cover[..., None] * veil[1].astype(np.float32)
        self._blend(area, colours, cover)

    def sprite(
        self, image: Colours, cover: Colours, box: tuple[float, float, float, float]
    ) -> None:
        """Paint an image with its cover (both premultiplied) into a box of pixels, scaled."""
        area = self._area(np.array([[box[0], box[1]], [box[2], box[3]]]), 0)
        if area is None:
            return
        left, top, right, bottom = area
        place = placement(box, image, left, top)
        size = (right - left, bottom - top)
        colours = cv2.warpAffine(image, place, size, flags=cv2.INTER_LINEAR)
        alpha = cv2.warpAffine(cover, place, size, flags=cv2.INTER_LINEAR)
        self._blend(area, colours.astype(np.float32), alpha.astype(np.float32))

    def glow(self, pixel: Floats, radius: float, colour: Floats) -> None:
        """Add a soft round glow with `colour` in cd/m2 at its middle."""
        area = self._area(pixel[None, :], int(4 * radius) + 1)
        if area is not None:
            left, top, right, bottom = area
            self.picture[top:bottom, left:right] += _round(area, pixel, radius, radius) * colour

    def shade(self, pixel: Floats, wide: float, high: float, share: float) -> None:
        """Remove a share of the light in a soft ellipse: the shadow below a body or a car."""
        area = self._area(pixel[None, :], int(3 * max(wide, high)) + 1)
        if area is not None:
            left, top, right, bottom = area
            self.picture[top:bottom, left:right] *= 1 - share * _round(area, pixel, wide, high)

    def _area(self, corners: Floats, margin: int) -> tuple[int, int, int, int] | None:
        size = (self.view.width, self.view.height)
        left, top = (int(v) for v in np.maximum(np.floor(corners.min(axis=0)) - margin, 0))
        right, bottom = (int(v) for v in np.minimum(np.ceil(corners.max(axis=0)) + margin, size))
        return (left, top, right, bottom) if right > left and bottom > top else None

    def _shade(self, area: tuple[int, int, int, int], shading: Shading) -> Colours:
        left, top, right, bottom = area
        columns = max(2, (right - left) // _SHADE_STEP + 1)
        rows = max(2, (bottom - top) // _SHADE_STEP + 1)
        x = left + (np.arange(columns) + 0.5) * (right - left) / columns
        y = top + (np.arange(rows) + 0.5) * (bottom - top) / rows
        rays = self.view.rays(*np.meshgrid(x, y)).reshape(-1, 3)
        light = shading(rays).reshape(rows, columns, 3).astype(np.float32)
        size = (right - left, bottom - top)
        return np.asarray(cv2.resize(light, size, interpolation=cv2.INTER_LINEAR))

    def _blend(self, area: tuple[int, int, int, int], colours: Colours, cover: Colours) -> None:
        left, top, right, bottom = area
        below = self.picture[top:bottom, left:right]
        below *= 1 - cover[..., None]
        below += colours


def _drawn(shapes: Sequence[Shape], area: tuple[int, int, int, int]) -> tuple[Colours, Colours]:
    """Return premultiplied colours, and cover, of shapes within an area of pixels."""
    left, top, right, bottom = area
    n_pixels = (right - left) * (bottom - top)
    scale = 4 if n_pixels < 6000 else 2 if n_pixels < 60_000 else 1
    brightest = max(float(colour.max()) for _, colour in shapes) or 1.0
    layer = np.zeros(((bottom - top) * scale, (right - left) * scale, 4), dtype=np.uint8)
    for polygon, colour in shapes:
        corners = [fixed_point(polygon, left, top, scale)]
        # Eight bits of the square root keep dark clothes distinct beside a bright wall.
        red, green, blue = 255 * np.sqrt(np.maximum(colour, 0.0) / brightest)
        cv2.fillPoly(layer, corners, (red, green, blue, 255.0), cv2.LINE_AA, FRACTION_BITS)
    if scale > 1:
        layer = cv2.resize(layer, (right - left, bottom - top), interpolation=cv2.INTER_AREA)
    soft: Colours = layer.astype(np.float32) / np.float32(255)
    cover: Colours = soft[..., 3]
    colours = soft[..., :3] ** 2 * (brightest / np.maximum(cover, 1 / 512))[..., None]
    return np.asarray(colours, dtype=np.float32), cover


def _round(area: tuple[int, int, int, int], pixel: Floats, wide: float, high: float) -> Colours:
    left, top, right, bottom = area
    across = np.exp(-(((np.arange(left, right) + 0.5 - pixel[0]) / wide) ** 2))
    down = np.exp(-(((np.arange(top, bottom) + 0.5 - pixel[1]) / high) ** 2))
    return np.outer(down, across).astype(np.float32)[..., None]
