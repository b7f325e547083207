"""Trials whose answer is known: detectability is a function of two features and the period."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from nvcore.subjects.driver.trials import TRIAL_COLUMNS, TrainingTable, training_table
from nvcore.subjects.driver.trials.table import read_trials

PERIODS_S = (0.5, 1.5, 3.0, 4.5, 6.0, 7.5)
SUBJECTS = tuple(f"S{number}" for number in range(20))
CHOSEN = ("luminance_contrast", "fixation_distance_px")
"""The features on which detectability depends."""


def true_detectability(features: pd.DataFrame, period_s: float) -> np.ndarray:
    """Contrast decides most soon after the change of light, distance from the fixation later."""
    late = 0.15 + 0.7 * np.clip((period_s - 0.5) / 4, 0, 1)
    contrast = (features["luminance_contrast"] - 24) / 7
    near = (315 - features["fixation_distance_px"]) / 90
    return 1 / (1 + np.exp(-((1 - late) * contrast + late * near - 1 + late))).to_numpy()


def made_features(n: int = 51, seed: int = 1) -> pd.DataFrame:
    """One pedestrian in each of n pictures, and where they are."""
    rng = np.random.default_rng(seed)
    height = rng.uniform(60, 260, n)
    columns = {
        "width_px": 0.4 * height + rng.normal(0, 4, n),
        "height_px": height,
        "luminance_sd": rng.uniform(4, 30, n),
        "luminance_contrast": rng.uniform(2, 45, n),
        "lab_distance": rng.uniform(2, 30, n),
        "edge_contrast": rng.uniform(0, 60, n),
        "colour_emd": rng.uniform(0, 5, n),
        "fixation_distance_px": rng.uniform(30, 600, n),
    }
    image = [f"night_{number:02d}.jpg" for number in range(n)]
    place = {
        "x": rng.uniform(0, 1700, n).round(),
        "y": rng.uniform(300, 700, n).round(),
        "w": columns["width_px"].round(1),
        "h": columns["height_px"].round(1),
    }
    return pd.DataFrame({"image": image, "pedestrian": "p1", **place, **columns})


def made_trials(features: pd.DataFrame, subjects: tuple[str, ...] = SUBJECTS) -> pd.DataFrame:
    """The share of subjects that the known answer says is right, in each picture and period."""
    parts = []
    for number, period_s in enumerate(PERIODS_S):
        n_right = np.round(true_detectability(features, period_s) * len(subjects))
        for k, subject in enumerate(subjects):
            # another subject begins in each picture, so that all are right equally often
            turn = (k + 7 * np.arange(len(features)) + 3 * number) % len(subjects)
            sees = turn < n_right
            centre_x = features["x"] + features["w"] / 2
            centre_y = features["y"] + features["h"] / 2
            parts.append(
                pd.DataFrame(
                    {
                        "subject": subject,
                        "run": number % 3,
                        "position": 1 + number // 3,
                        "order": np.arange(len(features)),
                        "image": features["image"],
                        "pedestrian": features["pedestrian"],
                        "adaptation_asked_s": period_s - 0.5,
                        "adaptation_measured_s": period_s - 0.49,
                        "touch_x": centre_x.where(sees).round(),
                        "touch_y": centre_y.where(sees).round(),
                        "response_s": 1.2,
                        "not_seen": np.where(sees, 0, 1),
                        "device": "simulated",
                    }
                )
            )
    return pd.concat(parts, ignore_index=True)[list(TRIAL_COLUMNS)]


def write_trials(
    folder: Path, n: int = 51, subjects: tuple[str, ...] = SUBJECTS, seed: int = 1
) -> tuple[Path, Path]:
    """Files of the trials and of the features, boxes among them."""
    features = made_features(n, seed)
    trials_file, features_file = folder / "trials.csv", folder / "features.csv"
    made_trials(features, subjects).to_csv(trials_file, index=False)
    features.to_csv(features_file, index=False)
    return trials_file, features_file


def made_table(folder: Path, n: int = 51, seed: int = 1) -> TrainingTable:
    """What estimators learn of them."""
    return training_table(*write_trials(folder, n, seed=seed))


def parsed_trials(content: bytes) -> pd.DataFrame:
    """Read trials from the content of a file ``trials.csv``."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "trials.csv"
        path.write_bytes(content)
        return read_trials(path)
