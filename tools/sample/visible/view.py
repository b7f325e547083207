"""Visible-light camera: position and direction of the thermal one, but another size and offset.

Both cameras look through one point, so a thermal pixel has one place in the visible picture:
`x_visible = sx * x + dx`, `y_visible = sy * y + dy`. A real pair additionally has parallax.
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
"""Width and height of the visible pictures."""


@dataclass(frozen=True)
class View:
    """Size of the visible picture, and its mapping from thermal pixels.

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
        """Convert thermal to visible pixels, shape (..., 2)."""
        return np.asarray(pixels * self.scale + np.array([self.dx, self.dy]))

    def project(self, points: Floats) -> tuple[Floats, Floats]:
        """Return pixels and depth in metres of points relative to the car, as `Camera.project`."""
        pixels, depth = self.camera.project(points)
        return self.from_thermal(pixels), depth

    def outline(self, corners: Floats) -> Floats | None:
        """Project a flat polygon, clipped at the near plane. Return None if nothing is ahead."""
        outline = project_polygon(self.camera, corners)
        return None if outline is None else self.from_thermal(outline)

    def rays(self, columns: Floats, rows: Floats) -> Floats:
        """Return directions of pixels, metres x, y, z per metre of depth, shape (..., 3)."""
        camera = self.camera
        across = ((columns - self.dx) / self.scale - THERMAL_WIDTH / 2) / camera.focal_px
        up = -((rows - self.dy) / self.scale - THERMAL_HEIGHT / 2) / camera.focal_px
        sine, cosine = np.sin(camera.pitch), np.cos(camera.pitch)
        return np.stack([across, cosine * up - sine, cosine + sine * up], axis=-1)

    def ground_depth(self, rows: Floats) -> Floats:
        """Return the distance ahead, m, at which the road appears on rows below the horizon."""
        return self.camera.ground_depth((rows - self.dy) / self.scale)


def visible_map() -> tuple[float, float, float, float]:
    """Return `sx, sy, dx, dy` of the recordings, as written in a session file."""
    view = View(Camera())
    return view.scale, view.scale, view.dx, view.dy


def mapped_boxes(view: View, edges: Floats) -> Floats:
    """Return boxes x, y, w, h in visible pixels, clipped to the picture, in quarters of a pixel.

    Parameters
    ----------
    edges
        Left, top, right, bottom in thermal pixels, unclipped, shape (n, 4).
    """
    corners = view.from_thermal(edges.reshape(-1, 2, 2)).reshape(-1, 4)
    inside = np.clip(corners, 0.0, [view.width, view.height, view.width, view.height])
    inside = np.round(inside * 4) / 4
    return np.concatenate([inside[:, :2], inside[:, 2:] - inside[:, :2]], axis=1)
