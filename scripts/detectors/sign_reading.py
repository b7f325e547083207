"""Reading the limit on a sign: training, and evaluation in given boxes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

from nvcore.subjects.detectors.classifier import Classifier, train_classifier
from scripts.detectors.sign_data import (
    SPEED_LIMITS,
    TESTED,
    held_out,
    read_crops,
    read_rgb,
    read_scenes,
)
from scripts.detectors.sign_examples import examples
from scripts.detectors.sign_measures import SEED, share_text

MOVED = (0.08, 0.15)
"""Shares of their sides by which boxes are moved and resized to imitate a detector."""
Boxes = Iterable[tuple[np.ndarray, np.ndarray, Sequence[str]]]
"""Pictures, their boxes, and the limit in each box."""


def train_reader(realdata: Path) -> Classifier:
    """Train only the classifier that is part of a model of `train_signs`."""
    scenes, _ = examples(realdata, choosing=False).parts()
    start = perf_counter()
    holding = [scene for scene in scenes if scene.labels]
    boxes = ((scene.picture, scene.boxes, scene.labels) for scene in holding)
    reader = train_classifier(boxes, seed=SEED)
    assert reader is not None
    n_signs = sum(len(scene.labels) for scene in holding)
    print(f"trained to read the limits of {n_signs} signs in {perf_counter() - start:.0f} s")
    return reader


def read_in_boxes(name: str, reader: Classifier, boxes: Boxes) -> str:
    """Describe how many limits are read right in truth boxes."""
    n_signs = n_right = 0
    for picture, of_picture, limits in boxes:
        best = reader.probabilities(picture, of_picture).argmax(axis=1)
        n_signs += len(limits)
        n_right += sum(reader.classes[i] == limit for i, limit in zip(best, limits, strict=True))
    return f"{name}: {share_text(n_right, n_signs)} read right"


def reading_in_truth(realdata: Path, reader: Classifier) -> list[str]:
    """Describe how well limits are read in truth boxes."""
    scenes = read_scenes(realdata / "gtsdb" / "train")
    report = read_scenes(realdata / "gtsdb" / "report")
    tested = [scene for scene in scenes if scene.number % 4 == TESTED]
    _, crops = held_out(read_crops(realdata / "gtsrb"))
    boxes_of: list[tuple[str, Boxes]] = [
        (name, ((scene.read(), scene.boxes, scene.limits) for scene in part if scene.limits))
        for name, part in (("scenes for testing", tested), ("scenes of the report", report))
    ]
    rng = np.random.default_rng(SEED)
    for share in (0.0, *MOVED):
        of_crops = [
            (read_rgb(crop.path), moved(crop.box, share, rng)[None], (SPEED_LIMITS[crop.sign],))
            for crop in crops
        ]
        how = f", boxes moved and resized by up to {share:.0%}" if share else ""
        boxes_of.append((f"crops held out{how}", of_crops))
    return [read_in_boxes(name, reader, boxes) for name, boxes in boxes_of]


def moved(box: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Move and resize a box at random, by up to a share of its sides."""
    across, down, growth = rng.uniform(-share, share, 3)
    size = box[2:] * (1 + growth)
    centre = box[:2] + box[2:] * (0.5 + np.array([across, down]))
    return np.concatenate([centre - size / 2, size])
