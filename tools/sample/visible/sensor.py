"""Lens, exposure, noise and tone curve of the visible-light camera."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.sample.camera import FPS
from tools.sample.visible.light import LUMA
from tools.sample.visible.paint import Colours
from tools.sample.visible.view import View

_NOISE_FRAMES: Final = 5
_SETTLING_S: Final = 0.35
_KEY: Final = 0.135
"""Share of white to which exposure brings the median luminance of a dark scene."""
_REST: Final = 0.82
"""Degree of exposure compensation. 1 would give the same picture by day and by night."""
_USUAL_CD_M2: Final = 0.4
_FLOOR_CD_M2: Final = 0.05
_LAMP_CD_M2: Final = 60.0


class Sensor:
    """Sensor that reads the pictures of one recording in frame order."""

    def __init__(self, seed: int, view: View, *, noise: float = 1.0):
        generator = np.random.default_rng([29, seed])
        size = (view.height, view.width)
        y, x = np.mgrid[0 : view.height, 0 : view.width]
        off = np.hypot(x - view.width / 2, y - view.height / 2) / (view.width / 2)
        self._fall_off = (1.0 - 0.20 * off**2.2).astype(np.float32)[..., None]
        grain = generator.normal(0, 1.0, (_NOISE_FRAMES, *size)).astype(np.float32)
        tint = generator.normal(0, 1.0, (*size, 3)).astype(np.float32)
        self._grain, self._tint = noise * grain, noise * cv2.GaussianBlur(tint, (0, 0), 1.1)
        self._order = generator
        self._adapted: float | None = None

    def read(self, scene: Colours) -> NDArray[np.uint8]:
        """Return an 8-bit sRGB picture from luminances in cd/m2."""
        exposure = self._exposure(scene)
        light = cv2.GaussianBlur(_bloomed(scene * exposure), (0, 0), 0.6) * self._fall_off
        index = int(self._order.integers(_NOISE_FRAMES))
        shift = tuple(int(v) for v in self._order.integers(0, scene.shape[:2]))
        grain = np.roll(self._grain[index], shift, axis=(0, 1))[..., None]
        tint = np.roll(self._tint, shift, axis=(0, 1))
        # Noise of a small sensor at night: photon noise and read noise.
        light += np.sqrt(0.00018 * light + 0.000006) * (0.8 * grain + 0.5 * tint)
        return np.asarray(np.round(255 * _tone(light)), dtype=np.uint8)

    def _exposure(self, scene: Colours) -> float:
        """Return a gain that follows the median luminance with a delay."""
        luminance = scene[::4, ::4] @ LUMA.astype(np.float32)
        seen = np.clip(luminance, _FLOOR_CD_M2, _LAMP_CD_M2)
        middle = float(np.sqrt(seen).mean() ** 2)
        if self._adapted is None:
            self._adapted = np.log(middle)
        self._adapted += (np.log(middle) - self._adapted) * (1 - np.exp(-1 / (FPS * _SETTLING_S)))
        return float(_KEY / _USUAL_CD_M2 * (np.exp(self._adapted) / _USUAL_CD_M2) ** -_REST)


def _bloomed(light: Colours) -> Colours:
    """Spread light that is brighter than white, as in a lens."""
    over = np.maximum(
        cv2.resize(light, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA) - 1, 0
    )
    over = np.minimum(over, 60.0)
    spread = 0.10 * cv2.GaussianBlur(over, (0, 0), 2.0) + 0.035 * cv2.GaussianBlur(
        over, (0, 0), 9.0
    )
    size = (light.shape[1], light.shape[0])
    return np.asarray(light + cv2.resize(spread, size, interpolation=cv2.INTER_LINEAR))


def _tone(light: Colours) -> Colours:
    """Apply the sRGB curve with a soft shoulder, 0 to 1."""
    light = np.maximum(light, 0.0)
    shoulder = np.where(light > 0.6, 0.6 + 0.4 * (1 - np.exp(-(light - 0.6) / 0.4)), light)
    curve = np.where(shoulder <= 0.0031308, 12.92 * shoulder, 1.055 * shoulder ** (1 / 2.4) - 0.055)
    return np.asarray(np.clip(curve, 0.0, 1.0), dtype=np.float32)
