"""A drive past two speed signs, and two systems that see them now and then; countable by hand."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

SIGNS = {1: range(10), 2: range(20, 30)}
"""Frames of each sign, by its track; 40 x 40 px, in 40 frames of 640x480 px at 10 Hz."""
SEEN_BY_X = {1: (3, 4), 2: ()}
SEEN_BY_Y = {1: (9,), 2: range(25, 30)}
"""Frames in which a system matches each sign."""
ALARM = "drive,15,50,300,40,40,0.3\n"
"""X's only false alarm."""


def _box(track: int, frame: int) -> str:
    return f"{300 + 60 * track},{150 - frame},40,40"


def _detections(seen: dict[int, Iterable[int]], more: str = "") -> str:
    rows = [f"drive,{i},{_box(track, i)},0.9\n" for track in seen for i in seen[track]]
    return "recording,frame,x,y,w,h,score\n" + "".join(rows) + more


def write_signs(folder: Path, *, x: str = "X-ray", y: str = "Yonder", lines: str = "") -> Path:
    """The session file of the drive; `x` and `y` name the systems, `lines` stand at its end."""
    truth = "recording,frame,track,x,y,w,h,class\n"
    for track, frames in SIGNS.items():
        for i in frames:
            truth += f"drive,{i},{track},{_box(track, i)},speed limit 50\n"
    truth += "drive,5,7,20,20,40,40,give way\n"  # not one of them
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "truth.csv").write_text(truth)
    (folder / "x.csv").write_text(_detections(SEEN_BY_X, ALARM))
    (folder / "y.csv").write_text(_detections(SEEN_BY_Y))
    session = folder / "session.toml"
    session.write_text(
        '[defaults]\nsize = "640x480"\nfps = 10\nframes = "0:39"\n[truth]\npath = "truth.csv"\n'
        f'[[system]]\nname = "{x}"\npath = "x.csv"\n[[system]]\nname = "{y}"\npath = "y.csv"\n'
        '[compare]\nobjects = "speed sign"\n[parameters]\ncoverage = 0.2\n'
        "midpoint = 20\nspread = 4\n" + lines
    )
    return session
