"""Drawing of cars in visible light: paint, glass, wheels, lamps."""

from __future__ import annotations

from typing import Final

import numpy as np

from tools.sample.camera import Floats
from tools.sample.objects import sidewall, upright
from tools.sample.scene import Car
from tools.sample.vehicles import end_outline, profile, wheel_outline
from tools.sample.visible.light import HEADLIGHT, TO_CAMERA
from tools.sample.visible.sky import horizon_glow
from tools.sample.visible.stage import Face, Stage
from tools.sample.visible.wardrobe import CARS, of_place

_TYRE: Final = np.full(3, 0.022)
_RIM: Final = np.full(3, 0.30)
_GLASS: Final = np.full(3, 0.02)
_PLATE: Final = np.array([0.60, 0.58, 0.50])
_TAIL: Final = np.array([1.0, 0.045, 0.03])
_BEAM_CD_M2: Final = 5200.0
_TURN: Final = np.linspace(0, 2 * np.pi, 20, endpoint=False)
_TALL_M: Final = 1.7
"""Maximum height of a car that is not a van."""


def draw_car(stage: Stage, car: Car, ahead_m: float) -> None:
    """Paint a car whose middle is `ahead_m` metres ahead."""
    near, far = ahead_m - car.length_m / 2, ahead_m + car.length_m / 2
    if far < 1.5:
        return
    colour = of_place(CARS, car.x, car.z)
    _shadow(stage, car, near, far)
    _side(stage, car, near, colour)
    if near > 1.0:
        _top(stage, car, near, colour)
        _face(stage, car, near, colour)
    if near > 2.0 and car.oncoming and car.lights:
        _dazzling(stage, car, near)


def _shadow(stage: Stage, car: Car, near: float, far: float) -> None:
    for z in np.linspace(max(near, 1.5), max(far, 1.6), 5):
        pixel, depth = stage.view.project(np.array([car.x, 0.0, z]))
        scale = stage.view.focal_px / max(float(depth), 1.0)
        high = 0.30 * scale * stage.view.camera.mount_m / max(float(depth), 1.0) + 1.0
        stage.easel.shade(pixel, 0.62 * car.width_m * scale, high, 0.34)


def _side(stage: Stage, car: Car, near: float, colour: Floats) -> None:
    x = car.x - float(np.sign(car.x)) * car.width_m / 2
    outline = profile(car)
    body = np.stack([np.full(len(outline), x), outline[:, 1], near + outline[:, 0]], axis=1)
    h, long = car.height_m, car.length_m
    sill = sidewall(x, 0.28, 0.40, near + 0.05 * long, near + 0.95 * long)
    start, stop = (0.46, 0.78) if car.oncoming else (0.22, 0.54)
    middle = (start + stop) / 2
    faces: list[Face] = [(body, colour), (sill, 0.4 * colour)]
    for z0, z1 in ((start, middle - 0.01), (middle + 0.01, stop)):
        faces.append((sidewall(x, 0.70 * h, 0.93 * h, near + z0 * long, near + z1 * long), _GLASS))
    seam = sidewall(x, 0.36, 0.69 * h, near + middle * long - 0.015, near + middle * long + 0.015)
    faces.append((seam, 0.5 * colour))
    for place in (0.19, 0.81):
        for radius, albedo in ((0.34, _TYRE), (0.20, _RIM), (0.07, _TYRE)):
            faces.append((wheel_outline(x, near + place * long, radius, _TURN), albedo))
    stage.wall(faces, np.array([-float(np.sign(car.x)), 0.0, 0.0]), soften=0.45)


def _top(stage: Stage, car: Car, near: float, colour: Floats) -> None:
    """Draw bonnet and windscreen, or boot and rear window, which mirror the sky."""
    h, long, half, x = car.height_m, car.length_m, car.width_m / 2, car.x
    is_van = h > _TALL_M
    if is_van and not car.oncoming:
        return
    tight, slim = half * (0.95 if is_van else 0.82), half * 0.95
    ledge, roof = (0.14, 0.20) if is_van else (0.27, 0.44) if car.oncoming else (0.10, 0.24)
    low, high = (0.55 * h, 0.62 * h) if is_van else (0.6 * h, 0.69 * h)
    z1, z2 = near + ledge * long, near + roof * long
    bonnet = np.array(
        [[x - half, low, near], [x + half, low, near], [x + slim, high, z1], [x - slim, high, z1]]
    )  # fmt: skip
    screen = np.array(
        [[x - slim, high, z1], [x + slim, high, z1], [x + tight, h, z2], [x - tight, h, z2]]
    )
    middle = screen.mean(axis=0)
    glass = middle + (screen - middle) * np.array([0.92, 0.86, 0.92])
    stage.lit([(screen, colour)], np.array([0.0, 0.6, -0.8]))
    stage.shining([(glass, 0.035 * horizon_glow(stage.glow) + 0.003 * stage.lights.driver_lux())])
    stage.lit([(bonnet, colour * 1.1)], np.array([0.0, 0.95, -0.3]))


def _face(stage: Stage, car: Car, near: float, colour: Floats) -> None:
    h, half, x = car.height_m, car.width_m / 2, car.x
    is_van = h > _TALL_M
    top = 0.61 * h if not is_van else 0.56 * h if car.oncoming else 0.97 * h
    faces: list[Face] = [
        (upright(x + wheel - 0.1, x + wheel + 0.1, 0.0, 0.4, near + 0.7), _TYRE)
        for wheel in (-half + 0.14, half - 0.14)
    ]
    faces += [
        (end_outline(car, near, top), colour),
        (upright(x - half * 0.96, x + half * 0.96, 0.26, 0.42, near), 0.45 * colour + 0.01),
        (upright(x - 0.26, x + 0.26, 0.47, 0.58, near), _PLATE),
    ]
    if is_van and not car.oncoming:
        faces.append((upright(x - half * 0.84, x + half * 0.84, 0.58 * h, 0.9 * h, near), _GLASS))
    if car.oncoming:
        faces.append((upright(x - 0.42, x + 0.42, 0.60, 0.72, near), _TYRE))
    faces += _lamps(stage, car, near)
    stage.wall(faces, TO_CAMERA, soften=0.45)


def _lamps(stage: Stage, car: Car, near: float) -> list[Face]:
    """Return lamps that are off: clear glass in front, red reflectors behind."""
    faces: list[Face] = []
    for side in (-1, 1):
        middle = np.array(
            [car.x + side * (car.width_m / 2 - 0.24), min(0.56 * car.height_m, 0.95) - 0.1]
        )
        lamp = np.stack(
            [middle[0] + 0.18 * np.cos(_TURN), middle[1] + 0.09 * np.sin(_TURN), np.full(20, near)],
            axis=1,
        )
        back = stage.lights.headlamps(lamp.mean(axis=0)[None, :], TO_CAMERA)[0]
        red = np.array([0.30, 0.02, 0.02]) * (1 + 2 * back / (back + 8.0))
        faces.append((lamp, np.full(3, 0.42) if car.oncoming else red))
    if not car.oncoming and car.speed > 0:
        faces += [(face, 30 * _TAIL) for face, _ in faces]
    return faces


def _dazzling(stage: Stage, car: Car, near: float) -> None:
    """Draw headlamps that shine into the camera, each with a core and a wide veil."""
    for side in (-0.66, 0.66):
        pixel, depth = stage.view.project(np.array([car.x + side, 0.70, near]))
        scale = stage.view.focal_px / max(float(depth), 1.0)
        off_axis = np.degrees(np.arctan2(abs(car.x + side), near))
        dim = 0.04 + 0.96 * float(np.exp(-((off_axis / 9.0) ** 2)))
        stage.easel.glow(pixel, max(0.11 * scale, 1.2), HEADLIGHT * _BEAM_CD_M2 * dim)
        stage.easel.glow(pixel, 0.32 * scale + 3.0, HEADLIGHT * 0.02 * _BEAM_CD_M2 * dim)
        stage.easel.glow(pixel, 1.1 * scale + 14.0, HEADLIGHT * 0.0007 * _BEAM_CD_M2 * dim)
