"""Folders with pictures for a study: a dark road each, with one bright figure."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nvcore.pictures.stretch import png

WIDTH, HEIGHT = 320, 180
FIGURE = (20, 40)
"""Width and height of the pedestrian, px."""


def places(n: int) -> list[tuple[int, int]]:
    """Left and upper edge of the pedestrian of each picture."""
    return [(20 + 50 * (i % 6), 60 + 5 * (i % 4)) for i in range(n)]


def write(folder: Path, n: int) -> Path:
    """Write so many pictures and their table; the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["image,pedestrian,x,y,w,h"]
    for i, (x, y) in enumerate(places(n)):
        picture = np.full((HEIGHT, WIDTH, 3), (30, 32, 40), np.uint8)
        picture[HEIGHT // 2 :] = (22, 22, 24)
        picture[y : y + FIGURE[1], x : x + FIGURE[0]] = (190, 180, 170)
        (folder / f"scene_{i}.png").write_bytes(png(picture))
        lines.append(f"scene_{i}.png,p{i},{x},{y},{FIGURE[0]},{FIGURE[1]}")
    (folder / "boxes.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder
