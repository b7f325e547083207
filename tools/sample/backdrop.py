"""Background: road and grass below the horizon, sky and skyline above."""

from __future__ import annotations

import zlib
from typing import Final

import cv2
import numpy as np

from tools.sample.camera import HEIGHT, WIDTH
from tools.sample.canvas import Picture
from tools.sample.scene import Recording

_STEP_X: Final = 0.05
_STEP_Z: Final = 0.1
_HALF_WIDTH: Final = 24.0
_BEHIND: Final = 4.0
_AHEAD: Final = 130.0


def noise(
    generator: np.random.Generator, shape: tuple[int, int], grain: tuple[float, float]
) -> Picture:
    """Return smooth noise of unit deviation with the given grain (rows, columns) in pixels."""
    coarse = (int(shape[0] / grain[0]) + 3, int(shape[1] / grain[1]) + 3)
    rough = generator.standard_normal(coarse).astype(np.float32)
    smooth = cv2.resize(rough, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
    return np.asarray(smooth, dtype=np.float32)


class Ground:
    """Road surface of a recording, seen from any point of the drive."""

    def __init__(self, recording: Recording):
        self._way = recording.way()
        self._camera = recording.camera
        texture = _texture(recording, float(self._way[-1]) + _AHEAD)
        # Far rows cover metres of road, so they are read from versions shortened along the road.
        self._levels = [texture]
        for _ in range(7):
            last = self._levels[-1]
            half = cv2.resize(
                last, (last.shape[1], last.shape[0] // 2), interpolation=cv2.INTER_AREA
            )
            self._levels.append(half.astype(np.float32))
        self._first_row = int(np.floor(recording.horizon)) + 1
        rows = np.arange(self._first_row, HEIGHT) + 0.5
        self._depth = self._camera.ground_depth(np.maximum(rows, recording.horizon + 0.4))
        spacing = np.abs(np.gradient(self._depth)) / _STEP_Z
        self._level = np.clip(np.ceil(np.log2(np.maximum(spacing, 1.0))), 0, 7).astype(int)
        columns = np.arange(WIDTH) + 0.5 - WIDTH / 2
        across = self._depth[:, None] * columns[None, :] / self._camera.focal_px
        self._map_x = ((across + _HALF_WIDTH) / _STEP_X - 0.5).astype(np.float32)
        self._haze = np.exp(-self._depth / 170)[:, None].astype(np.float32)
        self._haze_grey = recording.climate.haze

    def paint(self, picture: Picture, frame: int) -> None:
        """Draw the ground of one frame into the rows below the horizon."""
        place = (self._depth + self._way[frame] + _BEHIND) / _STEP_Z
        below = picture[self._first_row :]
        # One pass per level of shortening: at most eight.
        for level in np.unique(self._level):
            rows = np.flatnonzero(self._level == level)
            part = slice(rows[0], rows[-1] + 1)
            map_z = np.broadcast_to(
                (place[part, None] / 2**level - 0.5).astype(np.float32), self._map_x[part].shape
            )
            below[part] = cv2.remap(
                self._levels[level],
                self._map_x[part],
                np.ascontiguousarray(map_z),
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )
        below *= self._haze
        below += (1 - self._haze) * self._haze_grey


def _texture(recording: Recording, length_m: float) -> Picture:
    generator = np.random.default_rng([3, zlib.crc32(recording.name.encode())])
    road, climate = recording.road, recording.climate
    shape = (int((length_m + _BEHIND) / _STEP_Z), int(2 * _HALF_WIDTH / _STEP_X))
    x = (np.arange(shape[1]) + 0.5) * _STEP_X - _HALF_WIDTH
    z = (np.arange(shape[0]) + 0.5) * _STEP_Z - _BEHIND
    grass = (
        climate.grass + 5 * noise(generator, shape, (2, 4)) + 6 * noise(generator, shape, (9, 18))
    )
    grass += 7 * noise(generator, shape, (60, 90))
    asphalt = (
        climate.road
        + 1.8 * noise(generator, shape, (2, 3))
        + 2.6 * noise(generator, shape, (40, 22))
    )
    # Tyres warm their tracks, oil darkens the middle of the lane.
    for track in (-0.78, 0.78, -4.25, -2.7):
        asphalt += 6.5 * np.exp(-(((x - track) / 0.26) ** 2)).astype(np.float32)
    edge = road.right + road.parking_right + road.pavement
    far_edge = road.left - road.parking_left - road.pavement
    wobble = (0.10 if road.pavement == 0 else 0.0) * noise(generator, (shape[0], 1), (14, 1))
    ground = np.where((x < edge + wobble) & (x > far_edge + wobble), asphalt, grass).astype(
        np.float32
    )
    if road.pavement == 0:
        _verges(ground, x, road.left, road.right, climate.road)
    else:
        _pavements(ground, x, z, recording, generator)
    _repairs(ground, x, z, recording, generator)
    _markings(ground, x, z, recording)
    return ground


def _verges(ground: Picture, x: Picture, left: float, right: float, road_grey: float) -> None:
    for line, side in ((left, -1), (right, 1)):
        gravel = np.exp(-(((x - line - side * 0.35) / 0.3) ** 2))
        ground += ((road_grey - 14 - ground) * 0.45 * gravel).astype(np.float32)


def _pavements(
    ground: Picture, x: Picture, z: Picture, recording: Recording, generator: np.random.Generator
) -> None:
    road = recording.road
    for inner, side in ((road.right + road.parking_right, 1), (road.left - road.parking_left, -1)):
        away = side * (x - inner)
        slabs = (away > 0.15) & (away < road.pavement)
        joints = (np.abs((away[None, :] / 0.6) % 1 - 0.5) > 0.455) | (
            np.abs((z[:, None] / 0.9) % 1 - 0.5) > 0.45
        )
        tiles = noise(generator, (len(z), len(x)), (9, 12))
        ground += np.where(slabs[None, :], 7 + 1.2 * tiles - 6 * joints, 0.0).astype(np.float32)
        ground += np.where((away > 0) & (away <= 0.15), 15.0, 0.0).astype(np.float32)
        ground -= np.where((away > -0.12) & (away <= 0), 9.0, 0.0).astype(np.float32)


def _repairs(
    ground: Picture, x: Picture, z: Picture, recording: Recording, generator: np.random.Generator
) -> None:
    """Draw patches of newer asphalt, seams, and manhole covers that emit warm air."""
    road = recording.road
    for _ in range(int(z[-1] / 14)):
        x0, z0 = generator.uniform(road.left, road.right - 1), generator.uniform(0, z[-1])
        wide, long = generator.uniform(0.6, 2.2), generator.uniform(1.5, 7)
        columns = (x > x0) & (x < min(x0 + wide, road.right))
        rows = (z > z0) & (z < z0 + long)
        ground[np.ix_(rows, columns)] += generator.choice([-8.0, 6.0, -5.0])
    if road.pavement:
        for z0 in generator.uniform(5, z[-1], int(z[-1] / 38)):
            x0 = generator.choice([-0.1, -3.3, 2.6])
            away = np.hypot(x[None, :] - x0, z[:, None] - z0)
            near = np.abs(z - z0) < 1.5
            ground[near] += np.where(
                away[near] < 0.36, 15.0, 6 * np.exp(-((away[near] / 0.5) ** 2))
            )
    for seam in (-1.72, 1.62 if road.pavement else -5.0):
        ground[:, np.abs(x - seam) < 0.03] -= 5


def _markings(ground: Picture, x: Picture, z: Picture, recording: Recording) -> None:
    """Draw the markings as faint lines, as paint is slightly cooler or warmer than asphalt."""
    road = recording.road
    middle = (road.left + road.right) / 2
    dash = (z % 12.0) < 4.0
    columns = np.abs(x - middle) < 0.07
    ground[np.ix_(dash, columns)] += 13
    if not road.pavement:
        for line in (road.left + 0.22, road.right - 0.22):
            ground[:, np.abs(x - line) < 0.07] += 11
    for zebra in road.zebras:
        rows = np.abs(z - zebra) < 1.7
        bars = ((x - road.left) % 1.0 < 0.5) & (x > road.left) & (x < road.right)
        ground[np.ix_(rows, bars)] += 15


def sky(recording: Recording) -> Picture:
    """Draw sky, haze and skyline of a recording, which do not move within 15 seconds."""
    generator = np.random.default_rng([4, zlib.crc32(recording.name.encode())])
    climate = recording.climate
    rows = (recording.horizon - np.arange(HEIGHT))[:, None] / recording.horizon
    height = np.clip(rows, 0, 1)
    glow = climate.sky + (climate.haze - climate.sky) * np.exp(-height / 0.28)
    clouds = 0.7 * noise(generator, (HEIGHT, WIDTH), (70, 190)) + 0.4 * noise(
        generator, (HEIGHT, WIDTH), (26, 80)
    )
    picture = (glow + 5.5 * np.clip(clouds, -0.6, 2) * height**0.5).astype(np.float32)
    for high, grain, grey in ((15, 90, 0.86), (9, 34, 0.97), (7, 11, 1.03)):
        line = (
            noise(generator, (1, WIDTH), (1, grain))[0]
            + 0.5 * noise(generator, (1, WIDTH), (1, grain / 4))[0]
        )
        ragged = 0.28 * noise(generator, (1, WIDTH), (1, 2.2))[0]
        top = recording.horizon - high * (0.75 + 0.42 * line + ragged).clip(0.12)
        depth = np.arange(HEIGHT)[:, None] + 0.5 - top[None, :]
        cover = np.clip(depth + 0.5, 0, 1).astype(np.float32)
        tone = climate.haze * grey + 1.5 * noise(generator, (HEIGHT, WIDTH), (3, 4))
        picture = picture * (1 - cover) + cover * tone.astype(np.float32)
    return np.asarray(picture, dtype=np.float32)
