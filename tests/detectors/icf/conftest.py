"""Small scenes with red-rimmed discs on rectangles and noise, and a model trained on them."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from nvcore.subjects.detectors.icf import IcfModel, IcfSettings, Scene, train

SETTINGS = IcfSettings(
    window_width=24,
    window_height=24,
    object_width=20.0,
    object_height=20.0,
    features=400,
    feature_share=0.25,
    trees_per_round=(12, 48),
    negatives=500,
    negatives_per_round=200,
    scales=(0.9, 1.0, 1.1, 1.2, 1.35),
    stride=3,
    overlap_of="smaller",
)


def draw(seed: int, n_discs: int = 2) -> Scene:
    rng = np.random.default_rng(seed)
    noise = rng.integers(60, 160, 3)[None, None] + rng.normal(0, 12, (120, 160, 3))
    picture = cv2.GaussianBlur(noise.clip(0, 255).astype(np.uint8), (3, 3), 0)
    for _ in range(6):
        x, y, w, h = (int(v) for v in rng.integers((0, 0, 8, 8), (140, 100, 30, 30)))
        colour = tuple(int(value) for value in rng.integers(0, 255, 3))
        cv2.rectangle(picture, (x, y), (x + w, y + h), colour, -1)
    boxes = []
    for i in range(n_discs):
        radius = int(rng.integers(9, 14))
        x, y = int(rng.integers(20 + 70 * i, 60 + 70 * i)), int(rng.integers(20, 100))
        cv2.circle(picture, (x, y), radius, (240, 240, 240), -1)
        cv2.circle(picture, (x, y), radius, (200, 20, 20), 3)
        boxes.append([x - radius - 1, y - radius - 1, 2 * radius + 3, 2 * radius + 3])
    return Scene(picture, np.array(boxes, float).reshape(-1, 4))


@pytest.fixture(scope="session")
def drawn() -> Callable[..., Scene]:
    """A scene of 160x120 px by its number: with two discs, unless told otherwise."""
    return draw


@pytest.fixture(scope="session")
def settings() -> IcfSettings:
    return SETTINGS


@pytest.fixture(scope="session")
def model() -> IcfModel:
    return train([draw(i) for i in range(30)], SETTINGS, name="discs", label="disc", seed=1)
