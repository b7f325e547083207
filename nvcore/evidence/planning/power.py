"""In which share of studies a difference would be shown, by simulating studies from a pilot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from scipy.special import ndtri
from scipy.stats import binomtest
from scipy.stats import t as student

from nvcore.evidence.bootstrap import CONFIDENCE, MIN_UNITS, ROUNDING, SEED
from nvcore.evidence.paired_tests import MIN_SWAPPED
from nvcore.evidence.planning.pilot import Pilot
from nvcore.progress import Progress, no_progress

N_STUDIES: Final = 300
"""Studies that are simulated at each size on the way."""
N_STUDIES_LAST: Final = 1000
"""Studies at the size that comes out: power to 2.5 percentage points."""
MOST_RECORDINGS: Final = 10_000
"""Largest study that is looked for."""
RANK: Final = 20
"""Rank at which the random ways of a simulated test reject: 399 exchanges at a level of 5 %."""
DRAWN_AT_ONCE: Final = 1_000_000
"""Exchanged recordings held in memory at a time."""
COUNTED_FROM: Final = 20
"""Times as many recordings as the pilot from which resamples are counted instead of drawn."""
WAYS_AT_ONCE: Final = 100
"""Exchanges or resamples between two looks at whether a study is decided."""
GRID: Final = (0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0)
"""Sizes that are tried first, as shares of a guess."""
WORD_BITS: Final = 64

CountShown = Callable[[int, int], int]
"""From the recordings of a study and the number of studies: how many of these show it."""


class PowerPoint(NamedTuple):
    """Share of studies of one size that show what they look for, with its Monte Carlo interval."""

    n_recordings: int
    power: float
    low: float
    high: float
    n_studies: int


class StudyLength(NamedTuple):
    """The smallest study with the power, None if more than `MOST_RECORDINGS`, and the curve."""

    n_recordings: int | None
    points: tuple[PowerPoint, ...]


def count_differences_shown(
    pilot: Pilot, difference: float, n_recordings: int, n_studies: int, *, level: float
) -> int:
    """How many simulated studies reject that X and Y are equal.

    A study draws whole recordings of the pilot with replacement, so that whatever belongs to one
    recording stays together. It rejects where both tests of recordings do, as in the table of
    evidence: the exchange of X and Y (`nvcore.evidence.paired_tests.swap_test`) and the studentised
    bootstrap.

    Parameters
    ----------
    difference
        The true difference X - Y that is assumed (`Pilot.parts_for`).
    level
        Largest p at which a study shows a difference.
    """
    parts, n = pilot.parts_for(difference), len(pilot)
    n_ways = int(np.ceil(RANK / level)) - 1
    rng = np.random.default_rng([SEED, n_recordings])
    drawn = rng.multinomial(n_recordings, np.full(n, 1 / n), size=n_studies)
    drawn = drawn[drawn @ pilot.differs.astype(np.int64) >= MIN_SWAPPED]
    total = np.abs(drawn @ parts) - ROUNDING * np.abs(drawn * parts).sum(axis=1)

    def count_exchanges(studies: np.ndarray, n_ways: int) -> np.ndarray:
        drawn_now = drawn[studies]
        own = (drawn_now @ parts)[:, np.newaxis]
        sums = own - 2 * _exchange(rng, drawn_now, n_ways) @ parts
        return np.count_nonzero(np.abs(sums) >= total[studies, np.newaxis], axis=1)

    drawn = drawn[_are_few_reached(count_exchanges, len(drawn), n, n_ways=n_ways, share=level)]
    ratio = (drawn @ parts) / np.maximum(drawn @ pilot.weights, 1e-300)
    values = np.sign(ratio)[:, np.newaxis] * (parts - ratio[:, np.newaxis] * pilot.weights)
    spread = np.sqrt((drawn * values**2).sum(axis=1) / n_recordings)
    with np.errstate(invalid="ignore", divide="ignore"):
        observed = np.abs(drawn @ parts) / n_recordings / spread

    def count_resamples(studies: np.ndarray, n_ways: int) -> np.ndarray:
        mean, mean_square = (
            moment / n_recordings
            for moment in _resample(rng, drawn[studies], values[studies], n_recordings, n_ways)
        )
        spreads = np.sqrt(np.maximum(mean_square - mean**2, 0))
        spreads = np.maximum(spreads, 1e-12 * spread[studies, np.newaxis])
        return np.count_nonzero(mean >= observed[studies, np.newaxis] * spreads, axis=1)

    size = max(n, n_recordings)
    is_shown = _are_few_reached(count_resamples, len(drawn), size, n_ways=n_ways, share=level / 2)
    return int(np.count_nonzero(is_shown))


def _are_few_reached(
    count: Callable[[np.ndarray, int], np.ndarray],
    n_studies: int,
    size: int,
    *,
    n_ways: int,
    share: float,
) -> np.ndarray:
    """Of which studies at most this share of random ways reaches what was found; bool.

    Parameters
    ----------
    count
        From studies and a number of random ways: how many of these reach it, in each study.
    size
        Numbers held in memory for each study and way.
    """
    most = int(share * (n_ways + 1) * (1 + 1e-12)) - 1
    n_reached = np.zeros(n_studies, dtype=np.int64)
    batch = max(1, DRAWN_AT_ONCE // (WAYS_AT_ONCE * size))
    for first in range(0, n_studies, batch):
        open_studies = np.arange(first, min(first + batch, n_studies))
        for start in range(0, n_ways, WAYS_AT_ONCE):
            n_reached[open_studies] += count(open_studies, min(WAYS_AT_ONCE, n_ways - start))
            # a study that has too many already is decided
            open_studies = open_studies[n_reached[open_studies] <= most]
            if not len(open_studies):
                break
    is_few: np.ndarray = n_reached <= most
    return is_few


def _exchange(rng: np.random.Generator, drawn: np.ndarray, n_exchanges: int) -> np.ndarray:
    """Binomial(drawn, 1/2), `n_exchanges` times: bits of random words that are set.

    Shape (n_studies, n) to (n_studies, n_exchanges, n).
    """
    shape = (len(drawn), n_exchanges, drawn.shape[1])
    exchanged = np.zeros(shape)
    left = drawn.astype(np.int64)
    while left.any():
        n_bits = np.minimum(left, WORD_BITS).astype(np.uint64)
        # a shift by all 64 bits is undefined
        mask = np.where(
            n_bits == WORD_BITS,
            np.uint64(2**64 - 1),
            (np.uint64(1) << (n_bits % np.uint64(WORD_BITS))) - np.uint64(1),
        )
        words = rng.integers(0, 2**64 - 1, size=shape, dtype=np.uint64, endpoint=True)
        exchanged += np.bitwise_count(words & mask[:, np.newaxis, :])
        left = np.maximum(left - WORD_BITS, 0)
    return exchanged


def _resample(
    rng: np.random.Generator, drawn: np.ndarray, values: np.ndarray, n_recordings: int, n_ways: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sums of the values, and of their squares, of recordings drawn again from each study.

    Shapes (n_studies, n) to (n_studies, n_ways).
    """
    n_studies, n = drawn.shape
    if n_recordings > COUNTED_FROM * n:  # counting is faster than drawing
        shares = drawn[:, np.newaxis] / n_recordings
        again = rng.multinomial(n_recordings, shares, size=(n_studies, n_ways)).astype(float)
        by_square = np.matmul(again, (values**2)[..., np.newaxis])[..., 0]
        return np.matmul(again, values[..., np.newaxis])[..., 0], by_square
    of_studies = np.repeat(values.ravel(), drawn.ravel())  # n_recordings of each study
    again = rng.integers(0, n_recordings, size=(n_studies, n_ways, n_recordings), dtype=np.uint16)
    start = n_recordings * np.arange(n_studies)
    chosen = of_studies[again + start[:, np.newaxis, np.newaxis]]
    return chosen.sum(axis=2), np.einsum("swr,swr->sw", chosen, chosen)


def count_noninferior(
    pilot: Pilot, difference: float, n_recordings: int, n_studies: int, *, margin: float, sign: int
) -> int:
    """How many simulated studies show that the candidate is worse by less than the margin.

    Studies are drawn as in `count_differences_shown`. Each study's 95 % interval is Student's of
    the ratio of sums, which the widened bootstrap interval of the evidence comes close to.

    Parameters
    ----------
    margin
        Of the measure, positive.
    sign
        1 if a positive difference X - Y favours the candidate, else -1.
    """
    parts, weights, n = pilot.parts_for(difference), pilot.weights, len(pilot)
    rng = np.random.default_rng([SEED, n_recordings])
    drawn = rng.multinomial(n_recordings, np.full(n, 1 / n), size=n_studies)
    with np.errstate(invalid="ignore", divide="ignore"):
        total = drawn @ weights
        ratio = drawn @ parts / total
        rest = parts - ratio[:, np.newaxis] * weights
        variance = n_recordings / (n_recordings - 1) * (drawn * rest**2).sum(axis=1)
        reach = student.isf((1 - CONFIDENCE) / 2, n_recordings - 1) * np.sqrt(variance) / total
        is_shown = sign * ratio - reach > -margin
    return int(np.count_nonzero(is_shown))


def find_length(
    count: CountShown,
    *,
    guess: float,
    least: int,
    target: float,
    progress: Progress = no_progress,
) -> StudyLength:
    """The smallest study in which a share `target` of studies shows what it looks for.

    Studies of several sizes about the guess are simulated; a line through the normal quantiles of
    their power over the square root of the size, which is what the power of a mean follows,
    smooths them. The size at which it reaches the target is simulated again, with more studies.

    Parameters
    ----------
    least
        Fewest recordings with which anything can be shown.
    """
    points: dict[int, PowerPoint] = {}

    def simulate(n_recordings: int, n_studies: int = N_STUDIES) -> float:
        progress(min(len(points) / (len(GRID) + 3), 0.95), f"studies of {n_recordings} recordings")
        n_shown = count(n_recordings, n_studies)
        ends = binomtest(n_shown, n_studies).proportion_ci(CONFIDENCE, method="wilson")
        points[n_recordings] = PowerPoint(
            n_recordings, n_shown / n_studies, float(ends.low), float(ends.high), n_studies
        )
        return n_shown / n_studies

    middle = min(max(guess, least), MOST_RECORDINGS / GRID[-1])
    for size in sorted({max(least, round(share * middle)) for share in GRID}):
        simulate(size)
    while points[max(points)].power < target and max(points) < MOST_RECORDINGS:
        simulate(min(2 * max(points), MOST_RECORDINGS))
    while points[min(points)].power >= target and min(points) > least:
        simulate(max(min(points) // 2, least))
    if points[max(points)].power < target:
        return StudyLength(None, _in_order(points))
    n_recordings = _length_at(points, target, least)
    simulate(n_recordings, N_STUDIES_LAST)
    better = _length_at(points, target, least)
    if better != n_recordings:
        n_recordings = better
        simulate(n_recordings, N_STUDIES_LAST)
    return StudyLength(n_recordings, _in_order(points))


def _in_order(points: dict[int, PowerPoint]) -> tuple[PowerPoint, ...]:
    return tuple(points[n] for n in sorted(points))


def _length_at(points: dict[int, PowerPoint], target: float, least: int) -> int:
    """Where the smoothed curve of power reaches the target."""
    sizes = np.array(sorted(points))
    rows = [points[n] for n in sizes]
    if rows[0].power >= target:
        return int(sizes[0])
    n_studies = np.array([row.n_studies for row in rows], dtype=float)
    power = np.array([row.power for row in rows])
    power = np.clip(power, 0.5 / n_studies, 1 - 0.5 / n_studies)
    quantile = ndtri(power)
    density = np.exp(-(quantile**2) / 2)
    # the variance of a share as its normal quantile; far from the target the line is none
    weight = np.sqrt(n_studies * density**2 / (power * (1 - power)))
    weight *= np.exp(-((quantile - ndtri(target)) ** 2) / 2)
    slope, start = np.polyfit(np.sqrt(sizes), quantile, 1, w=weight)
    above = sizes[[row.power >= target for row in rows]][0]
    if slope <= 0:
        return int(above)
    root = (ndtri(target) - start) / slope
    size = int(np.ceil(max(root, 0.0) ** 2))
    return int(np.clip(size, least, 2 * above))


def guess_length(pilot: Pilot, distance: float, *, level: float, target: float) -> float:
    """Recordings for the power if the mean were normal: ``((z_level + z_power) * sd / d)^2``."""
    quantiles = ndtri(1 - level / 2) + ndtri(target)
    return float((quantiles * pilot.spread / distance) ** 2)


LEAST_TESTED: Final = MIN_SWAPPED
"""Fewest recordings of a study that tests a difference."""
LEAST_WITH_INTERVAL: Final = MIN_UNITS
"""Fewest recordings of a study that has an interval."""
