"""The visible-light camera: same place and direction as the thermal one, other size and offset.

Both cameras look through one point, so a thermal pixel has one place in the visible picture:
`x_visible = sx * x + dx`, `y_visible = sy * y + dy`. A real pair has a parallax besides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from tools.sample.camera import HEIGHT as THERMAL_HEIGHT
from tools.sample.camera import WIDTH as THERMAL_WIDTH
from tools.sample.camera import Camera, Floats
from tools.sample.canvas import project_polygon

VISIBLE_SIZE: Final = (960, 540)
"""Width and height of the visible pictures of the recordings."""


@dataclass(frozen=True)
class View:
    """Size of the visible picture, and its pixels from those of the thermal camera.

    Attributes
    ----------
    scale, dx, dy
        `x_visible = scale * x + dx`, `y_visible = scale * y + dy`, pixels.
    """

    camera: Camera
    width: int = VISIBLE_SIZE[0]
    height: int = VISIBLE_SIZE[1]
    scale: float = 1.25
    dx: float = 72.0
    dy: float = -46.0

    @property
    def focal_px(self) -> float:
        """Focal length in visible pixels."""
        return self.camera.focal_px * self.scale

    @property
    def horizon(self) -> float:
        """Row of the horizon in visible pixels."""
        return self.camera.horizon * self.scale + self.dy

    def from_thermal(self, pixels: Floats) -> Floats:
        """Visible from thermal pixels, shape (..., 2)."""
        return np.asarray(pixels * self.scale + np.array([self.dx, self.dy]))

    def project(self, points: Floats) -> tuple[Floats, Floats]:
        """Pixels and depth in metres of points relative to the car, as `Camera.project`."""
        pixels, depth = self.camera.project(points)
        return self.from_thermal(pixels), depth

    def outline(self, corners: Floats) -> Floats | None:
        """Image of a flat polygon, cut at the near plane; None where nothing is ahead."""
        outline = project_polygon(self.camera, corners)
        return None if outline is None else self.from_thermal(outline)

    def rays(self, columns: Floats, rows: Floats) -> Floats:
        """Directions of pixels, metres x, y, z per metre of depth, shape (..., 3)."""
        camera = self.camera
        across = ((columns - self.dx) / self.scale - THERMAL_WIDTH / 2) / camera.focal_px
        up = -((rows - self.dy) / self.scale - THERMAL_HEIGHT / 2) / camera.focal_px
        sine, cosine = np.sin(camera.pitch), np.cos(camera.pitch)
        return np.stack([across, cosine * up - sine, cosine + sine * up], axis=-1)

    def ground_depth(self, rows: Floats) -> Floats:
        """Metres ahead at which the road is seen on rows below the horizon."""
        return self.camera.ground_depth((rows - self.dy) / self.scale)


def visible_map() -> tuple[float, float, float, float]:
    """`sx, sy, dx, dy` of the recordings, as a session file says them."""
    view = View(Camera())
    return view.scale, view.scale, view.dx, view.dy


def mapped_boxes(view: View, edges: Floats) -> Floats:
    """Boxes x, y, w, h in visible pixels, clipped to the picture and in quarters of a pixel.

    Parameters
    ----------
    edges
        Left, top, right, bottom in thermal pixels, not clipped, shape (n, 4).
    """
    corners = view.from_thermal(edges.reshape(-1, 2, 2)).reshape(-1, 4)
    inside = np.clip(corners, 0.0, [view.width, view.height, view.width, view.height])
    inside = np.round(inside * 4) / 4
    return np.concatenate([inside[:, :2], inside[:, 2:] - inside[:, :2]], axis=1)
