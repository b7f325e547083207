"""Range of the study sizes that repeated pilots would plan."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
import scipy

from nvcore.evidence.bootstrap import SEED
from nvcore.evidence.planning.pilot import Pilot
from nvcore.evidence.planning.power import MOST_RECORDINGS, CountShown, rough_length

N_PILOTS: Final = 80
"""Number of repeated pilots."""
RANGE_SHARE: Final = 0.8
"""Share of repeated pilots whose study sizes are in the range."""
WIDEST: Final = 10
"""Largest ratio of the range's ends with which a pilot says something."""


def find_range(
    count_for: Callable[[Pilot], CountShown],
    pilot: Pilot,
    n_recordings: int,
    *,
    least: int,
    level: float,
    target: float,
) -> tuple[int, int] | None:
    """Return the range of sizes that 80 % of repeated pilots would plan, None if it says nothing.

    Repeated pilots draw as many recordings from these, with replacement, so that spread, ratio of
    false alarms and thresholds differ. Their sizes are computed roughly, relative to that of this
    pilot. The range is at least the one of normal differences, whose variances in two pilots of
    equal size have a ratio with an F distribution: a few recordings do not know what they have not
    seen. If the range's ends differ more than tenfold, it says nothing.

    Parameters
    ----------
    count_for
        Function from a pilot to the function that counts its studies, roughly.
    n_recordings
        Size found for this pilot.
    least, level, target
        See `nvcore.evidence.planning.power.rough_length`.
    """

    def plan(of: Pilot) -> float:
        if not math.isfinite(of.difference) or of.is_constant:
            return math.inf
        return rough_length(
            count_for(of),
            guess=n_recordings,
            least=least,
            level=level,
            target=target,
            most=WIDEST * MOST_RECORDINGS,
        )

    own = plan(pilot)
    if not math.isfinite(own):
        return None
    tails = (1 - RANGE_SHARE) / 2, (1 + RANGE_SHARE) / 2
    sizes = [plan(of) for of in pilot.repeated(np.random.default_rng(SEED), N_PILOTS)]
    low, high = np.quantile(sizes, tails, method="inverted_cdf") / own
    normal = scipy.special.fdtri(len(pilot) - 1, len(pilot) - 1, tails)
    low, high = n_recordings * min(low, normal[0]), n_recordings * max(high, normal[1])
    low = max(math.floor(low), least)
    return (low, math.ceil(high)) if high <= WIDEST * low else None
