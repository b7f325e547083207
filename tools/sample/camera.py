"""Pinhole camera of the sample data and the car that carries it.

Metres: x to the right of the camera, y up from the road, z ahead. Pixels: those of docs/formats.md,
origin at the image's top-left corner, continuous.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

FPS: Final = 20
N_FRAMES: Final = 300
WIDTH: Final = 640
HEIGHT: Final = 480

Floats = NDArray[np.float64]


def frame_times() -> Floats:
    """Return the time of every frame in seconds, shape (N_FRAMES,)."""
    return np.arange(N_FRAMES) / FPS


@dataclass(frozen=True)
class Camera:
    """Pinhole camera, pitched so that the horizon lies on a given row.

    Attributes
    ----------
    horizon
        Row of the horizon in pixels. It is above the image centre if the camera looks down.
    focal_px
        Focal length in pixels. 1100 on 640 columns is a field of view of 32 degrees.
    mount_m
        Height of the camera above the road in metres.
    """

    horizon: float = HEIGHT / 2
    focal_px: float = 1100.0
    mount_m: float = 1.25

    @property
    def pitch(self) -> float:
        """Angle in radians by which the optical axis points below the horizontal."""
        return float(np.arctan((HEIGHT / 2 - self.horizon) / self.focal_px))

    def project(self, points: Floats) -> tuple[Floats, Floats]:
        """Project points relative to the car to the image.

        Parameters
        ----------
        points
            Metres, shape (..., 3), last axis x, y, z.

        Returns
        -------
        pixels
            Shape (..., 2), column and row.
        depth
            Metres along the optical axis, shape (...). Pixels are valid only where it is positive.
        """
        sine, cosine = np.sin(self.pitch), np.cos(self.pitch)
        rise = points[..., 1] - self.mount_m
        depth = cosine * points[..., 2] - sine * rise
        safe = np.where(np.abs(depth) < 1e-6, 1e-6, depth)
        column = WIDTH / 2 + self.focal_px * points[..., 0] / safe
        row = HEIGHT / 2 - self.focal_px * (cosine * rise + sine * points[..., 2]) / safe
        return np.stack([column, row], axis=-1), depth

    def ground_depth(self, rows: Floats) -> Floats:
        """Return the distance ahead, m, at which the road appears on rows below the horizon."""
        angle = np.arctan((rows - HEIGHT / 2) / self.focal_px) + self.pitch
        return np.asarray(self.mount_m / np.tan(angle))


def travelled(speed: tuple[tuple[float, float], ...]) -> Floats:
    """Return the distance travelled by the car in metres at every frame.

    Parameters
    ----------
    speed
        Pairs of time in seconds and speed in metres per second, linear in between.
    """
    fine_s = np.arange(N_FRAMES * 10) / (FPS * 10)
    knots = np.asarray(speed, dtype=np.float64)
    speeds = np.interp(fine_s, knots[:, 0], knots[:, 1])
    way = np.concatenate([[0.0], np.cumsum((speeds[1:] + speeds[:-1]) / 2 / (FPS * 10))])
    return way[::10]
