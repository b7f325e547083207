"""Second, small sample: three drives past speed signs, and two systems that read them.

The drives are rendered as in `tools.sample.visible`, with one picture per frame. The systems' range
and reading of each sign are given explicitly.
"""

from __future__ import annotations

import json
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.dataset.schema import KMH
from nvcore.settings.params.traffic import context_word
from tools.sample.camera import FPS, N_FRAMES, Floats
from tools.sample.objects import upright
from tools.sample.places import COUNTRY, country_things, town_things
from tools.sample.scene import Car, Keys, Recording, Road, Thing
from tools.sample.systems import THRESHOLD, wandering
from tools.sample.truth import MIN_DEPTH_M, MIN_HEIGHT_PX, MIN_INSIDE
from tools.sample.visible.light import Glow
from tools.sample.visible.render import visible_pictures
from tools.sample.visible.view import View
from tools.sample.writing import TRUTH_FILE, csv_text, write_colour_video

FOLDER: Final = "speed_signs"
SYSTEMS: Final = {"Mono": "mono.csv", "Stereo": "stereo.csv"}
SIZE: Final = (640, 360)
_NEVER: Final = 3.0
"""Reach at which every sign has left the picture."""
_STREET: Final = Road(left=-5.1, right=1.7, pavement=2.6)
_LEAST_SCORE: Final = 0.12
_QUALITY: Final = "33"
"""Quality (crf) of the videos, about 300 kB each."""


@dataclass(frozen=True)
class Sign:
    """Sign, or plate that is not part of the truth, with the systems' results.

    Attributes
    ----------
    thing
        Object to draw.
    reach_m
        Distance from which each system reads it, in the order of `SYSTEMS`.
    reads
        Reading of each system, a number or ``"end"``. None: the correct one.
    """

    thing: Thing
    reach_m: tuple[float, float] = (42.0, 48.0)
    reads: tuple[str, str] | None = None


@dataclass(frozen=True)
class Drive:
    """Recording without people, with its signs."""

    recording: Recording
    signs: tuple[Sign, ...]

    @property
    def view(self) -> View:
        """Return the camera."""
        return View(self.recording.camera, *SIZE, scale=1.0, dx=0.0, dy=-60.0)


def _drive(
    name: str, text: str, kmh: Keys, *signs: Sign, things: tuple[Thing, ...], **more: Any
) -> Drive:
    """Return a drive whose speed is given in seconds and km/h."""
    speed = tuple((time_s, value / KMH) for time_s, value in kmh)
    things = (*things, *(sign.thing for sign in signs))
    return Drive(Recording(name, text, speed, (), things=things, **more), signs)


def _sign(z: float, shows: str) -> Thing:
    return Thing("sign", 3.0, z, 2.9, 0.75, shows=shows)


DRIVES: Final = (
    _drive(
        "into_village",
        "from 80 to 50 km/h, braked too late; Mono reads the second of two signs only",
        ((0, 68), (5, 68), (9, 56), (11, 46), (15, 46)),
        Sign(_sign(38, "80")),
        Sign(_sign(125, "50"), (_NEVER, 48.0)),
        Sign(_sign(150, "50"), (20.0, 48.0)),
        Sign(_sign(300, "50")),
        things=town_things(21, 300.0),
        road=_STREET,
    ),
    _drive(
        "past_school",
        "from 50 to 30 km/h, braked too late; Stereo takes the 30 for 80",
        ((0, 48), (4, 48), (7, 40), (10, 40), (12.5, 28), (15, 28)),
        Sign(_sign(30, "50")),
        Sign(_sign(95, "30"), reads=("30", "80")),
        Sign(_sign(225, "50")),
        things=town_things(22, 260.0),
        road=_STREET,
    ),
    _drive(
        "open_road",
        "from 80 km/h to no limit; Stereo does not read the end, Mono reads the 80 on a van",
        ((0, 62), (3, 62), (8, 86), (15, 86)),
        Sign(_sign(32, "80")),
        Sign(_sign(150, "end"), (36.0, _NEVER)),
        Sign(Thing("plate", 2.9, 252, 1.7, 0.6, shows="80"), (34.0, _NEVER)),
        Sign(_sign(385, "80")),
        things=country_things(23, 480.0),
        road=COUNTRY,
        cars=(Car(3.5, 256.0, height_m=2.7, length_m=7.0, width_m=2.2),),
        context=1.0,
    ),
)


def tables() -> dict[str, pd.DataFrame]:
    """Return truth and detections, one table per file name."""
    parts: dict[str, list[pd.DataFrame]] = {TRUTH_FILE: []}
    parts |= {path: [] for path in SYSTEMS.values()}
    for drive in DRIVES:
        name, way = drive.recording.name, drive.recording.way()
        for track, sign in enumerate(drive.signs, start=1):
            thing, ahead_m = sign.thing, sign.thing.z - way
            edges = _edges(thing, drive.view, ahead_m)
            frames = _annotated(edges, ahead_m)
            if thing.kind == "sign":
                table = _boxes(name, frames, edges, ahead_m, thing.shows)
                parts[TRUTH_FILE].append(table.assign(track=track))
            for place, path in enumerate(SYSTEMS.values()):
                generator = np.random.default_rng([37, zlib.crc32(name.encode()), track, place])
                scores, boxes, metres = _detected(generator, sign.reach_m[place], edges, ahead_m)
                rows = frames[scores[frames] >= _LEAST_SCORE]
                shows = thing.shows if sign.reads is None else sign.reads[place]
                table = _boxes(name, rows, boxes, metres, shows)
                parts[path].append(table.assign(score=scores[rows]))
    return {
        path: pd.concat(part).sort_values(["recording", "frame"], kind="stable", ignore_index=True)
        for path, part in parts.items()
    }


def _edges(thing: Thing, view: View, ahead_m: Floats) -> Floats:
    """Return left, top, right, bottom of a sign at every frame, pixels, shape (N_FRAMES, 4)."""
    half, low = thing.width_m / 2, thing.size_m - thing.width_m
    plate = upright(thing.x - half, thing.x + half, low, thing.size_m, 0.0)
    corners = plate + np.maximum(ahead_m, 0.6)[:, None, None] * np.array([0.0, 0.0, 1.0])
    pixels, _ = view.project(corners)
    return np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=1)


def _annotated(edges: Floats, ahead_m: Floats) -> NDArray[np.int64]:
    size, cut = edges[:, 2:] - edges[:, :2], np.clip(edges, 0.0, [*SIZE, *SIZE])
    inside = np.prod(cut[:, 2:] - cut[:, :2], axis=1) / np.prod(size, axis=1)
    is_near = (ahead_m > MIN_DEPTH_M) & (size[:, 1] >= MIN_HEIGHT_PX)
    return np.flatnonzero(is_near & (inside >= MIN_INSIDE))


def _boxes(
    name: str, frames: NDArray[np.int64], edges: Floats, ahead_m: Floats, shows: str
) -> pd.DataFrame:
    """Return rows of a file: boxes clipped to the picture, in quarters of a pixel."""
    x0, y0, x1, y1 = (np.round(4 * np.clip(edges[frames], 0.0, [*SIZE, *SIZE])) / 4).T
    kind = "end of speed limit" if shows == "end" else f"speed limit {shows}"
    table = pd.DataFrame({"recording": name, "frame": frames, "x": x0, "y": y0})
    return table.assign(w=x1 - x0, h=y1 - y0, distance_m=ahead_m[frames]).assign(**{"class": kind})


def _detected(
    generator: np.random.Generator, reach_m: float, edges: Floats, ahead_m: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return scores, boxes and distances of a system at every frame."""
    ease = np.log(reach_m / np.maximum(ahead_m, 1.0))
    ease += 0.08 * wandering(generator, hold_s=0.5)
    drift = np.stack([wandering(generator, hold_s=0.3) for _ in range(4)], axis=1)
    boxes = edges + drift * (0.15 + 0.03 * np.tile(edges[:, 2:] - edges[:, :2], 2))
    metres = ahead_m * np.exp(0.03 * wandering(generator, hold_s=0.6))
    return 0.98 / (1 + np.exp(-6.0 * ease)), boxes, metres


def session_text() -> str:
    """Return the text of the session file."""
    parts = [
        f'[[recording]]\nname = "{name}"\nwidth = {SIZE[0]}\nheight = {SIZE[1]}\n'
        f'fps = {FPS}\nframes = "0:{N_FRAMES - 1}"\nhorizon = {drive.view.horizon:.1f}\n'
        f'context = "{context_word(drive.recording.context)}"\nspeed = "{name}_speed.csv"\n'
        f'pictures = "{name}.mp4"\n'
        for drive in DRIVES
        for name in (drive.recording.name,)
    ]
    source = {
        path: f'path = "{path}"\nformat = "csv"\nframe_base = 0\n'
        f"classes = {json.dumps(sorted(set(table['class'])))}\n"
        for path, table in tables().items()
    }
    parts.append(f"[truth]\n{source[TRUTH_FILE]}")
    parts += [
        f'[[system]]\nname = "{name}"\n{source[path]}threshold = {THRESHOLD}\n'
        for name, path in SYSTEMS.items()
    ]
    parts.append('[compare]\nobjects = "speed sign"\n')
    # docs/objects.md: the preset of speed signs
    parts.append("[parameters]\ncoverage = 0.2\nedge_weight = 1.0\nmidpoint = 15.0\nspread = 3.0\n")
    return "\n".join(parts)


def files() -> dict[str, str]:
    """Return the texts of all files except the videos, by name."""
    time_s = np.round(np.arange(0, N_FRAMES / FPS + 0.01, 0.1), 1)
    speeds: dict[str, pd.DataFrame] = {}
    for drive in DRIVES:
        kmh = KMH * np.interp(time_s, *np.array(drive.recording.speed).T)
        table = pd.DataFrame({"time_s": time_s, "speed_kmh": np.round(kmh, 1)})
        speeds[f"{drive.recording.name}_speed.csv"] = table
    texts = {path: csv_text(table) for path, table in (tables() | speeds).items()}
    return {**texts, "session.toml": session_text()}


def write_speed_signs(folder: Path) -> None:
    """Write the sample into the subfolder ``speed_signs`` of a folder."""
    own = folder / FOLDER
    own.mkdir(exist_ok=True)
    for path, text in files().items():
        (own / path).write_bytes(text.encode())
    for drive in DRIVES:
        glow = Glow(sky_lux=60.0, warmth=0.2)
        frames = visible_pictures(drive.recording, glow, drive.view, noise=0.2)
        video = own / f"{drive.recording.name}.mp4"
        write_colour_video(video, frames, SIZE, quality=_QUALITY)
