"""Shared state of all drawing functions: picture, light at this moment, air."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tools.sample.camera import Floats
from tools.sample.canvas import NEAR_M
from tools.sample.visible.ground import HAZE_M
from tools.sample.visible.light import TO_CAMERA, Glow, Lights
from tools.sample.visible.paint import Easel, Shading, Shape, Veil
from tools.sample.visible.view import View

Face = tuple[Floats, Floats]
"""Flat polygon in metres relative to the car, shape (corners, 3), and its albedo, shape (3,)."""

_FAR_M = 300.0


@dataclass(frozen=True)
class Stage:
    """One frame being drawn."""

    easel: Easel
    view: View
    lights: Lights
    air: Floats

    @property
    def glow(self) -> Glow:
        """Light of the recording."""
        return self.lights.glow

    def veil(self, depth_m: float) -> Veil:
        """Return the air in front of an object."""
        clear = float(np.exp(-max(depth_m, 0.0) / HAZE_M))
        return clear, (1 - clear) * self.air

    def luminance(self, points: Floats, normal: Floats = TO_CAMERA, *, wrap: float = 0.0) -> Floats:
        """Return the luminance of a white matt surface at points, shape (n, 3), cd/m2."""
        return self.lights.at(points, normal, wrap=wrap) / np.pi

    def wall(self, faces: Sequence[Face], normal: Floats, *, soften: float = 0.35) -> None:
        """Paint faces of one plane in order, with the light at every place on it."""
        shapes = self.outlines(faces)
        if not shapes:
            return
        corners = np.concatenate([face for face, _ in faces])
        depth = float(np.clip(corners[:, 2].mean(), 1.0, _FAR_M))
        self.easel.paint(
            shapes, soften=soften, shading=self._on_plane(corners[0], normal), veil=self.veil(depth)
        )

    def lit(
        self, faces: Sequence[Face], normal: Floats, *, soften: float = 0.35, wrap: float = 0.0
    ) -> None:
        """Paint small faces, each with the light at its middle."""
        if not faces:
            return
        middles = np.array([face.mean(axis=0) for face, _ in faces])
        light = self.luminance(middles, normal, wrap=wrap)
        own = [(face, albedo * lux) for (face, albedo), lux in zip(faces, light, strict=True)]
        depth = float(np.clip(middles[:, 2].mean(), 1.0, _FAR_M))
        self.easel.paint(self.outlines(own), soften=soften, veil=self.veil(depth))

    def shining(self, faces: Sequence[Face], *, soften: float = 0.35) -> None:
        """Paint faces whose colours are luminances."""
        self.easel.paint(self.outlines(faces), soften=soften)

    def outlines(self, faces: Sequence[Face]) -> list[Shape]:
        """Project faces in one go, leaving out those behind the camera."""
        if not faces:
            return []
        counts = [len(corners) for corners, _ in faces]
        everything = np.concatenate([corners for corners, _ in faces])
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        nearest = np.minimum.reduceat(everything[:, 2], starts)
        pixels, _ = self.view.project(everything)
        shapes: list[Shape] = []
        for index, (corners, colour) in enumerate(faces):
            outline: Floats | None = pixels[starts[index] : starts[index] + counts[index]]
            if nearest[index] < NEAR_M:
                outline = self.view.outline(corners)
            if outline is not None:
                shapes.append((outline, colour))
        return shapes

    def _on_plane(self, point: Floats, normal: Floats) -> Shading:
        eye = np.array([0.0, self.view.camera.mount_m, 0.0])

        def shading(rays: Floats) -> Floats:
            slant = rays @ normal
            slant = np.where(np.abs(slant) < 1e-5, -1e-5, slant)
            metres = np.clip(((point - eye) @ normal) / slant, 0.5, _FAR_M)
            return self.luminance(eye + metres[:, None] * rays, normal)

        return shading
