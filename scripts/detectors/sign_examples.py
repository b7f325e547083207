"""Training data for a detector of speed limits, and its training."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from nvcore.subjects.detectors.icf import SIGNS, IcfModel, IcfSettings, train
from scripts.detectors.sign_data import (
    CHOOSING,
    TESTED,
    Crop,
    SignScene,
    SignScenes,
    held_out,
    read_crops,
    read_scenes,
    unlike,
    unlike_scenes,
)
from scripts.detectors.sign_measures import SEED

EVERY = 6
"""Every sixth crop and scene with a sign is held out of the training for calibration."""


@dataclass(frozen=True)
class Examples:
    """Training data, without test data.

    Attributes
    ----------
    scenes, crops
        Scenes and crops of the training.
    alike
        Names of crops and scenes left out because they resemble a sign of a test scene.
    """

    scenes: list[SignScene]
    crops: list[Crop]
    alike: list[str]

    def parts(self) -> list[SignScenes]:
        """Split into training data and data for calibrating the rejection."""
        limits = [crop for crop in self.crops if crop.is_speed_limit]
        with_signs = [scene for scene in self.scenes if len(scene.boxes)]
        calibrating = {crop.path.name for crop in limits[::EVERY]}
        calibrating |= {scene.path.name for scene in with_signs[::EVERY]}
        return [
            SignScenes(
                [scene for scene in self.scenes if (scene.path.name in calibrating) == is_out],
                [crop for crop in self.crops if (crop.path.name in calibrating) == is_out],
            )
            for is_out in (False, True)
        ]


def examples(realdata: Path, *, choosing: bool, strict: bool = False) -> Examples:
    """Load scenes and crops to train on.

    Parameters
    ----------
    choosing
        Also leave out the scenes on which settings are chosen.
    strict
        Also leave out scenes, not only crops, with a sign that resembles one for testing.
    """
    scenes = read_scenes(realdata / "gtsdb" / "train")
    tested = [scene for scene in scenes if scene.number % 4 == TESTED]
    tested += read_scenes(realdata / "gtsdb" / "report")
    out = {TESTED, CHOOSING} if choosing else {TESTED}
    crops, _ = held_out(read_crops(realdata / "gtsrb"))
    crops, alike = unlike(crops, tested)
    holding = [scene for scene in scenes if scene.number % 4 not in out]
    if strict:
        holding, more = unlike_scenes(holding, tested)
        alike += more
    return Examples(holding, crops, alike)


def train_signs(of: Examples, settings: IcfSettings = SIGNS, seed: int = SEED) -> IcfModel:
    """Train a model on these examples."""
    parts = of.parts()
    start = perf_counter()

    def progress(share: float, what: str) -> None:
        print(f"\r{share:4.0%} {what:40s} {perf_counter() - start:5.0f} s", end="", flush=True)

    model = train(
        parts[0],
        settings,
        name="speed limits",
        label="speed limit",
        seed=seed,
        held_out=parts[1],
        progress=progress,
    )
    print(f"\r{'trained':45s} {perf_counter() - start:5.0f} s")
    return model
