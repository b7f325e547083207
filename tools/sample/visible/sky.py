"""Twilight above the horizon, and the dark line of woods and roofs below it."""

from __future__ import annotations

import zlib
from typing import Final

import numpy as np

from tools.sample.backdrop import noise
from tools.sample.camera import Floats
from tools.sample.scene import Recording
from tools.sample.visible.light import Glow
from tools.sample.visible.paint import Colours
from tools.sample.visible.view import View

_SUNSET: Final = np.array([1.75, 0.88, 0.46])
_BLUE_HOUR: Final = np.array([0.78, 0.98, 1.30])
_ZENITH: Final = np.array([0.52, 0.86, 1.62])


def horizon_glow(glow: Glow) -> Floats:
    """Return the luminance of the sky just above the horizon, cd/m2 in red, green, blue."""
    colour = glow.warmth * _SUNSET + (1 - glow.warmth) * _BLUE_HOUR
    return np.asarray(colour * glow.sky_lux / np.pi * 2.8)


def air(glow: Glow) -> Floats:
    """Return the luminance of the haze in front of far objects, cd/m2 in red, green, blue."""
    return np.asarray(0.26 * horizon_glow(glow))


def sky(recording: Recording, glow: Glow, view: View) -> Colours:
    """Draw sky and skyline, which do not move within 15 seconds."""
    generator = np.random.default_rng([24, zlib.crc32(recording.name.encode())])
    size = (view.height, view.width)
    up = (view.horizon - np.arange(view.height) - 0.5)[:, None] / view.focal_px
    height = np.clip(np.degrees(np.arctan(up)) / 14.0, 0.0, 1.0)
    low, high = horizon_glow(glow), _ZENITH * glow.sky_lux / np.pi * 0.66
    fade = np.exp(-height / 0.30)[..., None]
    picture = np.broadcast_to(low * fade + high * (1 - fade), (*size, 3)).astype(np.float32)
    clouds = 0.7 * noise(generator, size, (46, 260)) + 0.45 * noise(generator, size, (17, 120))
    veil = np.clip(clouds - 0.15, 0.0, 1.4) * np.clip(height * 4, 0, 1)
    grey = (0.62 * high + 0.22 * low).astype(np.float32)
    picture += 0.55 * veil[..., None].astype(np.float32) * (grey - picture)
    _skyline(picture, generator, view, air(glow))
    return picture


def _skyline(picture: Colours, generator: np.random.Generator, view: View, haze: Floats) -> None:
    size = (view.height, view.width)
    for high, grain, share in ((19, 120, 0.80), (12, 44, 0.52), (8, 15, 0.34)):
        line = noise(generator, (1, view.width), (1, grain))[0]
        line += 0.5 * noise(generator, (1, view.width), (1, grain / 4))[0]
        ragged = 0.22 * noise(generator, (1, view.width), (1, 2.6))[0]
        top = view.horizon - high * (0.75 + 0.42 * line + ragged).clip(0.12)
        depth = np.arange(view.height)[:, None] + 0.5 - top[None, :]
        cover = np.clip(depth + 0.5, 0, 1).astype(np.float32)[..., None]
        tone = 1 + 0.10 * noise(generator, size, (3, 4))[..., None]
        picture += cover * ((haze * share).astype(np.float32) * tone - picture)
