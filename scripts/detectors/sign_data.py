"""German traffic signs for training (GTSDB scenes and GTSRB crops) and their split.

Scenes in `gtsdb/report` are for testing only. Of every four scenes in `gtsdb/train`, by number, one
is for testing, one for choosing settings, and two are for training. The final model is trained on
all but the test scenes. Every third crop is held out.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from nvcore.subjects.detectors.icf import Scene
from nvcore.subjects.detectors.icf.windows import LazyScenes

_LIMITS: Final = ("20", "30", "50", "60", "70", "80", "", "100", "120")
SPEED_LIMITS: Final = {number: limit for number, limit in enumerate(_LIMITS) if limit}
"""Limit shown by each speed-limit class, km/h."""
TESTED, CHOOSING = 0, 1
"""Roles of scenes by their number modulo 4."""
ALIKE: Final = 0.85
"""Minimum normalised cross-correlation at which a crop counts as the sign of a test scene."""
_COMPARED_PX: Final = 32


@dataclass(frozen=True)
class SignScene:
    """Road scene: picture, boxes of speed limits, (n, 4), and the limits they show."""

    path: Path
    boxes: np.ndarray
    limits: tuple[str, ...] = ()

    @property
    def number(self) -> int:
        """Number in the file name."""
        return int(self.path.stem)

    def read(self) -> np.ndarray:
        """Read the picture as RGB."""
        return read_rgb(self.path)


@dataclass(frozen=True)
class Crop:
    """Picture of one sign."""

    path: Path
    box: np.ndarray
    sign: int

    @property
    def is_speed_limit(self) -> bool:
        """Whether the sign is one of the eight speed limits."""
        return self.sign in SPEED_LIMITS


class SignScenes(LazyScenes):
    """Scenes followed by crops, each read once."""

    def __init__(self, scenes: Sequence[SignScene], crops: Sequence[Crop]) -> None:
        self._scenes, self._crops = scenes, crops
        super().__init__(cache(self._scene), range(len(scenes) + len(crops)))

    def _scene(self, index: int) -> Scene:
        if index < len(self._scenes):
            scene = self._scenes[index]
            return Scene(scene.read(), scene.boxes, labels=scene.limits)
        crop = self._crops[index - len(self._scenes)]
        picture = read_rgb(crop.path)
        if crop.is_speed_limit:
            limit = SPEED_LIMITS[crop.sign]
            return Scene(picture, crop.box[None], has_background=False, labels=(limit,))
        return Scene(picture)


def read_rgb(path: Path) -> np.ndarray:
    """Read a picture file as RGB."""
    return cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def read_scenes(folder: Path) -> list[SignScene]:
    """Read the scenes of a GTSDB folder, whose corners are inclusive."""
    boxes: dict[str, list[list[float]]] = {}
    limits: dict[str, list[str]] = {}
    for line in (folder / "gt.txt").read_text().split():
        name, *values = line.split(";")
        x1, y1, x2, y2, sign = map(int, values)
        if sign in SPEED_LIMITS:
            boxes.setdefault(name, []).append([x1, y1, x2 - x1 + 1, y2 - y1 + 1])
            limits.setdefault(name, []).append(SPEED_LIMITS[sign])
    return [
        SignScene(
            folder / name,
            np.array(boxes.get(name) or np.empty((0, 4)), float),
            tuple(limits.get(name, ())),
        )
        for name in (folder / "scenes.txt").read_text().split()
    ]


def read_crops(folder: Path) -> list[Crop]:
    """Read the crops of GTSRB, sorted by name. Corners of the sign are inclusive."""
    crops = []
    with (folder / "Test.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            x1, y1, x2, y2 = (int(row[f"Roi.{side}"]) for side in ("X1", "Y1", "X2", "Y2"))
            box = np.array([x1, y1, x2 - x1 + 1, y2 - y1 + 1], float)
            crops.append(Crop(folder / row["Path"], box, int(row["ClassId"])))
    return sorted(crops, key=lambda crop: crop.path.name)


def held_out(crops: Sequence[Crop]) -> tuple[list[Crop], list[Crop]]:
    """Split crops into those to train on and a third of the speed limits."""
    limits = [crop for crop in crops if crop.is_speed_limit]
    tested = limits[::3]
    names = {crop.path.name for crop in tested}
    return [crop for crop in crops if crop.path.name not in names], tested


def unlike(crops: Sequence[Crop], scenes: Sequence[SignScene]) -> tuple[list[Crop], list[str]]:
    """Return crops unlike all speed limits of these scenes, and the names of the others."""
    reference = np.concatenate([signs_of(scene) for scene in scenes])
    distinct, alike = [], []
    for crop in crops:
        best = (reference @ standardised(read_rgb(crop.path), crop.box)).max()
        if crop.is_speed_limit and best > ALIKE:
            alike.append(crop.path.name)
        else:
            distinct.append(crop)
    return distinct, alike


def unlike_scenes(
    trained: Sequence[SignScene], tested: Sequence[SignScene]
) -> tuple[list[SignScene], list[str]]:
    """Return scenes without speed limits that resemble tested ones, and the others' names.

    Signs of one limit look alike by design, so not every omitted scene shows a sign of the tests.
    """
    reference = np.concatenate([signs_of(scene) for scene in tested])
    is_alike = [(signs_of(scene) @ reference.T).max(initial=-1) > ALIKE for scene in trained]
    distinct = [scene for scene, out in zip(trained, is_alike, strict=True) if not out]
    return distinct, [scene.path.name for scene, out in zip(trained, is_alike, strict=True) if out]


def signs_of(scene: SignScene) -> np.ndarray:
    """Return the speed limits of a scene, `standardised`, (n, 1024)."""
    picture = scene.read() if len(scene.boxes) else None
    signs = [standardised(picture, box) for box in scene.boxes]
    return np.array(signs).reshape(-1, _COMPARED_PX**2)


def standardised(picture: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return a sign as a grey patch of mean 0 and norm 1, for cross-correlation by products."""
    x, y, w, h = box.astype(int)
    grey = cv2.cvtColor(picture[y : y + h, x : x + w], cv2.COLOR_RGB2GRAY)
    size = (_COMPARED_PX, _COMPARED_PX)
    patch = cv2.resize(grey, size, interpolation=cv2.INTER_AREA).astype(float).ravel()
    patch -= patch.mean()
    return patch / max(float(np.linalg.norm(patch)), 1e-9)
