"""A drive with numbered pictures, as a session with one recording: which picture shows what."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from picture_files import HEIGHT, WIDTH


def write_drive(
    folder: Path, pictures: str, frames: Iterable[int] = range(60), *, name: str = "drive"
) -> Path:
    """Session file of a drive with one pedestrian in every frame, whom X and Y detect.

    Parameters
    ----------
    pictures
        As the session file names them.
    """
    rows = [f"{frame},20,10,8,20" for frame in frames]
    (folder / "truth.csv").write_text("\n".join(["frame,x,y,w,h", *rows]))
    for system, score in (("x", 0.9), ("y", 0.8)):
        scored = [f"{row},{score - n % 7 / 20}" for n, row in enumerate(rows)]
        (folder / f"{system}.csv").write_text("\n".join(["frame,x,y,w,h,score", *scored]))
    path = folder / "session.toml"
    path.write_text(
        f'[[recording]]\nname = "{name}"\nwidth = {WIDTH}\nheight = {HEIGHT}\nfps = 20\n'
        f'frames = "list.txt"\npictures = "{pictures}"\n[truth]\npath = "truth.csv"\n'
        '[[system]]\nname = "X"\npath = "x.csv"\n[[system]]\nname = "Y"\npath = "y.csv"\n',
        encoding="utf-8",
    )
    (folder / "list.txt").write_text("\n".join(map(str, frames)))
    return path
