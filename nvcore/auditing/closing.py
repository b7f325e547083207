"""Findings on closing speeds that differ from the speed assumed for time left."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.auditing.cases import spelled
from nvcore.common.findings import TRUTH_NAME, Cases, Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.dataset.schema import KMH, NO_TRACK
from nvcore.metrics.encounters import encounters_of
from nvcore.settings.params import Params

MIN_BOXES: Final = 5
"""Fewest distances of a pedestrian for measuring a speed, as for the time to contact."""
MIN_PEDESTRIANS: Final = 3
"""Fewest pedestrians whose median speed indicates the car's speed."""
FACTOR: Final = 2.0
"""Least ratio of speeds that are far apart. Pedestrians' own steps and the car's braking change the
median by less."""


def audit_closing_speed(dataset: Dataset, params: Params) -> list[Finding]:
    """Find recordings whose pedestrians approach much faster or slower than time left assumes.

    Time to contact is measured in the recording, while the time needed to stop and the speed of
    impact use the stated or assumed speed. If the two speeds differ, these results describe
    different cars.
    """
    closing_kmh = closing_speeds(dataset)
    frames = dataset.frame_columns
    speed_kmh = pd.Series(frames.speed_kmh).groupby(frames.recording).median()
    stated_kmh = speed_kmh.reindex(range(len(closing_kmh))).to_numpy()
    used_kmh = np.where(np.isnan(stated_kmh), params.speed_kmh, stated_kmh)
    slower_kmh, faster_kmh = np.minimum(used_kmh, closing_kmh), np.maximum(used_kmh, closing_kmh)
    odd = np.flatnonzero(faster_kmh >= FACTOR * slower_kmh)
    if not len(odd):
        return []
    names = dataset.recordings["name"]
    speeds = [
        f"{names.iloc[row]} at {closing_kmh[row]:.0f} km/h ({used_kmh[row]:.4g} km/h "
        f"{'assumed' if np.isnan(stated_kmh[row]) else 'stated'})"
        for row in odd
    ]
    return [
        Finding(
            severity=Severity.NOTE,
            code="closing-speed",
            subject=TRUTH_NAME,
            count=len(odd),
            message=(
                f"In {count_text(len(odd), 'recording')} {dataset.objects.plural} come nearer at a "
                "speed far from the one that time left is computed with (median, by the truth's "
                f"distances): {spelled(speeds)}."
            ),
            advice=(
                "Last chances to stop and impact speeds are those of a car at the assumed or "
                "stated speed; to get those of the car that made a recording, give its speed."
            ),
            # one speed for all recordings would be wrong for others
            steps=(Step(Remedy.OPTION, "", "speed_kmh" if len(names) == 1 else "recordings"),),
            example=f"recording {names.iloc[odd[0]]}",
            cases=Cases("frames", dataset.frame_columns.first[odd]),
        )
    ]


def closing_speeds(dataset: Dataset) -> np.ndarray:
    """Measure how fast the pedestrians of each recording approach, km/h. Cached in the dataset.

    A pedestrian's speed is the slope of the least-squares line of distance over time. A recording's
    speed is the median over pedestrians who come nearer.

    Returns
    -------
    float64, shape (n_recordings,); NaN with fewer than `MIN_PEDESTRIANS`, or if time left is
    unknown (not every frame is evaluated, or we linked the tracks).
    """
    return dataset.kept("closing_speeds", _speeds_of)


def _speeds_of(dataset: Dataset) -> np.ndarray:
    truth, frames = dataset.truth, dataset.frame_columns
    _, encounters = encounters_of(dataset)
    has_distance = np.isfinite(truth.distance_m[encounters.order])
    rows, frame_row = encounters.order[has_distance], encounters.frame_index[has_distance]
    pedestrian, n_pedestrians = encounters.encounter_of[rows], len(encounters)
    n = np.bincount(pedestrian, minlength=n_pedestrians)

    def centred(values: np.ndarray) -> np.ndarray:
        mean = np.bincount(pedestrian, values, n_pedestrians)[pedestrian] / n[pedestrian]
        off: np.ndarray = values - mean
        return off

    time_s = centred(frames.frame[frame_row] / frames.fps[frames.recording[frame_row]])
    shared = np.bincount(pedestrian, time_s * centred(truth.distance_m[rows]), n_pedestrians)
    spread = np.bincount(pedestrian, time_s**2, n_pedestrians)
    is_measured = (n >= MIN_BOXES) & (spread > 0)
    closing_kmh = -KMH * np.divide(shared, spread, out=np.zeros(n_pedestrians), where=is_measured)
    is_given = truth.track[encounters.order[encounters.offsets[:-1]]] != NO_TRACK
    is_nearing = is_given & (closing_kmh > 0) & (frames.sampling_step <= 1)[encounters.recording]
    speeds = np.full(len(frames.fps), np.nan)
    for row in np.unique(encounters.recording[is_nearing]):  # a loop over recordings
        own = closing_kmh[is_nearing & (encounters.recording == row)]
        if len(own) >= MIN_PEDESTRIANS:
            speeds[row] = np.median(own)
    return speeds
