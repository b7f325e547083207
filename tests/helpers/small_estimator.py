"""A session with pictures of visible light, and an estimator that looks at contrast alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from picture_files import write_picture

from nvcore.driver.estimators import Estimator, Origin, Quality, Regression, write_estimator
from nvcore.driver.estimators.model import SvrSettings
from nvcore.driver.features import FEATURE_KEYS

N_FRAMES = 60
FPS = 10
DARK_FROM_S = 4.0
"""The light meter falls at this time."""
PLACES = {1: 60, 2: 180}
"""Left edge of each pedestrian, by track; 20 x 60 px. The first is bright, the other is not."""


def write_model(path: Path, late: float = 1.0) -> Path:
    """An estimator: soon after a change 0.2 of the contrast over 100, from 4.5 s on `late` of it.

    With `late` = 1 who is 80 brighter than his surround is seen by 0.8 of all adapted drivers.
    """
    regressions = tuple(_by_contrast(share) for share in (0.2, late, late))
    qualities = (Quality(51, 0.01, 0.5, 0.1),) * 3
    origin = Origin(51, 4, 306, "no", 200.0, 0.5, 0.5, 0, "ab")
    estimator = Estimator("small", np.array([0.5, 4.5]), regressions, qualities, origin)
    write_estimator(estimator, path)
    return path


def _by_contrast(share: float) -> Regression:
    return Regression(
        columns=np.array([FEATURE_KEYS.index("luminance_contrast")]),
        centre=np.zeros(1),
        scale=np.full(1, 100.0),
        low=np.zeros(1),
        high=np.full(1, 200.0),
        vectors=np.ones((1, 1)),
        weights=np.array([share]),
        offset=0.0,
        settings=SvrSettings("linear", 1.0, 0.1, 1.0),
    )


def write_session(folder: Path) -> Path:
    """X detects both pedestrians, Y the bright one; by the light meter it is dark from 4 s on."""
    picture = np.full((240, 320, 3), 40, np.uint8)
    picture[80:140, PLACES[1] : PLACES[1] + 20] = 120
    picture[80:140, PLACES[2] : PLACES[2] + 20] = 50
    picture[0, 0] = (90, 40, 40)  # in colour
    (folder / "visible").mkdir()
    for frame in range(N_FRAMES):
        write_picture(folder / "visible" / f"{frame:03d}.png", picture)
    head = "recording,frame,x,y,w,h"
    for name, tracks, last in (
        ("truth", PLACES, "track"),
        ("x", PLACES, "score"),
        ("y", [1], "score"),
    ):
        lines = [
            f"drive,{frame},{PLACES[track]},80,20,60,{track if last == 'track' else 0.9}"
            for frame in range(N_FRAMES)
            for track in tracks
        ]
        (folder / f"{name}.csv").write_text("\n".join([f"{head},{last}", *lines]) + "\n")
    times = np.arange(-4, N_FRAMES / FPS, 0.1)
    levels = np.where(times < DARK_FROM_S, 1000, 10)
    readings = [f"{time:.1f},{lux}" for time, lux in zip(times, levels, strict=True)]
    (folder / "lux.csv").write_text("\n".join(["time_s,lux", *readings]) + "\n")
    session = folder / "session.toml"
    session.write_text(
        f'[defaults]\nsize = "320x240"\nfps = {FPS}\nframes = "0:{N_FRAMES - 1}"\n'
        '[[recording]]\nname = "drive"\nvisible = "visible"\nlight = "lux.csv"\n'
        '[truth]\npath = "truth.csv"\n'
        '[[system]]\nname = "one"\npath = "x.csv"\n[[system]]\nname = "two"\npath = "y.csv"\n'
    )
    return session
