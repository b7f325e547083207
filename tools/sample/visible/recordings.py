"""Recordings with visible-light pictures, their light, and the readings of a light sensor.

Two of them begin on a stretch of road under floodlights, as at a building site at night, and leave
it. This is the change from bright to dark after which a driver's eyes have to adapt.
"""

from __future__ import annotations

import zlib
from typing import Final

import numpy as np
import pandas as pd

from tools.sample.camera import FPS, N_FRAMES
from tools.sample.scene import Recording
from tools.sample.visible.light import Glow, lights_at
from tools.sample.visible.view import visible_map

GLOWS: Final[dict[str, Glow]] = {
    "urban_sidewalk": Glow(sky_lux=3.0, flood_lux=1000.0, flood_end_m=40.0),
    "rural_child": Glow(sky_lux=3.0, lamp_cd=0.0, flood_lux=1000.0, flood_end_m=70.0, warmth=0.8),
    "oncoming_glare": Glow(sky_lux=2.0, warmth=0.3),
}
"""Light of the recordings with visible pictures, by name."""

_SENSOR_NOISE: Final = 0.012
_SENSOR_EVERY: Final = 2


def light_text(recording: Recording) -> str:
    """Return a recording's light sensor file as CSV."""
    table = lux_table(recording, GLOWS[recording.name])
    return str(table.to_csv(index=False, lineterminator="\n"))


def lux_table(recording: Recording, glow: Glow) -> pd.DataFrame:
    """Return readings of a light sensor behind the windscreen: time_s and lux, 10 per second."""
    frames = np.arange(0, N_FRAMES, _SENSOR_EVERY)
    lux = np.array([lights_at(recording, glow, int(frame)).driver_lux() for frame in frames])
    generator = np.random.default_rng([31, zlib.crc32(recording.name.encode())])
    lux *= 1 + _SENSOR_NOISE * generator.standard_normal(len(lux))
    return pd.DataFrame({"time_s": np.round(frames / FPS, 2), "lux": np.round(lux, 1)})


def session_keys(recording: Recording) -> str:
    """Return the lines of the session file that name the visible pictures and the light sensor."""
    if recording.name not in GLOWS:
        return ""
    numbers = ", ".join(f"{value:g}" for value in visible_map())
    return (
        f'visible = "{visible_file(recording)}"\n'
        f"visible_map = [{numbers}]\n"
        f'light = "{light_file(recording)}"\n'
    )


def visible_file(recording: Recording) -> str:
    """Return the name of the video."""
    return f"{recording.name}_visible.mp4"


def light_file(recording: Recording) -> str:
    """Return the name of the light sensor's file."""
    return f"{recording.name}_light.csv"
