"""Light of a scene: sky, street lamps, a floodlit stretch, headlamps. Illuminance in lux.

Colours are linear red, green, blue, scaled so that white light of E lux has E in each channel.
A matt surface of albedo a under E lux has the luminance a * E / pi in cd/m2.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from tools.sample.camera import FPS, Floats
from tools.sample.scene import Recording

LUMA: Final = np.array([0.2126, 0.7152, 0.0722])
"""Luminance weights of linear red, green and blue (Rec. 709)."""

SKYLIGHT: Final = np.array([0.80, 0.98, 1.36])
LAMPLIGHT: Final = np.array([1.42, 0.94, 0.48])
HEADLIGHT: Final = np.array([1.10, 0.99, 0.86])
FLOODLIGHT: Final = np.array([1.05, 1.0, 0.93])
UP: Final = np.array([0.0, 1.0, 0.0])
TO_CAMERA: Final = np.array([0.0, 0.0, -1.0])

_LAMP_REACH_M: Final = 38.0
_HEADLAMP_HEIGHT_M: Final = 0.66
_FLOOD_EDGE_M: Final = 12.0


@dataclass(frozen=True)
class Glow:
    """Light of a place and time of day.

    Attributes
    ----------
    sky_lux
        Illuminance of open ground by the sky.
    lamp_cd
        Luminous intensity of a street lamp, candela.
    headlamp_cd
        Luminous intensity of both own headlamps in the brightest direction, candela. 0: off.
    flood_lux, flood_end_m
        Illuminance by floodlights on masts, and position on the road where they end.
    warmth
        Warmth of the light at the horizon, 0 (blue hour) to 1 (sunset).
    """

    sky_lux: float = 3.0
    lamp_cd: float = 620.0
    headlamp_cd: float = 15_000.0
    flood_lux: float = 0.0
    flood_end_m: float = -1e3
    warmth: float = 0.5


@dataclass(frozen=True)
class Lights:
    """All lights of a recording at one moment, in metres relative to the car.

    Attributes
    ----------
    lamps
        Positions of the street lamps' heads, shape (lamps, 3).
    oncoming
        Midpoints between the headlamps of oncoming cars, shape (cars, 3).
    way
        Distance travelled by the car, metres.
    """

    glow: Glow
    lamps: Floats
    way: float
    oncoming: Floats = field(default_factory=lambda: np.zeros((0, 3)))

    def at(
        self, points: Floats, normal: Floats = TO_CAMERA, *, wrap: float = 0.0, own: bool = True
    ) -> Floats:
        """Return the illuminance of surfaces.

        Parameters
        ----------
        points
            Metres relative to the car, shape (n, 3).
        normal
            Unit vector that the surfaces face, shape (3,).
        wrap
            0 for a flat surface, more for round ones, which also catch light from the side.
        own
            Whether to include the car's own headlamps.

        Returns
        -------
        Lux in linear red, green, blue, shape (n, 3).
        """
        open_sky = 0.5 + 0.5 * normal[1]
        light: Floats = np.tile(
            (0.15 + 0.85 * open_sky) * self.glow.sky_lux * SKYLIGHT, (len(points), 1)
        )
        light += self.flood(points, normal)[:, None] * FLOODLIGHT
        light += self.street(points, normal, wrap)[:, None] * LAMPLIGHT
        if own and self.glow.headlamp_cd:
            light += self.headlamps(points, normal, wrap)[:, None] * HEADLIGHT
        light += self.dazzle(points, normal, wrap)[:, None] * HEADLIGHT
        return light

    def flood(self, points: Floats, normal: Floats) -> Floats:
        """Return the lux of floodlights, which come from high masts on all sides, shape (n,)."""
        if self.glow.flood_lux <= 0:
            return np.zeros(len(points))
        short = (self.glow.flood_end_m - points[:, 2] - self.way) / _FLOOD_EDGE_M
        share = np.clip(short, 0.0, 1.0)
        return np.asarray(
            self.glow.flood_lux * share**2 * (3 - 2 * share) * (0.55 + 0.45 * max(normal[1], 0.0))
        )

    def street(self, points: Floats, normal: Floats, wrap: float = 0.0) -> Floats:
        """Return the lux of street lamps, shape (n,)."""
        light: Floats = np.zeros(len(points))
        if not len(points) or self.glow.lamp_cd <= 0:
            return light
        near, far = points[:, 2].min() - _LAMP_REACH_M, points[:, 2].max() + _LAMP_REACH_M
        for lamp in self.lamps[(self.lamps[:, 2] > near) & (self.lamps[:, 2] < far)]:
            towards = lamp - points
            metres = np.maximum(np.sqrt((towards**2).sum(axis=1)), 2.2)
            facing = _facing(towards @ normal / metres, wrap)
            # A lamp shines down and to the sides, hardly above 75 degrees from the vertical.
            down = np.clip(towards[:, 1] / metres, 0.02, 1.0)
            light += self.glow.lamp_cd * np.minimum(1.0, 0.25 + 1.9 * down) * facing / metres**2
        return light

    def headlamps(self, points: Floats, normal: Floats, wrap: float = 0.0) -> Floats:
        """Return the lux of the car's own headlamps on low beam, shape (n,)."""
        towards = np.array([0.0, _HEADLAMP_HEIGHT_M, 1.2]) - points
        metres = np.maximum(np.sqrt((towards**2).sum(axis=1)), 5.0)
        facing = _facing(towards @ normal / metres, wrap)
        across = np.degrees(np.arctan2(-towards[:, 0], np.maximum(-towards[:, 2], 0.1)))
        up = np.degrees(np.arcsin(np.clip(-towards[:, 1] / metres, -1, 1)))
        return np.asarray(self.glow.headlamp_cd * low_beam(across, up) * facing / metres**2)

    def dazzle(self, points: Floats, normal: Floats, wrap: float = 0.0) -> Floats:
        """Return the lux of the headlamps of oncoming cars, shape (n,)."""
        light = np.zeros(len(points))
        for place in self.oncoming:
            light += _oncoming(points, normal, place, wrap)
        return light

    def driver_lux(self) -> float:
        """Return the illuminance at a sensor behind the windscreen that looks up and ahead, lux."""
        eye = np.array([[0.0, 1.2, 0.0]])
        up = self.at(eye, np.array([0.0, 1.0, 0.0]), own=False)[0]
        ahead = self.at(eye, np.array([0.0, 0.0, 1.0]), own=False)[0]
        return float((0.6 * up + 0.4 * ahead) @ LUMA)


def low_beam(across_deg: Floats, up_deg: Floats) -> Floats:
    """Return intensity relative to the brightest direction, with a cut-off rising to the right."""
    cut = -0.55 + np.clip(0.26 * (across_deg - 0.3), 0.0, 1.5)
    below = cut - up_deg
    edge = 1 / (1 + np.exp(-np.clip(below / 0.30, -40, 40)))
    deep = np.exp(-np.clip(below - 0.8, 0.0, None) / 3.2)
    wide = 0.80 * np.exp(-((across_deg / 8.5) ** 2)) + 0.20 * np.exp(-((across_deg / 20.0) ** 2))
    return np.asarray(wide * (0.035 + 0.965 * edge * deep))


def _facing(cosine: Floats, wrap: float) -> Floats:
    return np.asarray(np.clip((cosine + wrap) / (1 + wrap), 0.0, None))


def _oncoming(points: Floats, normal: Floats, place: Floats, wrap: float) -> Floats:
    """Return the lux of an oncoming car's headlamps, shape (n,)."""
    towards = place - points
    metres = np.maximum(np.sqrt((towards**2).sum(axis=1)), 2.0)
    facing = _facing(towards @ normal / metres, wrap)
    across = np.degrees(np.arctan2(towards[:, 0], np.maximum(towards[:, 2], 0.1)))
    up = np.degrees(np.arcsin(np.clip(-towards[:, 1] / metres, -1, 1)))
    lit = towards[:, 2] > 0.3
    return np.asarray(np.where(lit, 11_000 * low_beam(across, up) * facing / metres**2, 0.0))


def lights_at(recording: Recording, glow: Glow, frame: int) -> Lights:
    """Return the lights of a recording at one frame."""
    way = float(recording.way()[frame])
    heads = [
        (thing.x - np.sign(thing.x) * 1.0, thing.size_m, thing.z - way)
        for thing in recording.things
        if thing.kind == "lamp"
    ]
    fronts = [
        (car.x, _HEADLAMP_HEIGHT_M, car.z - car.length_m / 2 + car.speed * frame / FPS - way)
        for car in recording.cars
        if car.oncoming and car.lights
    ]
    return Lights(
        glow,
        np.array(heads).reshape(-1, 3),
        way,
        np.array([front for front in fronts if front[2] > 0.5]).reshape(-1, 3),
    )
