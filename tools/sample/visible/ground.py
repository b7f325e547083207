"""Road, pavement and grass in visible light: surface colours and the light on them."""

from __future__ import annotations

import zlib
from typing import Final

import cv2
import numpy as np

from tools.sample.backdrop import noise
from tools.sample.camera import Floats
from tools.sample.scene import Recording, Road
from tools.sample.visible.light import HEADLIGHT, UP, Lights
from tools.sample.visible.paint import Colours
from tools.sample.visible.view import View

_STEP_X: Final = 0.05
_STEP_Z: Final = 0.1
_HALF_WIDTH: Final = 24.0
_BEHIND: Final = 4.0
_AHEAD: Final = 130.0
_LIGHT_STEP: Final = 0.5
_N_LEVELS: Final = 8
HAZE_M: Final = 620.0
"""Distance at which air leaves 1/e of an object's light."""

_ASPHALT: Final = np.array([0.088, 0.088, 0.092])
_SLABS: Final = np.array([0.205, 0.20, 0.19])
_KERB: Final = np.array([0.30, 0.30, 0.29])
_GRASS: Final = np.array([0.062, 0.085, 0.034])
_GRAVEL: Final = np.array([0.15, 0.135, 0.11])
_PAINT: Final = np.array([0.46, 0.46, 0.44])
_RETRO: Final = 0.045
"""Share of head-on light that rough asphalt and wet grass reflect back to the lamp."""


class Ground:
    """Ground of a recording, seen from any point of the drive."""

    def __init__(self, recording: Recording, lights: Lights, view: View, *, length_m: float):
        self._levels = _levels(_albedo(recording, length_m + _AHEAD))
        self._light = _lamp_light(lights, length_m + _AHEAD)
        self._first_row = max(int(np.floor(view.horizon)) + 1, 0)
        rows = np.arange(self._first_row, view.height) + 0.5
        self._depth = view.ground_depth(np.maximum(rows, view.horizon + 0.4))
        spacing = np.abs(np.gradient(self._depth)) / _STEP_Z
        self._level = np.clip(np.ceil(np.log2(np.maximum(spacing, 1.0))), 0, 7).astype(int)
        columns = np.arange(view.width) + 0.5
        middle = view.from_thermal(view.camera.project(np.array([0.0, 0.0, 20.0]))[0])[0]
        self._x = self._depth[:, None] * (columns - middle)[None, :] / view.focal_px
        self._view = view
        self._own = self._headlight(lights)

    def paint(self, picture: Colours, lights: Lights, air: Floats) -> None:
        """Draw the ground into the rows below the horizon. `air` is the haze's luminance."""
        below = picture[self._first_row :]
        self._surface(below, lights.way)
        below *= (self._lamps(lights.way) + self._own + self._dazzle(lights)) / np.float32(np.pi)
        clear = np.exp(-self._depth / HAZE_M).astype(np.float32)[:, None, None]
        below *= clear
        below += (1 - clear) * air.astype(np.float32)

    def _surface(self, below: Colours, way: float) -> None:
        place = (self._depth + way + _BEHIND) / _STEP_Z
        map_x = ((self._x + _HALF_WIDTH) / _STEP_X - 0.5).astype(np.float32)
        # One pass per level of shortening: at most eight.
        for level in np.unique(self._level):
            rows = np.flatnonzero(self._level == level)
            part = slice(rows[0], rows[-1] + 1)
            along = (place[part, None] / 2**level - 0.5).astype(np.float32)
            below[part] = cv2.remap(
                self._levels[level],
                map_x[part],
                np.ascontiguousarray(np.broadcast_to(along, map_x[part].shape)),
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )

    def _lamps(self, way: float) -> Colours:
        map_x = ((self._x + _HALF_WIDTH) / _LIGHT_STEP - 0.5).astype(np.float32)
        along = ((self._depth + way + _BEHIND) / _LIGHT_STEP - 0.5).astype(np.float32)
        return np.asarray(
            cv2.remap(
                self._light,
                map_x,
                np.ascontiguousarray(np.broadcast_to(along[:, None], map_x.shape)),
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )
        )

    def _points(self, step: int) -> tuple[Floats, tuple[int, int]]:
        x = self._x[::step, ::step]
        z = np.broadcast_to(self._depth[::step, None], x.shape)
        points = np.stack([x, np.zeros_like(x), z], axis=-1)
        return points.reshape(-1, 3), x.shape

    def _headlight(self, lights: Lights) -> Colours:
        """Return the light of the car's own headlamps, which moves with the car."""
        if lights.glow.headlamp_cd <= 0:
            return np.zeros((len(self._depth), self._view.width, 3), dtype=np.float32)
        points, shape = self._points(1)
        metres = np.sqrt((points**2).sum(axis=1))
        towards = -points / np.maximum(metres, 1.0)[:, None]
        grazing = lights.headlamps(points, UP)
        head_on = lights.headlamps(points, np.array([0.0, 0.0, -1.0])) * np.abs(towards[:, 2])
        light = (grazing + _RETRO * 2.4 * head_on).reshape(shape)
        return np.asarray(light[..., None] * HEADLIGHT, dtype=np.float32)

    def _dazzle(self, lights: Lights) -> Colours | float:
        """Return the light of oncoming headlamps that the road reflects towards the camera."""
        if not len(lights.oncoming):
            return 0.0
        points, shape = self._points(6)
        forward = np.array([0.0, 0.75, 0.66])  # rough asphalt reflects it forward to the camera
        light = lights.dazzle(points, forward).reshape(shape).astype(np.float32)
        size = (self._view.width, len(self._depth))
        whole = cv2.resize(light, size)[..., None]
        return np.asarray(whole * HEADLIGHT, dtype=np.float32)


def _levels(albedo: Colours) -> list[Colours]:
    """Return versions shortened along the road, for far rows that cover metres of it."""
    levels = [albedo]
    for _ in range(_N_LEVELS - 1):
        last = levels[-1]
        size = (last.shape[1], max(last.shape[0] // 2, 1))
        levels.append(cv2.resize(last, size, interpolation=cv2.INTER_AREA))
    return levels


def _lamp_light(lights: Lights, length_m: float) -> Colours:
    """Return the lux of sky, street lamps and floodlights on the ground, over world x and z."""
    x = (np.arange(int(2 * _HALF_WIDTH / _LIGHT_STEP)) + 0.5) * _LIGHT_STEP - _HALF_WIDTH
    z = (np.arange(int((length_m + _BEHIND) / _LIGHT_STEP)) + 0.5) * _LIGHT_STEP - _BEHIND
    rows = []
    # In strips along the road, so that each handles only the lamps near it.
    for strip in np.array_split(z, max(len(z) // 24, 1)):
        wide, long = np.meshgrid(x, strip - lights.way)
        points = np.stack([wide, np.zeros_like(wide), long], axis=-1).reshape(-1, 3)
        still = Lights(lights.glow, lights.lamps, lights.way)
        rows.append(still.at(points, UP, own=False).reshape(len(strip), len(x), 3))
    return np.concatenate(rows).astype(np.float32)


def _albedo(recording: Recording, length_m: float) -> Colours:
    generator = np.random.default_rng([23, zlib.crc32(recording.name.encode())])
    road = recording.road
    shape = (int((length_m + _BEHIND) / _STEP_Z), int(2 * _HALF_WIDTH / _STEP_X))
    x = np.arange(0.5, shape[1], dtype=np.float64) * _STEP_X - _HALF_WIDTH
    z = np.arange(0.5, shape[0], dtype=np.float64) * _STEP_Z - _BEHIND
    edge = road.right + road.parking_right + road.pavement
    far_edge = road.left - road.parking_left - road.pavement
    wobble = (0.12 if road.pavement == 0 else 0.0) * noise(generator, (shape[0], 1), (14, 1))
    paved = (x < edge + wobble) & (x > far_edge + wobble)
    ground = np.where(
        paved[..., None], _asphalt(generator, shape, x), _grass(generator, shape)
    ).astype(np.float32)
    if road.pavement == 0:
        for line, side in ((road.left, -1), (road.right, 1)):
            share = 0.6 * np.exp(-(((x - line - side * 0.4) / 0.3) ** 2))
            ground += (_GRAVEL - ground) * share[None, :, None].astype(np.float32)
    else:
        _pavements(ground, x, z, road, generator)
    _patches(ground, x, z, road, generator)
    _markings(ground, x, z, road, generator)
    return np.clip(ground, 0.012, 0.9).astype(np.float32)


def _asphalt(generator: np.random.Generator, shape: tuple[int, int], x: Floats) -> Floats:
    tone = 1 + 0.07 * noise(generator, shape, (1.2, 1.2)) + 0.06 * noise(generator, shape, (40, 22))
    for track in (-0.78, 0.78, -4.25, -2.7):
        tone -= 0.10 * np.exp(-(((x - track) / 0.3) ** 2)).astype(np.float32)
    return np.asarray(tone[..., None] * _ASPHALT)


def _grass(generator: np.random.Generator, shape: tuple[int, int]) -> Floats:
    tone = 1 + 0.22 * noise(generator, shape, (1.5, 2.5)) + 0.16 * noise(generator, shape, (9, 18))
    dry = np.clip(0.5 + 0.5 * noise(generator, shape, (60, 80)), 0, 1)[..., None]
    return np.asarray(tone[..., None] * (_GRASS + dry * np.array([0.045, 0.022, 0.012])))


def _pavements(
    ground: Colours, x: Floats, z: Floats, road: Road, generator: np.random.Generator
) -> None:
    for inner, side in ((road.right + road.parking_right, 1), (road.left - road.parking_left, -1)):
        away = side * (x - inner)
        slabs = (away > 0.15) & (away < road.pavement)
        joints = (np.abs((away[None, :] / 0.6) % 1 - 0.5) > 0.46) | (
            np.abs((z[:, None] / 0.9) % 1 - 0.5) > 0.455
        )
        n_slabs = (int(len(z) / 9) + 2, int(slabs.sum() / 12) + 2)
        tones = 1 + 0.08 * generator.standard_normal(n_slabs).astype(np.float32)
        size = (int(slabs.sum()), len(z))
        tiles = cv2.resize(tones, size, interpolation=cv2.INTER_NEAREST)
        tiles += 0.05 * noise(generator, tiles.shape, (2, 2))
        tiles *= np.where(joints[:, slabs], 0.72, 1.0)
        ground[:, slabs] = tiles[..., None] * _SLABS
        ground[:, (away > 0) & (away <= 0.15)] = _KERB
        ground[:, (away > -0.14) & (away <= 0)] *= 0.72
        if road.parking_right:
            ground[:, (away > -2.1) & (away <= -1.98)] += np.float32(0.05)


def _patches(
    ground: Colours, x: Floats, z: Floats, road: Road, generator: np.random.Generator
) -> None:
    """Draw repairs of newer or older asphalt, seams, manhole covers."""
    for _ in range(int(z[-1] / 13)):
        x0, z0 = generator.uniform(road.left, road.right - 1), generator.uniform(0, z[-1])
        wide, long = generator.uniform(0.6, 2.2), generator.uniform(1.5, 7)
        columns = (x > x0) & (x < min(x0 + wide, road.right))
        rows = (z > z0) & (z < z0 + long)
        ground[np.ix_(rows, columns)] *= generator.choice([0.72, 0.8, 1.16])
    for z0 in generator.uniform(5, z[-1], int(z[-1] / 38)) if road.pavement else ():
        near = np.abs(z - z0) < 0.5
        x0 = generator.choice([-0.1, -3.3])
        disc = np.hypot(x[None, :] - x0, z[near, None] - z0) < 0.36
        ground[near] *= np.where(disc, 0.55, 1.0)[..., None].astype(np.float32)
    for seam in (-1.72, 1.62 if road.pavement else -5.0):
        ground[:, np.abs(x - seam) < 0.03] *= 0.8


def _markings(
    ground: Colours, x: Floats, z: Floats, road: Road, generator: np.random.Generator
) -> None:
    """Draw worn white paint."""
    lines = np.zeros(ground.shape[:2], dtype=bool)
    middle = (road.left + road.right) / 2
    lines |= ((z % 12.0) < 4.0)[:, None] & (np.abs(x - middle) < 0.07)
    if not road.pavement:
        for line in (road.left + 0.22, road.right - 0.22):
            lines |= np.abs(x - line) < 0.07
    for zebra in road.zebras:
        bars = ((x - road.left) % 1.0 < 0.5) & (x > road.left) & (x < road.right)
        lines |= (np.abs(z - zebra) < 1.7)[:, None] & bars
    worn = np.clip(0.85 + 0.16 * noise(generator, (len(z), len(x)), (3, 3)), 0.35, 1.0)
    cover = (lines * worn)[..., None].astype(np.float32)
    ground += cover * (_PAINT.astype(np.float32) - ground)
