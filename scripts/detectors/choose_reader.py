"""Choose the settings of the speed-limit classifier without using the test data.

    python -m scripts.detectors.choose_reader

The script trains on training crops and scenes except every fourth crop, and reads these held-out
crops, unchanged and with boxes moved by up to 8 %, and the scenes for choosing. The best setting
has the highest mean of the three shares (three minutes on a free core). Then
`scripts.detectors.train_signs --reader` measures it on the test data.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final
from unittest.mock import patch

import numpy as np

from nvcore.subjects.detectors import classifier
from nvcore.subjects.detectors.classifier import Classifier, train_classifier
from scripts.detectors.sign_data import (
    CHOOSING,
    SPEED_LIMITS,
    Crop,
    SignScene,
    SignScenes,
    read_rgb,
    read_scenes,
)
from scripts.detectors.sign_examples import examples
from scripts.detectors.sign_measures import SEED
from scripts.detectors.sign_reading import MOVED, Boxes, moved
from scripts.realdata import realdata

EVERY: Final = 4
VARIANTS: Final = [
    *(
        {"_PENALTY": penalty, "_MOVED": share, "_CELL": 4}
        for penalty in (1e-2, 1e-3, 1e-4, 1e-5)
        for share in MOVED
    ),
    {"_PENALTY": 1e-3, "_MOVED": MOVED[0], "_CELL": 8},
]


def right_share(reader: Classifier, boxes: Boxes) -> float:
    """Return the share of limits that are read right."""
    is_right = [
        reader.classes[i] == limit
        for picture, of_picture, limits in boxes
        for i, limit in zip(
            reader.probabilities(picture, of_picture).argmax(axis=1), limits, strict=True
        )
    ]
    return float(np.mean(is_right))


def of_crops(crops: Sequence[Crop], share: float) -> Boxes:
    """Yield each crop with its box, moved by up to a share of its sides."""
    rng = np.random.default_rng(SEED)
    for crop in crops:
        box = moved(crop.box, share, rng)[None]
        yield read_rgb(crop.path), box, (SPEED_LIMITS[crop.sign],)


def of_scenes(scenes: Sequence[SignScene]) -> Boxes:
    """Yield each scene with the boxes of its speed limits."""
    return ((scene.read(), scene.boxes, scene.limits) for scene in scenes if scene.limits)


def main() -> None:
    """Train and test each variant."""
    folder = realdata()
    of_training = examples(folder, choosing=True)
    limits = [crop for crop in of_training.crops if crop.is_speed_limit]
    aside = limits[::EVERY]
    names = {crop.path.name for crop in aside}
    learned = SignScenes(
        [scene for scene in of_training.scenes if scene.limits],
        [crop for crop in limits if crop.path.name not in names],
    )
    scenes = read_scenes(folder / "gtsdb" / "train")
    choosing = [scene for scene in scenes if scene.number % 4 == CHOOSING]
    print(f"{len(learned)} pictures to learn from, {len(aside)} crops put aside")
    for variant in VARIANTS:
        side = classifier.SIDE // variant["_CELL"] - 1
        sizes = {"N_VALUES": (2 * side) ** 2 * 9}
        with patch.multiple(classifier, **variant, **sizes):
            examples_of = ((scene.picture, scene.boxes, scene.labels) for scene in learned)
            reader = train_classifier(examples_of, seed=SEED)
            assert reader is not None
            shares = [
                right_share(reader, of_crops(aside, 0.0)),
                right_share(reader, of_crops(aside, MOVED[0])),
                right_share(reader, of_scenes(choosing)),
            ]
        words = ", ".join(f"{share:.1%}" for share in shares)
        setting = " ".join(f"{name}={value:g}" for name, value in variant.items())
        print(f"{setting}: mean {np.mean(shares):.1%} ({words})", flush=True)


if __name__ == "__main__":
    main()
