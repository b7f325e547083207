"""Simulated ratings of the sample recordings. No person rated them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import compare
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.ratings.validation import clip_saliency

N_PARTICIPANTS: Final = 16
LOW: Final = 1
HIGH: Final = 7
MISSING_SHARE: Final = 0.03
TASTE: Final = 0.6
"""Noise of one rating, as a share of the clips' spread in annoyance."""
UNEXPLAINED: Final = 0.35
"""Shared annoyance not explained by saliency, as a share of that spread."""
CONTRARY: Final = 11
"""Number of the participant who inverts the scale."""
SEED: Final = 360
HABIT: Final[dict[str, Any]] = {"recency_midpoint": 0.25, "recency_spread": 0.2, "tolerance": 0.1}
"""Saliency settings of the simulated participants. They differ from the defaults, so that a fit has
something to find.
"""


def simulate_ratings(session_file: Path) -> pd.DataFrame:
    """Simulate ratings of every recording with the boxes of each system, the same on every call.

    Each participant rates the logarithm of an annoyance that follows saliency with other settings
    than the default ones, with individual level, width and noise. Some ratings are missing, and one
    participant inverts the scale.

    Returns
    -------
    Columns participant, clip, system, rating (1..7, 7 is most annoying, NaN missing).
    """
    dataset = load(read_session(session_file))
    result = compare(dataset, replace(dataset.params_of(), **HABIT))
    clips = clip_saliency(result)
    annoyance = np.log1p(clips["saliency_s"].to_numpy())
    annoyance = (annoyance - annoyance.mean()) / annoyance.std()
    rng = np.random.default_rng(SEED)
    annoyance += rng.normal(0, UNEXPLAINED, len(annoyance))
    rows = []
    for number in range(N_PARTICIPANTS):  # over participants
        level, width = rng.normal(4, 0.5), rng.uniform(1.0, 1.8)
        felt = annoyance + rng.normal(0, TASTE, len(annoyance))
        if number == CONTRARY:
            felt = -felt
        rating = np.clip(np.round(level + width * felt), LOW, HIGH)
        rating[rng.random(len(rating)) < MISSING_SHARE] = np.nan
        participant = f"P{number + 1:02d}"
        rows.append(clips[["clip", "system"]].assign(participant=participant, rating=rating))
    table = pd.concat(rows, ignore_index=True)
    return table[["participant", "clip", "system", "rating"]]


def ratings_text(table: pd.DataFrame) -> str:
    """Return ratings as CSV, missing ones empty, with equal bytes on every system."""
    whole = table.assign(rating=table["rating"].astype("Int64"))
    return str(whole.to_csv(index=False, lineterminator="\n"))
