"""Answers of simulated subjects to the pictures of the study. Nobody was asked.

Every subject sees every picture at all six times, two pictures per run: one after `T`, the other 4
to 4.5 s later, as in the paper. Subjects differ in sensitivity, in how often they look away and in
how readily they guess. One of them hardly ever looks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from tools.sample.camera import Floats
from tools.sample.study.observer import PERIODS_S, picking, seeing, visibility
from tools.sample.study.scenes import FIXATION, PEDESTRIAN, SIZE

TRIALS_FILE: Final = "trials_simulated.csv"
TRUTH_FILE: Final = "trials_simulated_truth.csv"
N_SUBJECTS: Final = 16
DEVICE: Final = "simulated"
DISPLAY_S: Final = 0.5
PAIRS_S: Final = ((0.0, 4.0), (1.0, 5.5), (2.5, 7.0))
"""Times of the two pictures of a run, seconds after the change of light."""
ABSENT: Final = 11
"""Number of the subject who often does not look."""
SEED: Final = 88

_SENSITIVITY_SPREAD: Final = 0.2
_AIM_PX: Final = 14.0
_REFRESH_S: Final = 1 / 60


@dataclass(frozen=True)
class Subject:
    """Simulated subject.

    Attributes
    ----------
    gain
        Sensitivity to contrast relative to the model's observer.
    lapse
        Share of pictures that the subject does not look at.
    guess
        Share of the unseen pedestrians for which the subject touches some place nevertheless.
    """

    name: str
    gain: float
    lapse: float
    guess: float

    def chance(self, visible: Floats, picked: Floats) -> Floats:
        """Return the chance that the subject sees a pedestrian, 0 to 1."""
        return np.asarray((1 - self.lapse) * seeing(visible, gain=self.gain) * picked)


def subjects() -> list[Subject]:
    """Return the subjects, the same on every call."""
    generator = np.random.default_rng(SEED)
    people = []
    for number in range(1, N_SUBJECTS + 1):
        gain = float(np.exp(generator.normal(0.0, _SENSITIVITY_SPREAD)))
        lapse, guess = float(generator.uniform(0.01, 0.05)), float(generator.uniform(0.02, 0.2))
        if number == ABSENT:
            lapse, guess = 0.75, 0.25
        people.append(Subject(f"S{number:02d}", gain, lapse, guess))
    return people


def truth_rows(
    image: str, box: tuple[float, float, float, float], pictures: tuple[np.ndarray, np.ndarray]
) -> pd.DataFrame:
    """Return the observer model's values for one picture, a row per period.

    Parameters
    ----------
    pictures
        Pictures with and without the pedestrian.

    Returns
    -------
    ``image, pedestrian, period_s``, ``visibility`` (contrast as a multiple of the threshold),
    ``picking`` (chance to pick them out in one glance) and ``probability`` (chance that a subject
    sees them, averaged over all subjects).
    """
    visible = np.round(visibility(*pictures, box, FIXATION), 3)
    picked = np.round(picking(box, FIXATION), 4)
    chances = [subject.chance(visible, np.asarray(picked)) for subject in subjects()]
    return pd.DataFrame(
        {
            "image": image,
            "pedestrian": PEDESTRIAN,
            "period_s": PERIODS_S,
            "visibility": visible,
            "picking": picked,
            "probability": np.round(np.mean(chances, axis=0), 4),
        }
    )


def simulated_trials(truth: pd.DataFrame, boxes: pd.DataFrame) -> pd.DataFrame:
    """Return the trials of all subjects, in the columns of a study's trials file.

    Parameters
    ----------
    truth
        Tables of `truth_rows` for all pictures.
    boxes
        ``image, x, y, w, h``.
    """
    known = truth.merge(boxes[["image", "x", "y", "w", "h"]], on="image", validate="many_to_one")
    known["adaptation_asked_s"] = known["period_s"] - DISPLAY_S
    known = known.set_index(["image", "adaptation_asked_s"])
    images = list(boxes["image"])
    tables = [
        _answers(subject, known, _order(images, np.random.default_rng([SEED, number])))
        for number, subject in enumerate(subjects())
    ]
    return pd.concat(tables, ignore_index=True)


def _order(images: list[str], generator: np.random.Generator) -> pd.DataFrame:
    """Return the runs of one subject in random order, with two different pictures each."""
    runs = []
    for first_s, second_s in PAIRS_S:
        order = generator.permutation(len(images))
        other = np.roll(order, int(generator.integers(1, len(images))))
        runs += [
            ((images[a], first_s), (images[b], second_s)) for a, b in zip(order, other, strict=True)
        ]
    rows = [
        (number, position, image, asked_s)
        for number, index in enumerate(generator.permutation(len(runs)), start=1)
        for position, (image, asked_s) in enumerate(runs[index], start=1)
    ]
    return pd.DataFrame(rows, columns=["run", "position", "image", "adaptation_asked_s"])


def _answers(subject: Subject, known: pd.DataFrame, shown: pd.DataFrame) -> pd.DataFrame:
    generator = np.random.default_rng([SEED, 1000 + int(subject.name[1:])])
    n = len(shown)
    keys = pd.MultiIndex.from_frame(shown[["image", "adaptation_asked_s"]])
    at = known.loc[keys]
    chance = subject.chance(at["visibility"].to_numpy(), at["picking"].to_numpy())
    sees = generator.random(n) < chance
    touches = sees | (generator.random(n) < subject.guess)
    middle = np.stack([at["x"] + at["w"] / 2, at["y"] + at["h"] / 2], axis=1)
    aimed = middle + generator.normal(0.0, _AIM_PX, (n, 2))
    anywhere = generator.uniform([0.05, 0.30], [0.95, 0.70], (n, 2)) * SIZE
    touch = np.round(np.clip(np.where(sees[:, None], aimed, anywhere), 0, np.array(SIZE) - 1))
    touch[~touches] = np.nan
    response_s = 0.45 + np.exp(generator.normal(-0.9 + 0.5 * ~sees, 0.35, n))
    late_s = generator.uniform(0.0, _REFRESH_S, n)
    return shown.assign(
        subject=subject.name,
        order=np.arange(1, n + 1),
        pedestrian=PEDESTRIAN,
        adaptation_measured_s=np.round(shown["adaptation_asked_s"] + late_s, 3),
        touch_x=touch[:, 0],
        touch_y=touch[:, 1],
        response_s=np.round(response_s, 3),
        not_seen=(~touches).astype(int),
        device=DEVICE,
    )[
        [
            *("subject", "run", "position", "order", "image", "pedestrian"),
            *("adaptation_asked_s", "adaptation_measured_s", "touch_x", "touch_y"),
            *("response_s", "not_seen", "device"),
        ]
    ]


def trials_text(table: pd.DataFrame) -> str:
    """Return trials as CSV in whole pixels, with equal bytes on every system."""
    whole = table.assign(
        touch_x=table["touch_x"].astype("Int64"), touch_y=table["touch_y"].astype("Int64")
    )
    return str(whole.to_csv(index=False, lineterminator="\n"))
