"""Drawing of people in visible light: coats, trousers, faces, lit limb by limb."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from tools.sample.body import CAPSULES, JOINTS, WHEEL_M, radii
from tools.sample.camera import Floats
from tools.sample.people import capsule_outline
from tools.sample.scene import Person
from tools.sample.visible.light import LUMA, TO_CAMERA
from tools.sample.visible.paint import Shape
from tools.sample.visible.stage import Stage
from tools.sample.visible.wardrobe import Outfit

_RINGS: Final = ((1.0, 0.62), (0.80, 0.90), (0.55, 1.08))
"""Shares of a limb's radius and of its light, as a round limb is darker at its rim."""
_SIDEWAYS: Final = 0.28
_CLOTH_RADIUS: Final = 1.06
_TURN: Final = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_HEAD, _CROWN = 3, 4
_HIPS: Final = (JOINTS.index("hip_l"), JOINTS.index("hip_r"))
_PIECES: Final = 4
_BLACK: Final = np.full(3, 0.02)


def draw_person(stage: Stage, person: Person, wears: Outfit, body: Floats) -> None:
    """Paint one person.

    Parameters
    ----------
    body
        Joints relative to the car at this frame, metres, shape (joints, 3).
    """
    pixels, depth = stage.view.project(body)
    if depth[0] < 1.5:
        return
    scale = stage.view.focal_px / np.maximum(depth, 0.5)
    _shadow(stage, body, float(scale[0]))
    layers = _limbs(stage, person, wears, body, (pixels, depth, scale))
    if person.cyclist:
        layers += _bicycle(stage, body, pixels, scale, -float(depth[0]) - 0.02)
    layers.sort(key=lambda layer: layer[0])
    stage.easel.paint(
        [shape for _, shape in layers],
        soften=0.35 + 0.004 * float(scale[0]),
        veil=stage.veil(float(depth[0])),
    )


def _limbs(
    stage: Stage, person: Person, wears: Outfit, body: Floats, image: tuple[Floats, Floats, Floats]
) -> list[tuple[float, Shape]]:
    pixels, depth, scale = image
    away = float(body[8, 2] + body[12, 2] - body[7, 2] - body[11, 2]) > 0.05
    places, light, lean = _lit_pieces(stage, body)
    layers: list[tuple[float, Shape]] = []
    for index, (limb, size) in enumerate(zip(CAPSULES, radii(person), strict=True)):
        part = "leg" if (limb.a, limb.b) == _HIPS else limb.part
        albedo = _albedo(part, wears, is_crown=limb.b == _CROWN, away=away)
        loose = _CLOTH_RADIUS if limb.part in ("torso", "arm", "leg") else 1.0
        wide = loose * size * scale[[limb.a, limb.b]]
        order = -float(depth[limb.a] + depth[limb.b]) / 2 + 0.05 * (limb.part == "head")
        for piece, (start, stop) in enumerate(pairwise(places)):
            shares = np.array([start, stop])
            line = pixels[limb.a] + shares[:, None] * (pixels[limb.b] - pixels[limb.a])
            thick = wide[0] + shares * (wide[1] - wide[0])
            aside = np.array([_SIDEWAYS * lean[index, piece], 0.0])
            for step, (share, gain) in enumerate(_RINGS):
                a, b = line + aside * ((1 - share) * thick)[:, None]
                outline = capsule_outline(a, b, *(share * thick))
                colour = albedo * gain * light[index, piece]
                layers.append((order + 0.001 * step, (outline, colour)))
    if not away:
        layers.append(_face(wears, body, pixels, radii(person)[-1] * scale[_CROWN], light[-1, -1],
                            -float(depth[_CROWN]) + 0.2))  # fmt: skip
    return layers


def _albedo(part: str, wears: Outfit, *, is_crown: bool, away: bool) -> Floats:
    if part == "head":
        return wears.hair if is_crown or away else wears.skin
    return {"hand": wears.skin, "leg": wears.trousers, "shoe": wears.shoes}.get(part, wears.coat)


def _face(
    wears: Outfit, body: Floats, pixels: Floats, size: Floats, light: Floats, order: float
) -> tuple[float, Shape]:
    """Return the face, on the side to which the toes point, below the hair."""
    aside = float(np.clip((body[8, 0] + body[12, 0] - body[7, 0] - body[11, 0]) / 0.35, -1, 1))
    shift = np.array([0.32 * aside * size[0], 0.30 * size[0]])
    middle = 0.55 * pixels[_HEAD] + 0.45 * pixels[_CROWN]
    outline = capsule_outline(pixels[_HEAD] + shift, middle + shift, 0.72 * size[0], 0.76 * size[1])
    return order, (outline, wears.skin * light)


def _lit_pieces(stage: Stage, body: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the light along the limbs, cut into pieces as a low beam may end halfway up a leg.

    Returns
    -------
    places
        Ends of the pieces as shares of a limb, shape (pieces + 1,).
    light
        Luminance of white cloth, shape (limbs, pieces, 3).
    lean
        From -1 (light from the left) to 1 (from the right), shape (limbs, pieces).
    """
    places = np.linspace(0.0, 1.0, _PIECES + 1)
    middles = (places[1:] + places[:-1]) / 2
    starts = body[[limb.a for limb in CAPSULES]]
    ways = body[[limb.b for limb in CAPSULES]] - starts
    points = (starts[:, None] + middles[None, :, None] * ways[:, None]).reshape(-1, 3)
    shape = (len(CAPSULES), _PIECES)
    light = stage.luminance(points, TO_CAMERA, wrap=0.25).reshape(*shape, 3)
    right = stage.lights.at(points, np.array([1.0, 0.0, 0.0])) @ LUMA
    left = stage.lights.at(points, np.array([-1.0, 0.0, 0.0])) @ LUMA
    lean = (right - left) / np.maximum(right + left, 1e-6)
    return places, light, np.asarray(lean).reshape(shape)


def _shadow(stage: Stage, body: Floats, scale: float) -> None:
    """Draw the dark area below the feet."""
    for ankle in (7, 11):
        foot = body[ankle] * np.array([1.0, 0.0, 1.0])
        pixel, depth = stage.view.project(foot)
        flat = stage.view.camera.mount_m / max(float(depth), 1.0)
        stage.easel.shade(pixel, 0.26 * scale, 0.22 * scale * flat + 0.6, 0.4)


def _bicycle(
    stage: Stage, body: Floats, pixels: Floats, scale: Floats, order: float
) -> list[tuple[float, Shape]]:
    """Return wheels, thin from behind or ahead, the bars of the frame, and a red rear lamp."""
    back, front, saddle, crank, bar = pixels[21:26]
    light = stage.luminance(body[[0]], TO_CAMERA, wrap=0.3)[0]
    layers: list[tuple[float, Shape]] = []
    rim = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1)
    for centre, joint in ((front, 22), (back, 21)):
        radius = WHEEL_M * scale[joint]
        thin = max(0.09 * radius, abs(front[0] - back[0]) * 0.33)
        layers.append((order - 0.5, (centre + rim * np.array([thin, radius]), _BLACK * light)))
    width = 0.018 * scale[0]
    steel = np.array([0.10, 0.13, 0.22]) * light
    for a, b in ((back, saddle), (back, crank), (crank, bar), (saddle, bar), (bar, front)):
        layers.append((order + 0.002, (capsule_outline(a, b, width, width), steel)))
    wide = np.array([0.26 * scale[25], 0.0])
    layers.append((order + 0.003, (capsule_outline(bar - wide, bar + wide, width, width), steel)))
    lamp = saddle + np.array([0.0, 0.10 * scale[0]])
    size = max(0.035 * scale[0], 0.8)
    layers.append((order + 9.0, (lamp + size * rim, np.array([9.0, 0.5, 0.4]))))
    return layers
