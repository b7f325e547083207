"""Encounters too short for figures of time: sampled annotation, tracks that were linked."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.audit.cases import TRUTH_NAME
from nvcore.dataset import Dataset
from nvcore.encounters import find_encounters, mostly_one_frame
from nvcore.findings import Finding, Severity
from nvcore.frame_lists import nth
from nvcore.linking import track_truth
from nvcore.params import Params
from nvcore.proximity import weigh_proximity

MIN_ENCOUNTERS: Final = 10
"""Fewer near encounters than this say little."""
RELEVANT: Final = 0.5
"""Proximity weight from which on a pedestrian is near."""


def audit_encounter_lengths(dataset: Dataset, params: Params) -> list[Finding]:
    """Most near encounters are a single evaluated frame long.

    Notes
    -----
    Proximity by a horizon that is not known cannot be judged: nothing is reported.
    """
    truth, frames = dataset.truth, dataset.frame_columns
    if params.proximity == "horizon" and params.horizon is None and np.isnan(frames.horizon).any():
        return []
    tracks = track_truth(truth, frames)
    occlusion = dataset.boxes["occlusion"].to_numpy()[: len(truth)]
    encounters = find_encounters(truth, tracks.track, occlusion, frames)
    k = weigh_proximity(truth, ~truth.ignore, frames, params).k
    near = np.unique(encounters.encounter_of[~truth.ignore & (k >= RELEVANT)])
    n_frames = encounters.n_frames[near]
    if len(near) < MIN_ENCOUNTERS or not mostly_one_frame(n_frames):
        return []
    n_short = int(np.count_nonzero(n_frames == 1))
    reasons = []
    step = int(np.median(frames.gap))
    if step > 1:
        reasons.append(f"every {nth(step)} frame is evaluated")
    if len(tracks.linked_recordings):
        reasons.append("pedestrians without track ids were linked over the frames")
    why = f" ({'; '.join(reasons)})" if reasons else ""
    return [
        Finding(
            Severity.WARNING, "short-encounters", TRUTH_NAME, n_short,
            f"{n_short:,} of {len(near):,} near encounters are one evaluated frame long{why}.",
            "Saliency, lag, gap, lead time, dropout and rates per hour mean little here, and "
            "McNemar's test counts frames rather than persons. Give ground truth with track ids in "
            "every frame, or read the figures per frame only.",
        )
    ]  # fmt: skip
