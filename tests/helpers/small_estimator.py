"""A session with pictures of visible light, and an estimator that looks at contrast alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from driver_estimators import CONTRAST, origin, regression
from picture_files import write_picture

from nvcore.subjects.driver.estimators import Estimator, Quality, write_estimator

N_FRAMES = 60
FPS = 10
DARK_FROM_S = 4.0
"""The light meter falls at this time."""
PLACES = {1: 60, 2: 180}
"""Left edge of each pedestrian, by track. The first is bright, the other is not."""
WIDTH, HEIGHT = 320, 240
FIGURE = (20, 60)
"""Width and height of a pedestrian, px."""
BRIGHT, DIM = 120, 50


def write_model(
    path: Path, late: float = 1.0, simulated: str = "no", soon_high: float = 200.0
) -> Path:
    """An estimator: soon after a change 0.2 of the contrast over 100, from 4.5 s on `late` of it.

    With `late` = 1 a pedestrian 80 brighter than the surround is seen by 0.8 of adapted drivers.
    That of soon after a change was trained on contrasts of up to `soon_high`, the others of 200.
    """
    parts = ((0.2, soon_high), (late, 200.0), (late, 200.0))
    regressions = tuple(regression(CONTRAST, share=share, high=high) for share, high in parts)
    qualities = (Quality(51, 0.01, 0.5, 0.1),) * 3
    estimator = Estimator("small", np.array([0.5, 4.5]), regressions, qualities, origin(simulated))
    write_estimator(estimator, path)
    return path


def scene(*figures: tuple[int, int, int]) -> np.ndarray:
    """A picture of a dark road with pedestrians: left and upper edge, grey level."""
    picture = np.full((HEIGHT, WIDTH, 3), 40, np.uint8)
    for x, y, level in figures:
        picture[y : y + FIGURE[1], x : x + FIGURE[0]] = level
    picture[0, 0] = (90, 40, 40)  # in colour
    return picture


def write_session(folder: Path, stated: float | None = None, first: int = 0) -> Path:
    """X detects both pedestrians, Y the bright one; by the light meter it is dark from 4 s on.

    Frames are numbered from `first` on; seconds are from its beginning. The truth says of both that
    the share `stated` of all drivers sees them; None: nothing.
    """
    picture = scene((PLACES[1], 80, BRIGHT), (PLACES[2], 80, DIM))
    (folder / "visible").mkdir()
    for frame in range(N_FRAMES):
        write_picture(folder / "visible" / f"{frame:03d}.png", picture)
    more = ("", "") if stated is None else (",detectability", f",{stated}")
    for name, tracks, (last, values) in (
        ("truth", PLACES, (f"track{more[0]}", {track: f"{track}{more[1]}" for track in PLACES})),
        ("x", PLACES, ("score", dict.fromkeys(PLACES, "0.9"))),
        ("y", [1], ("score", dict.fromkeys(PLACES, "0.9"))),
    ):
        lines = [
            f"drive,{first + frame},{PLACES[track]},80,20,60,{values[track]}"
            for frame in range(N_FRAMES)
            for track in tracks
        ]
        head = f"recording,frame,x,y,w,h,{last}"
        (folder / f"{name}.csv").write_text("\n".join([head, *lines]) + "\n")
    times = np.arange(-4, N_FRAMES / FPS, 0.1)
    levels = np.where(times < DARK_FROM_S, 1000, 10)
    readings = [f"{first / FPS + time:.1f},{lux}" for time, lux in zip(times, levels, strict=True)]
    (folder / "lux.csv").write_text("\n".join(["time_s,lux", *readings]) + "\n")
    session = folder / "session.toml"
    session.write_text(
        f'[defaults]\nsize = "320x240"\nfps = {FPS}\nframes = "{first}:{first + N_FRAMES - 1}"\n'
        f'[[recording]]\nname = "drive"\nvisible = "visible"\nfirst_picture = {first}\n'
        'light = "lux.csv"\n'
        '[truth]\npath = "truth.csv"\n'
        '[[system]]\nname = "one"\npath = "x.csv"\n[[system]]\nname = "two"\npath = "y.csv"\n'
    )
    return session


def study_figures(n: int) -> list[tuple[int, int, int]]:
    """Left, upper edge and level of the pedestrian of each picture of a study.

    Two of four are bright: also among those that are shown at one of two times.
    """
    return [(20 + 37 * i % 280, 60 + 29 * i % 110, BRIGHT if i % 4 < 2 else DIM) for i in range(n)]


def write_study(folder: Path, n: int) -> None:
    """Write so many pictures of a study."""
    folder.mkdir(parents=True)
    lines = ["image,pedestrian,x,y,w,h"]
    for i, figure in enumerate(study_figures(n)):
        name = f"scene_{i:02}.png"
        write_picture(folder / name, scene(figure))
        lines.append(f"{name},p,{figure[0]},{figure[1]},{FIGURE[0]},{FIGURE[1]}")
    (folder / "boxes.csv").write_text("\n".join(lines) + "\n")
