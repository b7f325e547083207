"""Walking, standing, crouching, bending or cycling body: joints in space over time.

The body is a set of tapered capsules between joints. Both the boxes of the truth and the pictures
are made from them.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from tools.sample.camera import FPS, Floats, frame_times
from tools.sample.scene import Keys, Person

JOINTS: Final = (
    *("pelvis", "chest", "neck", "head", "crown"),
    *("hip_l", "knee_l", "ankle_l", "toe_l"),
    *("hip_r", "knee_r", "ankle_r", "toe_r"),
    *("shoulder_l", "elbow_l", "wrist_l", "hand_l"),
    *("shoulder_r", "elbow_r", "wrist_r", "hand_r"),
    *("wheel_back", "wheel_front", "saddle", "crank", "bar"),
)
"""Names of the joints, in the order of the joint axis. The last five belong to a bicycle."""

_INDEX: Final = {name: index for index, name in enumerate(JOINTS)}
N_BODY: Final = _INDEX["wheel_back"]
WHEEL_M: Final = 0.34


class Capsule(NamedTuple):
    """Limb from joint `a` to joint `b`, with radii as shares of the body height."""

    a: int
    b: int
    radius_a: float
    radius_b: float
    part: str


def _limb(a: str, b: str, radius_a: float, radius_b: float, part: str) -> Capsule:
    return Capsule(_INDEX[a], _INDEX[b], radius_a, radius_b, part)


CAPSULES: Final = (
    _limb("hip_l", "knee_l", 0.052, 0.036, "leg"),
    _limb("hip_r", "knee_r", 0.052, 0.036, "leg"),
    _limb("knee_l", "ankle_l", 0.036, 0.023, "leg"),
    _limb("knee_r", "ankle_r", 0.036, 0.023, "leg"),
    _limb("ankle_l", "toe_l", 0.024, 0.018, "shoe"),
    _limb("ankle_r", "toe_r", 0.024, 0.018, "shoe"),
    _limb("pelvis", "chest", 0.084, 0.090, "torso"),
    _limb("chest", "neck", 0.086, 0.040, "torso"),
    _limb("hip_l", "hip_r", 0.054, 0.054, "torso"),
    _limb("shoulder_l", "shoulder_r", 0.042, 0.042, "torso"),
    _limb("shoulder_l", "elbow_l", 0.034, 0.027, "arm"),
    _limb("shoulder_r", "elbow_r", 0.034, 0.027, "arm"),
    _limb("elbow_l", "wrist_l", 0.026, 0.019, "arm"),
    _limb("elbow_r", "wrist_r", 0.026, 0.019, "arm"),
    _limb("wrist_l", "hand_l", 0.019, 0.017, "hand"),
    _limb("wrist_r", "hand_r", 0.019, 0.017, "hand"),
    _limb("neck", "head", 0.034, 0.038, "head"),
    _limb("head", "crown", 0.046, 0.050, "head"),
)
"""All limbs of a person."""


def keyed(keys: Keys) -> Floats:
    """Interpolate keyed values at every frame, smoothed so that no motion starts abruptly."""
    knots = np.asarray(keys, dtype=np.float64)
    values = np.interp(frame_times(), knots[:, 0], knots[:, 1])
    return np.asarray(gaussian_filter1d(values, 2.0, mode="nearest"))


def positions(person: Person) -> tuple[Floats, Floats, Floats]:
    """Return the positions and directions of a person over time.

    Returns
    -------
    place
        Metres x and z in the world, shape (frames, 2).
    ahead
        Unit vector x, z of the walking or looking direction, shape (frames, 2).
    speed
        Metres per second, shape (frames,).
    """
    knots = np.asarray(person.path, dtype=np.float64)
    times = frame_times()
    place = np.stack([np.interp(times, knots[:, 0], knots[:, axis]) for axis in (1, 2)], axis=1)
    # A body does not turn on the spot. "mirror" about the end keeps its speed there.
    place = _soften(place, 4.0)
    velocity = np.gradient(place, 1 / FPS, axis=0)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    facing = np.radians(person.facing_deg)
    ahead = velocity + 0.12 * np.array([np.sin(facing), np.cos(facing)])
    ahead /= np.hypot(ahead[:, 0], ahead[:, 1])[:, None]
    return place, ahead, speed


def _soften(place: Floats, sigma: float) -> Floats:
    """Smooth along time with a Gaussian, with straight continuation at both ends."""
    pad = int(4 * sigma)
    before = place[:1] + (place[1:2] - place[:1]) * np.arange(-pad, 0)[:, None]
    after = place[-1:] + (place[-1:] - place[-2:-1]) * np.arange(1, pad + 1)[:, None]
    padded = np.concatenate([before, place, after])
    return np.asarray(gaussian_filter1d(padded, sigma, axis=0)[pad:-pad])


def joints(person: Person) -> Floats:
    """Return the joints of a person in the world, metres, shape (frames, joints, 3).

    The five joints of the bicycle are NaN for a pedestrian.
    """
    place, ahead, speed = positions(person)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(place, axis=0).T))])
    local = _cycling(way) if person.cyclist else _walking(person, way, speed)
    local *= person.height_m
    lowest = np.nanmin(local[:, :N_BODY, 2], axis=1) - 0.018 * person.height_m
    if person.cyclist:
        local = _on_bicycle(local)
    else:
        local[:, :, 2] -= lowest[:, None]
    aside = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
    ground = (
        place[:, None, :]
        + local[:, :, 0, None] * ahead[:, None, :]
        + local[:, :, 1, None] * aside[:, None, :]
    )
    return np.stack([ground[..., 0], local[..., 2], ground[..., 1]], axis=-1)


def radii(person: Person) -> NDArray[np.float64]:
    """Return the radius at both ends of every limb, m, (limbs, 2). Children's heads are larger."""
    size = np.array([[limb.radius_a, limb.radius_b] for limb in CAPSULES]) * person.height_m
    heads = np.array([limb.part == "head" for limb in CAPSULES])
    size[heads] *= (1.75 / person.height_m) ** 0.55
    return size


def _walking(person: Person, way: Floats, speed: Floats) -> Floats:
    """Return joints in body heights: forward, right, up, relative to an arbitrary height."""
    crouch, bend = keyed(person.crouch), keyed(person.bend)
    effort = np.clip(gaussian_filter1d(speed, 3.0, mode="nearest") / 1.2, 0.0, 1.15)
    phase = 2 * np.pi * way / (0.82 * person.height_m)
    lean = np.radians(3 * effort + 32 * crouch + 78 * bend)
    body = _trunk(lean, nod=0.55 * lean)
    for side, shift, sign in (("l", 0.0, -1.0), ("r", np.pi, 1.0)):
        swing = phase + shift
        calm = (1 - crouch) * effort
        thigh = np.radians(25 * calm * np.sin(swing) + crouch * (100 + 8 * sign) - 12 * bend)
        knee = np.radians(
            4 + calm * (7 + 35 * np.maximum(0.0, np.cos(swing + 0.35))) + crouch * 136
        )
        _leg(body, side, sign, thigh, knee)
        arm = np.radians(
            -22 * calm * np.sin(swing) + 38 * crouch + 70 * bend * (0.6 + 0.25 * sign) + 4
        )
        elbow = np.radians(12 + 12 * effort * (1 + np.sin(swing + np.pi)) + 35 * crouch)
        _arm(body, side, sign, arm, elbow)
    return body


def _cycling(way: Floats) -> Floats:
    """Return the joints of a rider relative to the pelvis."""
    body = _trunk(np.full(len(way), np.radians(34.0)), nod=np.full(len(way), np.radians(8.0)))
    for side, shift, sign in (("l", 0.0, -1.0), ("r", np.pi, 1.0)):
        turn = 2 * np.pi * way / 4.6 + shift
        _leg(
            body, side, sign, np.radians(58 + 24 * np.sin(turn)), np.radians(72 + 26 * np.cos(turn))
        )
        reach = np.full(len(way), np.radians(58.0))
        _arm(body, side, sign, reach, np.full(len(way), np.radians(16.0)))
    return body


def _on_bicycle(local: Floats) -> Floats:
    """Lift the rider onto the saddle, and add the bicycle below."""
    rider = local.copy()
    rider[:, :, 2] += 0.95 - rider[:, :1, 2]
    for name, forward, up in (
        ("wheel_back", -0.38, WHEEL_M),
        ("wheel_front", 0.68, WHEEL_M),
        ("saddle", -0.08, 0.88),
        ("crank", 0.12, 0.30),
        ("bar", 0.50, 1.0),
    ):
        rider[:, _INDEX[name]] = (forward, 0.0, up)
    return rider


def _trunk(lean: Floats, nod: Floats) -> Floats:
    """Return spine, neck and head, with all limbs NaN."""
    body = np.full((len(lean), len(JOINTS), 3), np.nan)
    spine = np.stack([np.sin(lean), np.zeros_like(lean), np.cos(lean)], axis=1)
    gaze = np.stack([np.sin(nod), np.zeros_like(nod), np.cos(nod)], axis=1)
    body[:, _INDEX["pelvis"]] = 0.0
    body[:, _INDEX["chest"]] = 0.215 * spine
    body[:, _INDEX["neck"]] = 0.310 * spine
    body[:, _INDEX["head"]] = body[:, _INDEX["neck"]] + 0.058 * gaze
    body[:, _INDEX["crown"]] = body[:, _INDEX["neck"]] + 0.105 * gaze
    return body


def _leg(body: Floats, side: str, sign: float, thigh: Floats, knee: Floats) -> None:
    hip = body[:, _INDEX["pelvis"]] + np.array([0.0, 0.048 * sign, -0.01])
    shank = thigh - knee
    body[:, _INDEX[f"hip_{side}"]] = hip
    body[:, _INDEX[f"knee_{side}"]] = hip + 0.245 * _swing(thigh)
    ankle = body[:, _INDEX[f"knee_{side}"]] + 0.245 * _swing(shank)
    body[:, _INDEX[f"ankle_{side}"]] = ankle
    body[:, _INDEX[f"toe_{side}"]] = ankle + 0.10 * _swing(0.55 * shank + np.radians(82.0))


def _arm(body: Floats, side: str, sign: float, arm: Floats, elbow: Floats) -> None:
    shoulder = body[:, _INDEX["neck"]] + np.array([0.0, 0.098 * sign, -0.032])
    wide = np.array([0.0, 0.026 * sign, 0.0])
    body[:, _INDEX[f"shoulder_{side}"]] = shoulder
    body[:, _INDEX[f"elbow_{side}"]] = shoulder + 0.172 * _swing(arm) + wide
    wrist = body[:, _INDEX[f"elbow_{side}"]] + 0.145 * _swing(arm + elbow)
    body[:, _INDEX[f"wrist_{side}"]] = wrist
    body[:, _INDEX[f"hand_{side}"]] = wrist + 0.055 * _swing(arm + elbow)


def _swing(angle: Floats) -> Floats:
    """Return the unit vector that hangs down at angle 0 and points forward at 90 degrees."""
    return np.stack([np.sin(angle), np.zeros_like(angle), -np.cos(angle)], axis=1)
