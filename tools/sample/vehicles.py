"""Drawing of cars: cold metal and glass, warm tyres, hot engine, exhaust and lamps."""

from __future__ import annotations

import numpy as np

from tools.sample.camera import Camera, Floats
from tools.sample.canvas import Canvas
from tools.sample.objects import Sketch, sidewall, upright
from tools.sample.scene import Car, Climate


def draw_car(canvas: Canvas, car: Car, ahead_m: float, camera: Camera, climate: Climate) -> None:
    """Paint a car whose middle is `ahead_m` metres ahead."""
    near, far = ahead_m - car.length_m / 2, ahead_m + car.length_m / 2
    if far < 1.5:
        return
    sketch = Sketch(camera, climate)
    metal, glass = climate.things - 2, climate.things - 20
    half = car.width_m / 2
    _shade_below(canvas, car, near, far, camera, climate)
    inner = car.x - np.sign(car.x) * half
    _side(sketch, car, inner, near, metal, glass)
    if near > 1.0:
        _top(sketch, car, near, metal, glass)
        _face(sketch, car, near, metal, glass)
    canvas.paint(sketch.shapes, soften=0.4 + 2.2 / max(near, 3.0), texture=1.2)
    if near > 2.0:
        _glows(canvas, car, near, camera)


def profile(car: Car) -> Floats:
    """Return the outline of the side: metres from the near end and height, near end first."""
    h, long = car.height_m, car.length_m
    if h > 1.7:
        line = [
            (0.0, 0.3),
            (0.0, 0.8 * h),
            (0.12, h),
            (0.80, h),
            (0.86, 0.62 * h),
            (1.0, 0.55 * h),
            (1.0, 0.3),
        ]
    else:
        line = [(0.0, 0.28), (0.01, 0.66 * h), (0.10, 0.70 * h), (0.20, 0.97 * h), (0.27, h),
                (0.56, h), (0.73, 0.68 * h), (0.97, 0.58 * h), (1.0, 0.28)]  # fmt: skip
    outline = np.array(line)
    if car.oncoming:
        outline = np.stack([1 - outline[::-1, 0], outline[::-1, 1]], axis=1)
    return np.asarray(outline * np.array([long, 1.0]))


def end_outline(car: Car, near: float, top: float) -> Floats:
    """Return the outline of the visible end, metres, (8, 3). `top` is where its windows begin."""
    x, half, belt = car.x, car.width_m / 2, 0.42 * top + 0.1
    return np.array(
        [[x - half * 0.93, 0.24, near], [x + half * 0.93, 0.24, near], [x + half, belt, near],
         [x + half * 0.97, top * 0.95, near], [x + half * 0.88, top, near],
         [x - half * 0.88, top, near],
         [x - half * 0.97, top * 0.95, near], [x - half, belt, near]]
    )  # fmt: skip


def wheel_outline(x: float, z: float, radius: float, angles: Floats) -> Floats:
    """Return corners of a wheel, or of a ring in it, at these angles: metres, shape (n, 3)."""
    across, up = np.full(len(angles), x), 0.33 + radius * np.sin(angles)
    return np.stack([across, up, z + radius * np.cos(angles)], axis=1)


def _side(sketch: Sketch, car: Car, x: float, near: float, metal: float, glass: float) -> None:
    outline = profile(car)
    face = np.stack([np.full(len(outline), x), outline[:, 1], near + outline[:, 0]], axis=1)
    sketch.add(face, metal + 3)
    h, long = car.height_m, car.length_m
    front = 0.0 if car.oncoming else 1.0
    bonnet = (0.02, 0.24) if car.oncoming else (0.76, 0.98)
    if car.heat > 0:
        z0, z1 = near + bonnet[0] * long, near + bonnet[1] * long
        sketch.add(sidewall(x, 0.42, 0.60 * h, z0, z1), metal + 46 * car.heat)
    start, stop = (0.46, 0.78) if car.oncoming else (0.22, 0.54)
    sketch.add(sidewall(x, 0.70 * h, 0.93 * h, near + start * long, near + stop * long), glass)
    angle = np.linspace(0, 2 * np.pi, 18, endpoint=False)
    for place in (0.19, 0.81):
        middle = near + place * long
        driven = abs(place - front) < 0.5
        warm = 14 + 60 * car.heat * (1.0 if driven else 0.6)
        for radius, grey in ((0.33, metal - 6 + warm), (0.20, metal + 0.4 * warm + 18 * car.heat)):
            sketch.add(wheel_outline(x, middle, radius, angle), grey)


def _top(sketch: Sketch, car: Car, near: float, metal: float, glass: float) -> None:
    """Draw bonnet and windscreen, or boot and rear window, seen from slightly above."""
    h, long, half = car.height_m, car.length_m, car.width_m / 2
    tight = half * 0.82
    if h > 1.7:
        return
    ledge, roof = (0.27, 0.44) if car.oncoming else (0.10, 0.24)
    slim, z1, z2 = half * 0.95, near + ledge * long, near + roof * long
    x = car.x
    bonnet = np.array(
        [[x - half, 0.6 * h, near], [x + half, 0.6 * h, near],
         [x + slim, 0.69 * h, z1], [x - slim, 0.69 * h, z1]]
    )  # fmt: skip
    screen = np.array(
        [[x - slim, 0.68 * h, z1], [x + slim, 0.68 * h, z1], [x + tight, h, z2], [x - tight, h, z2]]
    )
    sketch.add(screen, metal)
    middle = screen.mean(axis=0)
    sketch.add(middle + (screen - middle) * np.array([0.90, 0.82, 0.9]), glass)
    sketch.add(bonnet, metal + 4 + (66 * car.heat if car.oncoming else 0.0))


def _face(sketch: Sketch, car: Car, near: float, metal: float, glass: float) -> None:
    h, half, x = car.height_m, car.width_m / 2, car.x
    for wheel in (-half + 0.14, half - 0.14):
        sketch.add(
            upright(x + wheel - 0.1, x + wheel + 0.1, 0.0, 0.4, near + 0.1),
            metal + 10 + 55 * car.heat,
        )
    top = 0.61 * h if h <= 1.7 else 0.97 * h
    sketch.add(end_outline(car, near, top), metal)
    sketch.add(upright(x - half * 0.96, x + half * 0.96, 0.27, 0.45, near), metal - 7)
    if h > 1.7:
        sketch.add(upright(x - half * 0.84, x + half * 0.84, 0.58 * h, 0.9 * h, near), glass)
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    for side in (-1, 1):
        lamp_x, lamp_y = x + side * (half - 0.24), 0.56 * h - 0.10
        bright = 22.0 + 105 * car.lights if car.oncoming else 8.0 + 22 * car.heat
        for size, share in ((1.0, 0.55), (0.7, 1.0)):
            lamp = np.stack(
                [
                    lamp_x + 0.17 * size * np.cos(angle),
                    lamp_y + 0.09 * size * np.sin(angle),
                    np.full(16, near),
                ],
                axis=1,
            )
            sketch.add(lamp, metal + share * bright)
    if car.oncoming:
        sketch.add(upright(x - 0.45, x + 0.45, 0.40, 0.58, near), metal - 4 + 120 * car.heat)
        for slat in (0.44, 0.49, 0.54):
            sketch.add(
                upright(x - 0.43, x + 0.43, slat, slat + 0.014, near), metal - 8 + 40 * car.heat
            )
        sketch.add(upright(x - 0.52, x + 0.52, 0.26, 0.37, near), metal + 72 * car.heat)
    elif car.heat > 0:
        sketch.add(upright(x - 0.62, x - 0.44, 0.22, 0.34, near), metal + 165 * car.heat)
    sketch.add(upright(x - 0.26, x + 0.26, 0.47, 0.58, near), metal - 14)


def _shade_below(
    canvas: Canvas, car: Car, near: float, far: float, camera: Camera, climate: Climate
) -> None:
    """Draw the warm road below a car, and the reflection of its warm sump."""
    below = Sketch(camera, climate)
    half = car.width_m / 2
    z0, z1 = max(near - 0.1, 1.0), max(far, 1.2)
    patch = np.array(
        [
            [car.x - half, 0.0, z0],
            [car.x + half, 0.0, z0],
            [car.x + half, 0.0, z1],
            [car.x - half, 0.0, z1],
        ]
    )
    below.add(patch, climate.road + 12 + 34 * car.heat)
    canvas.paint(below.shapes, soften=1.0)


def _glows(canvas: Canvas, car: Car, near: float, camera: Camera) -> None:
    scale = camera.focal_px / near
    if car.oncoming:
        pixel, _ = camera.project(np.array([car.x, 0.6, near]))
        canvas.glow(pixel[0], pixel[1], 0.7 * scale, 26 * car.heat)
        if car.lights:
            for side in (-0.68, 0.68):
                pixel, _ = camera.project(np.array([car.x + side, 0.70, near]))
                canvas.glow(pixel[0], pixel[1], max(0.2 * scale, 1.3), 85)
    elif car.heat > 0:
        pixel, _ = camera.project(np.array([car.x - 0.53, 0.28, near]))
        canvas.glow(pixel[0], pixel[1], 0.22 * scale, 50 * car.heat)
