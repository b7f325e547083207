"""Findings on a camera view unlike that of a car, for which the lateral position tells most."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.auditing.cases import recording_findings
from nvcore.common.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.common.wording import percent
from nvcore.dataset import Dataset
from nvcore.metrics.encounters import encounters_of
from nvcore.settings.params import Params

MIN_BOXES: Final = 100
MIN_PEDESTRIANS: Final = 5
"""Boxes of fewer pedestrians, or fewer boxes, may be anywhere by chance."""
LARGEST_SPREAD: Final = 0.42
"""Largest standard deviation of foot rows as a share of that of lateral positions. It is 0.10 to
0.40 in 30 recordings from cars, and 0.45 for a camera that looks down on a square (PETS09-S2L1)."""


def audit_foot_spread(dataset: Dataset, params: Params) -> list[Finding]:
    """Report recordings whose pedestrians spread over more rows than in front of a car's camera.

    The lateral distance, which is the default, takes people above each other in the picture for
    people in the same place.
    """
    if params.distance != "lateral" or not dataset.objects.is_on_road:
        return []
    spread = foot_spread(dataset)
    odd = np.flatnonzero(spread >= LARGEST_SPREAD)
    if not len(odd):
        return []
    return recording_findings(
        dataset,
        Severity.NOTE,
        "foot-spread",
        TRUTH_NAME,
        odd,
        "foot points spread over many rows of the picture, unlike before a camera in a car (first: "
        f"their spread is {percent(spread[odd[0]])} of that sideways)",
        dataset.objects.say(
            "Compare by foot points, too: sideways, {people} above one another in the picture are "
            "in one place."
        ),
        steps=(Step(Remedy.OPTION, "ground", "distance"),),
    )


def foot_spread(dataset: Dataset) -> np.ndarray:
    """Return the ratio of standard deviations of pedestrians' foot rows and lateral positions.

    Cached in the dataset.

    Returns
    -------
    float64, shape (n_recordings,); NaN with fewer than `MIN_BOXES` boxes or `MIN_PEDESTRIANS`, or
    without any lateral spread.
    """
    return dataset.kept("foot_spread", _spread_of)


def _spread_of(dataset: Dataset) -> np.ndarray:
    truth, frames = dataset.truth, dataset.frame_columns
    rows = np.flatnonzero(~truth.ignore)
    recording = frames.recording[truth.frame_index[rows]]
    centre = truth.x[rows] + 0.5 * truth.w[rows]
    foot = truth.y[rows] + truth.h[rows]
    n_recordings = len(frames.fps)
    n = np.bincount(recording, minlength=n_recordings)
    n_people = np.bincount(encounters_of(dataset)[1].recording, minlength=n_recordings)
    spreads = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for values in (foot, centre):
            mean = np.bincount(recording, values, n_recordings) / n
            off = (values - mean[recording]) ** 2
            spreads.append(np.sqrt(np.bincount(recording, off, n_recordings) / n))
        ratio = spreads[0] / spreads[1]
    is_enough = (n >= MIN_BOXES) & (n_people >= MIN_PEDESTRIANS) & (spreads[1] > 0)
    return np.where(is_enough, ratio, np.nan)
