"""A small ICF model, trained within seconds, which takes bright upright bars for pedestrians."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from nvcore.dataset.provenance import TrainedOn
from nvcore.subjects.detectors.icf import IcfModel, IcfSettings, Scene, train, write_model

SETTINGS = IcfSettings(
    channels=("grey", "magnitude", "orientations"),
    clahe_clip=2.0,
    window_width=16,
    window_height=32,
    object_width=10.0,
    object_height=26.0,
    features=200,
    least_area=8,
    trees_per_round=(4, 16),
    negatives=400,
    negatives_per_round=100,
    scales=(1.5, 2.0, 2.75),
    stride=4,
    overlap_of="smaller",
)


def scene(seed: int) -> Scene:
    """A grey picture of 160 x 120 px with noise and two bars."""
    rng = np.random.default_rng(seed)
    picture = rng.integers(20, 70, (120, 160), dtype=np.uint8)
    boxes = []
    for left in rng.integers((5, 80), (60, 130)).tolist():
        top, height = (int(value) for value in rng.integers((10, 45), (50, 60)))
        width = height * 10 // 26
        picture[top : top + height, left : left + width] = rng.integers(160, 250)
        boxes.append([left, top, width, height])
    return Scene(picture, np.array(boxes, float))


@cache
def model() -> IcfModel:
    """The model; it says that it was trained on a part of ``urban_crossing``."""
    part = TrainedOn(recording="urban_crossing", first_frame=0, last_frame=20)
    scenes = [scene(number) for number in range(12)]
    return train(scenes, SETTINGS, name="bars", label="pedestrian", trained_on=[part], seed=1)


def write(path: Path) -> Path:
    """The model as a file."""
    write_model(model(), path)
    return path
