"""Drawing of people: warm limbs, hotter heads and hands, cooler shoes."""

from __future__ import annotations

from typing import Final

import numpy as np

from tools.sample.body import CAPSULES, WHEEL_M, radii
from tools.sample.camera import Camera, Floats
from tools.sample.canvas import Canvas, Shape
from tools.sample.scene import Climate, Person

_WARMTH: Final = {"head": 1.0, "hand": 0.92, "torso": 0.56, "arm": 0.50, "leg": 0.45, "shoe": 0.24}
_CIRCLE: Final = np.stack(
    [
        np.cos(np.linspace(0, 2 * np.pi, 20, endpoint=False)),
        np.sin(np.linspace(0, 2 * np.pi, 20, endpoint=False)),
    ],
    axis=1,
)


def capsule_outline(a: Floats, b: Floats, radius_a: float, radius_b: float) -> Floats:
    """Return the outline of a tapered capsule between two image points, shape (corners, 2)."""
    along = b - a
    angle = np.arctan2(along[1], along[0])
    turn = np.linspace(np.pi / 2, 3 * np.pi / 2, 9) + angle
    back = a + radius_a * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    front = b + radius_b * np.stack([np.cos(turn + np.pi), np.sin(turn + np.pi)], axis=1)
    return np.concatenate([back, front])


def draw_person(
    canvas: Canvas, person: Person, body: Floats, camera: Camera, climate: Climate, haze: float
) -> None:
    """Paint one person.

    Parameters
    ----------
    body
        Joints relative to the car at this frame, metres, shape (joints, 3).
    haze
        Share of the grey level that remains after haze, 0 to 1.
    """
    pixels, depth = camera.project(body)
    if depth[0] < 1.5:
        return
    scale = camera.focal_px / np.maximum(depth, 0.5)
    size = radii(person)
    away = float(body[8, 2] + body[12, 2] - body[7, 2] - body[11, 2]) > 0.05
    layers: list[tuple[float, Shape]] = []
    for limb, (radius_a, radius_b) in zip(CAPSULES, size, strict=True):
        grey = _grey(limb.part, person, climate, away=away, haze=haze)
        outline = capsule_outline(
            pixels[limb.a], pixels[limb.b], radius_a * scale[limb.a], radius_b * scale[limb.b]
        )
        order = -(depth[limb.a] + depth[limb.b]) / 2 + (0.05 if limb.part == "head" else 0.0)
        layers.append((float(order), (outline, grey)))
        if limb.part == "head":
            continue
        ends, wide = pixels[[limb.a, limb.b]], scale[limb.a] * np.array([radius_a, radius_b])
        layers += _core(ends, wide, grey, float(order))
    if not away:
        layers.append(
            _face(person, body, pixels, size[-1] * scale[4], climate, haze, -float(depth[4]))
        )
    if person.cyclist:
        layers += _bicycle(pixels, depth, scale, climate)
    layers.sort(key=lambda layer: layer[0])
    sharp = float(scale[0])
    canvas.paint(
        [shape for _, shape in layers],
        soften=0.35 + 0.013 * sharp,
        texture=0.8 + 2.0 * climate.contrast,
    )
    head, size_px = pixels[4], float(size[-1, 0] * scale[4])
    canvas.glow(head[0], head[1], 3.2 * size_px, 9 * climate.contrast)


def _grey(part: str, person: Person, climate: Climate, *, away: bool, haze: float) -> float:
    share = _WARMTH[part]
    if part == "head":
        # Hair and hoods insulate, so the back of a head is cooler than a face.
        share *= (0.66 if away else 0.76) * (0.86 + 0.14 * person.warmth)
    elif part == "hand":
        share *= 0.75 + 0.25 * person.warmth
    else:
        share *= 0.10 + 1.15 * person.warmth
    around = climate.things + 4
    return around + (climate.skin - around) * share * haze


def _core(ends: Floats, size: Floats, grey: float, order: float) -> list[tuple[float, Shape]]:
    """Return a core inside each limb, which is warmer because cloth lies on the body there."""
    if size.max() < 1.2:
        return []
    return [
        (
            order + 0.01 + 0.001 * step,
            (capsule_outline(*ends, *(share * size)), min(grey * gain, 250.0)),
        )
        for step, (share, gain) in enumerate(((0.72, 1.06), (0.42, 1.12)))
    ]


def _face(
    person: Person,
    body: Floats,
    pixels: Floats,
    size: Floats,
    climate: Climate,
    haze: float,
    order: float,
) -> tuple[float, Shape]:
    """Return the bare face, on the side to which the toes point."""
    aside = float(np.clip((body[8, 0] + body[12, 0] - body[7, 0] - body[11, 0]) / 0.35, -1, 1))
    shift = np.array([0.32 * aside * size[0], 0.12 * size[0]])
    around = climate.things + 4
    grey = around + (climate.skin - around) * haze * (0.93 + 0.07 * person.warmth)
    outline = capsule_outline(pixels[3] + shift, pixels[4] + shift, 0.66 * size[0], 0.62 * size[1])
    return order + 0.2, (outline, grey)


def _bicycle(
    pixels: Floats, depth: Floats, scale: Floats, climate: Climate
) -> list[tuple[float, Shape]]:
    """Return the wheels, which are thin from behind or ahead, and the bars of the frame."""
    order = -float(depth[0]) - 0.02
    cold, warm = climate.things - 18, climate.things + 48
    back, front, saddle, crank, bar = pixels[21:26]
    layers: list[tuple[float, Shape]] = []
    for centre, joint in ((back, 21), (front, 22)):
        radius = WHEEL_M * scale[joint]
        thin = max(0.13 * radius, abs(front[0] - back[0]) * 0.33)
        layers.append((order, (centre + _CIRCLE * np.array([thin, radius]), warm)))
        inner = np.array([max(thin - 0.12 * radius, 0.3 * thin), radius * 0.86])
        layers.append((order + 0.001, (centre + _CIRCLE * inner, cold)))
    width = 0.022 * scale[0]
    for a, b in ((back, saddle), (back, crank), (crank, bar), (saddle, bar), (bar, front)):
        layers.append((order + 0.002, (capsule_outline(a, b, width, width), cold)))
    wide = np.array([0.26 * scale[25], 0.0])
    layers.append(
        (order + 0.003, (capsule_outline(bar - wide, bar + wide, width, width), cold + 10))
    )
    return layers
