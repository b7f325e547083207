"""Drawing of houses, trees, lamps, poles, signs, posts and cabinets in visible light."""

from __future__ import annotations

import zlib
from functools import lru_cache
from itertools import pairwise
from typing import Final

import cv2
import numpy as np

from tools.sample.camera import Floats
from tools.sample.objects import foliage, sidewall, upright
from tools.sample.scene import Thing
from tools.sample.visible.light import LAMPLIGHT, TO_CAMERA
from tools.sample.visible.paint import Colours
from tools.sample.visible.stage import Face, Stage
from tools.sample.visible.wardrobe import WALLS, of_place

_STOREY_M: Final = 2.8
_SPRITE: Final = (256, 200)
_METAL: Final = np.array([0.17, 0.175, 0.18])
_WOOD: Final = np.array([0.11, 0.085, 0.06])
_WHITE: Final = np.array([0.70, 0.70, 0.69])
_RED: Final = np.array([0.45, 0.03, 0.03])
_INK: Final = np.full(3, 0.02)
_GLASS: Final = np.array([0.03, 0.034, 0.04])
_LEAVES: Final = np.array([0.055, 0.075, 0.03])
_ROOF: Final = np.array([0.10, 0.055, 0.042])
_ROOM: Final = np.array([1.55, 0.98, 0.46])
_LIT_SHARE: Final = 0.3
_PLACES: Final = {
    "top": (-0.2, 0.32, 0.2, 0.44),
    "middle": (-0.2, -0.06, 0.2, 0.06),
    "bottom": (-0.2, -0.44, 0.2, -0.32),
    "upper left": (-0.2, 0.0, -0.08, 0.44),
    "upper right": (0.08, 0.0, 0.2, 0.44),
    "lower left": (-0.2, -0.44, -0.08, 0.0),
    "lower right": (0.08, -0.44, 0.2, 0.0),
}
"""Left, bottom, right, top of the bars of a digit, in radii of the sign."""
_ALL: Final = frozenset(_PLACES)
_BARS: Final = {
    "0": _ALL - {"middle"},
    "3": _ALL - {"upper left", "lower left"},
    "5": _ALL - {"upper right", "lower left"},
    "8": _ALL,
}
_WINDOWS_M: Final = 120.0
"""Maximum distance of drawn windows along the road. Farther ones are a pixel wide."""


def draw_thing(stage: Stage, thing: Thing, ahead_m: float) -> None:
    """Paint one object whose near side is `ahead_m` metres ahead."""
    if thing.kind in ("tree", "bush"):
        _plant(stage, thing, ahead_m)
    elif thing.kind == "house":
        _house(stage, thing, ahead_m)
    elif ahead_m > 0.8:
        draw = {"lamp": _lamp, "pole": _pole, "sign": _sign, "plate": _plate, "post": _post}
        draw["cabinet"] = _cabinet
        draw[thing.kind](stage, thing, ahead_m)


def _house(stage: Stage, thing: Thing, z: float) -> None:
    side = float(np.sign(thing.x))
    wall_x, outer = thing.x - side * thing.width_m / 2, thing.x + side * thing.width_m / 2
    far, top = z + thing.depth_m, thing.size_m
    if far < 2:
        return
    colour = of_place(WALLS, thing.x, thing.z)
    ridge = np.array(
        [[wall_x, top, z], [wall_x, top, far], [thing.x, top + 2.6, far], [thing.x, top + 2.6, z]]
    )
    stage.lit([(ridge, _ROOF)], np.array([-0.5 * side, 0.87, 0.0]))
    gable = np.array(
        [[wall_x, 0, z], [wall_x, top, z], [thing.x, top + 2.6, z], [outer, top, z], [outer, 0, z]]
    )
    generator = np.random.default_rng([26, zlib.crc32(f"{thing.x:.2f} {thing.z:.2f}".encode())])
    panes, rooms = _gable_windows(thing, z, generator)
    stage.wall([(gable, colour), *panes], TO_CAMERA)
    stage.shining(rooms)
    panes, rooms = _windows(thing, wall_x, z, generator) if z < _WINDOWS_M else ([], [])
    plinth = sidewall(wall_x, 0.0, 0.55, z, far)
    eaves = sidewall(wall_x, top - 0.25, top, z, far)
    wall = sidewall(wall_x, 0.0, top, z, far)
    base: list[Face] = [(wall, colour), (plinth, 0.55 * colour), (eaves, 0.6 * colour)]
    stage.wall([*base, *panes], np.array([-side, 0.0, 0.0]))
    stage.shining(rooms)


def _gable_windows(
    thing: Thing, z: float, generator: np.random.Generator
) -> tuple[list[Face], list[Face]]:
    panes: list[Face] = []
    rooms: list[Face] = []
    for storey in range(int(thing.size_m / _STOREY_M)):
        for share in (-0.2, 0.2):
            low, x = storey * _STOREY_M + 0.95, thing.x + share * thing.width_m
            panes.append((upright(x - 0.56, x + 0.56, low - 0.06, low + 1.4, z), _WHITE))
            glass = upright(x - 0.48, x + 0.48, low, low + 1.32, z)
            panes.append((glass, _GLASS))
            if generator.random() < _LIT_SHARE:
                rooms.append((glass, _ROOM * generator.uniform(0.8, 3.0)))
    return panes, rooms


def _windows(
    thing: Thing, x: float, z: float, generator: np.random.Generator
) -> tuple[list[Face], list[Face]]:
    """Return windows of the wall along the road (frames and dark panes), and lit rooms."""
    panes: list[Face] = []
    rooms: list[Face] = []
    n_across = max(int(thing.depth_m / 2.7), 1)
    gap = thing.depth_m / n_across
    door = int(generator.integers(n_across))
    for storey in range(int(thing.size_m / _STOREY_M)):
        for place in range(n_across):
            middle, low = z + (place + 0.5) * gap, storey * _STOREY_M + 0.95
            lit = generator.random() < _LIT_SHARE
            bright = generator.uniform(0.8, 3.5)
            if storey == 0 and place == door:
                panes.append((sidewall(x, 0.0, 2.2, middle - 0.55, middle + 0.55), _WOOD))
                continue
            frame = sidewall(x, low - 0.08, low + 1.42, middle - 0.60, middle + 0.60)
            panes.append((frame, _WHITE))
            for start, stop in ((-0.50, -0.04), (0.04, 0.50)):
                glass = sidewall(x, low, low + 1.32, middle + start, middle + stop)
                panes.append((glass, _GLASS))
                if lit:
                    rooms.append((glass, _ROOM * bright))
    return panes, rooms


def _mast(stage: Stage, x: float, width: float, top: float, z: float, albedo: Floats) -> None:
    """Draw a round mast in pieces, each in its own light."""
    heights = np.linspace(0.0, top, 15)
    shades = ((-0.5, 0.5, 0.75), (-0.25, 0.35, 1.15))
    pieces: list[Face] = [
        (upright(x + a * width, x + b * width, low, high, z), share * albedo)
        for low, high in pairwise(heights)
        for a, b, share in shades
    ]
    stage.lit(pieces, TO_CAMERA, wrap=0.4)


def _lamp(stage: Stage, thing: Thing, z: float) -> None:
    side = float(np.sign(thing.x))
    _mast(stage, thing.x, 0.15, thing.size_m, z, _METAL)
    end, y = thing.x - side * 1.3, thing.size_m
    arm = np.array(
        [[thing.x, y - 0.14, z], [thing.x, y, z], [end, y + 0.12, z], [end, y + 0.02, z]]
    )
    stage.lit([(arm, _METAL)], TO_CAMERA)
    head = np.array(
        [
            [end - 0.02, y - 0.02, z],
            [end + side * 0.62, y - 0.02, z],
            [end + side * 0.5, y + 0.16, z],
            [end + side * 0.1, y + 0.16, z],
        ]
    )
    if stage.glow.lamp_cd <= 0:
        stage.lit([(head, _METAL)], TO_CAMERA)
        return
    stage.shining([(head, LAMPLIGHT * 0.12 * stage.glow.lamp_cd)])
    pixel, depth = stage.view.project(np.array([end + side * 0.3, y, z]))
    radius = 0.30 * stage.view.focal_px / max(float(depth), 1.0)
    clear, _ = stage.veil(z)
    stage.easel.glow(pixel, radius + 1.0, LAMPLIGHT * 0.035 * stage.glow.lamp_cd * clear)
    stage.easel.glow(pixel, 5 * radius + 5.0, LAMPLIGHT * 0.0012 * stage.glow.lamp_cd * clear)


def _pole(stage: Stage, thing: Thing, z: float) -> None:
    _mast(stage, thing.x, thing.width_m, thing.size_m, z, _WOOD)
    y = thing.size_m - 0.5
    stage.lit([(upright(thing.x - 0.9, thing.x + 0.9, y, y + 0.12, z), _WOOD)], TO_CAMERA)


def _sign(stage: Stage, thing: Thing, z: float) -> None:
    _mast(stage, thing.x, 0.07, thing.size_m - 0.1, z, _METAL)
    _plate(stage, thing, z)


def _plate(stage: Stage, thing: Thing, z: float) -> None:
    """Draw the plate of a sign, whose film reflects headlight back to the car."""
    half = thing.width_m / 2
    middle = np.array([thing.x, thing.size_m - half, z])
    angle = np.linspace(0, 2 * np.pi, 28, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(28)], axis=1)
    back = stage.lights.headlamps(middle[None, :], TO_CAMERA)[0]
    gain = 1 + 6 * back / (back + 3.0)
    edge = _INK if thing.shows == "end" else _RED * gain
    inner = 0.93 if thing.shows == "end" else 0.74
    faces = [(middle + half * rim, edge), (middle + inner * half * rim, _WHITE * gain)]
    strokes = _strokes(thing.shows)
    faces += [(middle + half * np.pad(stroke, ((0, 0), (0, 1))), _INK) for stroke in strokes]
    stage.lit(faces, TO_CAMERA)


def _strokes(shows: str) -> list[Floats]:
    """Return the text of a sign of radius 1 as polygons, (4, 2). Digits have seven bars."""
    if shows == "end":
        return [np.array([[-0.68, -0.48], [-0.48, -0.68], [0.68, 0.48], [0.48, 0.68]])]
    strokes = []
    for place, digit in enumerate(shows):
        x = 0.56 * (place - (len(shows) - 1) / 2)
        for bar in _BARS[digit]:
            left, bottom, right, top = _PLACES[bar]
            corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
            strokes.append(np.array(corners) + np.array([x, 0.0]))
    return strokes


def _post(stage: Stage, thing: Thing, z: float) -> None:
    half = thing.width_m / 2
    black = np.full(3, 0.03)
    back = stage.lights.headlamps(np.array([[thing.x, 0.8, z]]), TO_CAMERA)[0]
    film = _WHITE * (1 + 14 * back / (back + 2.0))
    faces = [
        (upright(thing.x - half, thing.x + half, 0.0, thing.size_m, z), _WHITE),
        (upright(thing.x - half, thing.x + half, 0.68, 0.92, z), black),
        (upright(thing.x - 0.4 * half, thing.x + 0.4 * half, 0.72, 0.88, z), film),
    ]
    stage.lit(faces, TO_CAMERA)


def _cabinet(stage: Stage, thing: Thing, z: float) -> None:
    half, top = thing.width_m / 2, thing.size_m
    side = float(np.sign(thing.x))
    colour = np.array([0.34, 0.35, 0.31])
    flank = sidewall(thing.x - side * half, 0, top, z, z + thing.depth_m)
    stage.wall([(flank, colour)], np.array([-side, 0.0, 0.0]))
    front = upright(thing.x - half, thing.x + half, 0, top, z)
    door = upright(thing.x - 0.02, thing.x + 0.02, 0.06 * top, 0.96 * top, z)
    cap = upright(thing.x - 1.05 * half, thing.x + 1.05 * half, 0.95 * top, 1.02 * top, z)
    stage.wall([(front, colour), (door, 0.4 * colour), (cap, 0.7 * colour)], TO_CAMERA)


def _plant(stage: Stage, thing: Thing, z: float) -> None:
    if z < 2.0:
        return
    seed = zlib.crc32(f"{thing.x:.2f} {thing.z:.2f}".encode())
    foot, depth = stage.view.project(np.array([thing.x, 0.0, z]))
    scale = stage.view.focal_px / float(depth)
    height = thing.size_m * scale * 1.02
    wide = (thing.width_m if thing.kind == "bush" else thing.size_m * 0.72) * scale
    # A sprite far larger than its place is read from a halved copy to avoid sparkling.
    levels = _leafy(seed % 7, thing.kind == "bush")
    shrink = max(_SPRITE[0] / max(height, 1.0), _SPRITE[1] / max(wide, 1.0))
    image, cover = levels[int(np.clip(np.floor(np.log2(max(shrink, 1.0))), 0, len(levels) - 1))]
    ups = thing.size_m * (1 - (np.arange(image.shape[0]) + 0.5) / image.shape[0])
    coarse = np.linspace(0.0, thing.size_m, 9)
    points = np.stack([np.full(9, thing.x), coarse, np.full(9, z)], axis=1)
    light = stage.luminance(points, TO_CAMERA, wrap=0.5)
    rows = np.stack([np.interp(ups, coarse, light[:, channel]) for channel in range(3)], axis=1)
    clear, veil = stage.veil(z)
    tint = 1 + 0.12 * np.array([(seed >> 3) % 5 - 2, 0, (seed >> 5) % 3 - 1])
    colours = image * (rows * clear)[:, None, :] * (_LEAVES * tint) + cover[..., None] * veil
    box = (foot[0] - wide / 2, foot[1] - height, foot[0] + wide / 2, foot[1])
    stage.easel.sprite(colours.astype(np.float32), cover, box)


@lru_cache(maxsize=16)
def _leafy(seed: int, low: bool) -> tuple[tuple[Colours, Colours], ...]:
    """Return the thermal picture's trees with more light and shade, as (image x 3, cover)."""
    generator = np.random.default_rng([27, seed])
    spots = cv2.GaussianBlur(generator.standard_normal(_SPRITE).astype(np.float32), (0, 0), 1.6)
    levels = []
    for image, cover in foliage(seed, low):
        size = (image.shape[1], image.shape[0])
        leaves = cv2.resize(spots / spots.std(), size, interpolation=cv2.INTER_AREA)
        tone = cover + 4.0 * (image - cover) + 0.28 * leaves * cover
        tone = np.clip(tone, 0.25 * cover, 1.9 * cover)
        levels.append((np.repeat(tone[..., None], 3, axis=2).astype(np.float32), cover))
    return tuple(levels)
