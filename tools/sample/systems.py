"""Simulated systems: their detections, scores, and false alarms.

All are pure range models with memory. A person is detected up to `reach` metres. The score is a
logistic function of log(reach / distance) plus a slowly wandering disturbance, so that losses last
for some frames instead of flickering at random. All report distances, whose error is a share of the
distance, wanders slowly, and grows with it.

- FIR, far infrared: sees warmth. Its reach is long, but short for cold clothes, crouching bodies
and
  on warm nights. Hot objects cause false alarms. Distance comes from the row of the feet: coarse,
  especially far away.
- NIR, near infrared: sees what its lamp illuminates. Its reach is shorter, even more so for dark
  clothes and off to the side, and it is blind near dazzling headlamps. Reflecting signs and posts
  cause false alarms. Distance comes from the flight time of its lamp's pulses: fine.
- NIR 2, the next version of NIR: the same camera, with a lamp that reaches farther in a narrower
  beam, less blind near headlamps, more careful with signs. So it fixes misses far ahead and in
  glare, and newly misses people off to the side.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from tools.sample.body import keyed
from tools.sample.camera import FPS, HEIGHT, N_FRAMES, WIDTH, Camera, Floats, frame_times
from tools.sample.scene import Recording, Thing
from tools.sample.truth import Sighting, clipped

SEED: Final = 110360
THRESHOLD: Final = 0.5
FIR_REACH_M: Final = 72.0


@dataclass(frozen=True)
class Lamp:
    """Lamp and behaviour of a version of NIR: reach, half beam width, dazzle, care with signs."""

    reach_m: float
    beam_m: float
    dazzle: float
    care: float = 0.0


LAMPS: Final = {"NIR": Lamp(46.0, 15, 1.7), "NIR 2": Lamp(60.0, 10, 0.8, care=0.3)}
RANGING: Final = {"FIR": (0.03, 0.0015), **dict.fromkeys(LAMPS, (0.015, 0.0005))}
"""Standard deviation of a system's distances as a share: at 0 m, and increase per metre."""
_LOWEST_SCORE: Final = 0.12
_HIGHEST_SCORE: Final = 0.985


def wandering(generator: np.random.Generator, *, hold_s: float, n: int = N_FRAMES) -> Floats:
    """Return AR(1) noise of unit variance that decorrelates in about `hold_s` seconds."""
    keep = float(np.exp(-1 / (FPS * hold_s)))
    noise = generator.standard_normal(n)
    noise[1:] *= np.sqrt(1 - keep**2)
    return np.asarray(lfilter([1.0], [1.0, -keep], noise))


def detections(recording: Recording, visible: list[Sighting], *, system: str) -> pd.DataFrame:
    """Return the detections of one system in one recording, with all scores.

    Parameters
    ----------
    system
        ``"FIR"`` or one of `LAMPS`.
    """
    parts = [
        _person(
            _generator(recording, system, 100 + track),
            sighting,
            _log_reach(recording, sighting, system),
            system,
        )
        for track, sighting in enumerate(visible)
    ]
    things = _tempting(recording, system)
    parts += [
        _false_alarm(_generator(recording, system, 200 + number), thing, recording, system)
        for number, thing in enumerate(things)
    ]
    parts.append(_noise(_generator(recording, system, 300), recording.camera, system))
    table = pd.concat(parts, ignore_index=True)
    table.insert(0, "recording", recording.name)
    return table.sort_values(["frame", "score"], ascending=[True, False], ignore_index=True)


def _generator(recording: Recording, system: str, number: int) -> np.random.Generator:
    """Return the random numbers of one object, independent of those of all others.

    The versions of NIR share them because they are one camera.
    """
    return np.random.default_rng(
        [SEED, zlib.crc32(recording.name.encode()), ord(system[0]), number]
    )


def _log_reach(recording: Recording, sighting: Sighting, system: str) -> Floats:
    person = sighting.person
    reach = np.full(N_FRAMES, np.log(person.height_m / 1.75))
    crouch, bend = keyed(person.crouch), keyed(person.bend)
    if system == "FIR":
        warm = recording.climate.contrast * (0.22 + 0.78 * person.warmth)
        reach += np.log(FIR_REACH_M * warm * (1 - 0.62 * crouch) * (1 - 0.45 * bend))
    else:
        lamp = LAMPS[system]
        lit = np.exp(-((sighting.lateral_m / lamp.beam_m) ** 2))
        lit *= (person.reflectance / 0.5) ** 0.45
        reach += np.log(lamp.reach_m * lit * (1 - 0.4 * crouch) * (1 - 0.2 * bend))
        reach -= lamp.dazzle * _glare(recording, sighting)
    return reach - 2.3 * sighting.hidden - 1.2 * (1 - sighting.inside)


def _glare(recording: Recording, sighting: Sighting) -> Floats:
    """Return the dazzle by headlamps at a person's place in the image, 0 to 1."""
    way, columns = recording.way(), (sighting.edges[:, 0] + sighting.edges[:, 2]) / 2
    dazzle = np.zeros(N_FRAMES)
    for car in recording.cars:
        if not car.lights:
            continue
        ahead = car.z + car.speed * frame_times() - way - car.length_m / 2
        lamp = np.stack([np.full_like(ahead, car.x), np.full_like(ahead, 0.7), ahead], axis=1)
        pixels, depth = recording.camera.project(lamp)
        strength = np.exp(-((np.log(np.maximum(depth, 1.0) / 32) / 0.75) ** 2)) * (depth > 4)
        spread = 125 * np.sqrt(32 / np.maximum(depth, 8.0))
        dazzle = np.maximum(dazzle, strength * np.exp(-(((pixels[:, 0] - columns) / spread) ** 2)))
    return dazzle


def ranged(generator: np.random.Generator, distance_m: Floats, system: str) -> Floats:
    """Return distances in metres as a system reports them at every frame, shape (N_FRAMES,)."""
    at_zero, per_metre = RANGING[system]
    spread = at_zero + per_metre * distance_m
    # most of the error is geometry that changes slowly, the rest varies by picture
    slow, quick = wandering(generator, hold_s=0.6), generator.standard_normal(N_FRAMES)
    return np.asarray(distance_m * np.exp(spread * (0.9 * slow + np.sqrt(1 - 0.9**2) * quick)))


def _person(
    generator: np.random.Generator, sighting: Sighting, log_reach: Floats, system: str
) -> pd.DataFrame:
    ease = log_reach - np.log(np.maximum(sighting.distance_m, 1.0))
    dips = np.maximum(0.0, wandering(generator, hold_s=0.35) - 1.7)
    ease = ease + 0.12 * wandering(generator, hold_s=0.8) - 1.1 * dips
    ease = ease + 0.02 * generator.standard_normal(N_FRAMES)
    scores = _HIGHEST_SCORE / (1 + np.exp(-5.0 * ease))
    frames = np.flatnonzero(sighting.annotated & (scores >= _LOWEST_SCORE))
    # Localisation wanders with the pose and the pixels. Small and doubtful boxes are looser.
    size = sighting.edges[:, 2:] - sighting.edges[:, :2]
    loose = (0.55 + 0.9 * (1 - scores))[:, None]
    drift = np.stack([wandering(generator, hold_s=0.4) for _ in range(4)], axis=1)
    middle = (sighting.edges[:, 2:] + sighting.edges[:, :2]) / 2
    middle = middle + loose * drift[:, :2] * (0.2 + np.array([0.07, 0.035]) * size)
    # Detectors respond with boxes of a typical shape, independent of the swing of the legs.
    usual = np.array([0.36, 0.0]) * size[:, 1:] + np.array([0.0, 1.0]) * size
    size = 0.6 * size + 0.4 * usual
    size = size * np.exp(loose * drift[:, 2:] * np.array([0.10, 0.06]))
    edges = np.concatenate([middle - size / 2, middle + size / 2], axis=1)
    metres = ranged(generator, sighting.distance_m, system)
    return _table(frames, edges[frames], scores[frames], metres[frames])


def _tempting(recording: Recording, system: str) -> list[Thing]:
    """Return the objects that a system may take for a person, as upright things."""
    is_warmth = system == "FIR"
    kinds = ("cabinet", "lamp", "bush", "house") if is_warmth else ("sign", "post", "pole")
    things = [t for t in recording.things if t.tempt is not None and t.kind in kinds]
    if is_warmth:
        things += [
            Thing("engine", car.x + 0.35, car.z - car.length_m / 2, 1.15, tempt=car.tempt)
            for car in recording.cars
            if car.tempt is not None and car.speed == 0.0
        ]
    return things


def _false_alarm(
    generator: np.random.Generator, thing: Thing, recording: Recording, system: str
) -> pd.DataFrame:
    ahead = thing.z - recording.way()
    size_m = min(thing.size_m, 2.1)
    foot = np.stack([np.full_like(ahead, thing.x), np.zeros_like(ahead), ahead], axis=1)
    head = foot + np.array([0.0, size_m, 0.0])
    (low, depth), (high, _) = recording.camera.project(foot), recording.camera.project(head)
    height = low[:, 1] - high[:, 1]
    width = 0.42 * height * np.exp(0.06 * wandering(generator, hold_s=0.4))
    middle = low[:, 0] + 0.03 * height * wandering(generator, hold_s=0.4)
    shift = 0.03 * height * wandering(generator, hold_s=0.4)
    edges = np.stack(
        [middle - width / 2, high[:, 1] + shift, middle + width / 2, low[:, 1] + shift], axis=1
    )
    # It looks like a person only while it has about the size of one.
    alike = -((np.log(np.maximum(height, 1.0) / 52) / 0.55) ** 2)
    tempt = thing.tempt if thing.tempt is not None else -9.0
    tempt -= LAMPS[system].care if system in LAMPS else 0.0
    mood = gaussian_filter1d(wandering(generator, hold_s=0.6), 3.0)
    scores = 0.93 / (1 + np.exp(-2.2 * (tempt + alike + 0.7 * mood)))
    inside = (edges[:, 0] > 2) & (edges[:, 2] < WIDTH - 2) & (edges[:, 3] < HEIGHT) & (depth > 2)
    frames = np.flatnonzero(inside & (scores >= _LOWEST_SCORE) & (height >= 12))
    metres = ranged(generator, np.hypot(thing.x, ahead), system)
    return _table(frames, edges[frames], scores[frames], metres[frames])


def _noise(generator: np.random.Generator, camera: Camera, system: str) -> pd.DataFrame:
    """Return faint detections of nothing, two to five frames long, all below the threshold."""
    n = 34
    starts = generator.integers(0, N_FRAMES - 5, n)
    lengths = generator.integers(2, 6, n)
    frames = np.repeat(starts, lengths) + np.concatenate([np.arange(k) for k in lengths])
    depth = np.exp(generator.uniform(np.log(12), np.log(75), n))
    lateral = generator.uniform(-0.26, 0.26, n) * depth
    foot, _ = camera.project(np.stack([lateral, np.zeros(n), depth], axis=1))
    height = camera.focal_px * generator.uniform(0.9, 1.9, n) / depth
    width = height * generator.uniform(0.3, 0.6, n)
    edges = np.stack(
        [foot[:, 0] - width / 2, foot[:, 1] - height, foot[:, 0] + width / 2, foot[:, 1]], axis=1
    )
    scores = _LOWEST_SCORE + 0.3 * generator.beta(1.2, 3.0, n)
    edges, scores = np.repeat(edges, lengths, axis=0), np.repeat(scores, lengths)
    edges = edges + generator.normal(0, 0.6, edges.shape)
    scores = scores + generator.uniform(-0.03, 0.03, len(scores))
    at_zero, per_metre = RANGING[system]
    away = np.hypot(lateral, depth)
    metres = away * np.exp((at_zero + per_metre * away) * generator.standard_normal(n))
    return _table(frames, edges, scores, np.repeat(metres, lengths))


def _table(
    frames: np.typing.NDArray[np.int64], edges: Floats, scores: Floats, metres: Floats
) -> pd.DataFrame:
    edges = clipped(edges)
    table = pd.DataFrame(
        {
            "frame": frames,
            "x": edges[:, 0],
            "y": edges[:, 1],
            "w": edges[:, 2] - edges[:, 0],
            "h": edges[:, 3] - edges[:, 1],
            "score": np.round(scores, 3),
            "distance_m": np.round(metres, 2),
        }
    )
    return table[(table["w"] >= 2) & (table["h"] >= 4)]
