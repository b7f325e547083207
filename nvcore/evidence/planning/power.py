"""Power: the share of studies that would show a difference, simulated from a pilot."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
import scipy

from nvcore.common.progress import Progress, no_progress
from nvcore.evidence.bootstrap import CONFIDENCE, LEAST_SPREAD, ROUNDING, SEED
from nvcore.evidence.paired_tests import MIN_SWAPPED
from nvcore.evidence.planning.pilot import Pilot
from nvcore.evidence.planning.thresholds import Curve, parts_at_equal_alarms
from nvcore.metrics.shares import share_of

N_STUDIES: Final = 300
"""Number of studies simulated at each intermediate size."""
N_STUDIES_LAST: Final = 2000
"""Number of studies simulated at the final size, which gives power to 2 percentage points."""
N_STUDIES_ROUGH: Final = 100
"""Number of studies simulated at each size for `rough_length`."""
ROUGH_POWER: Final = (0.5 / N_STUDIES_ROUGH, 1 - 0.5 / N_STUDIES_ROUGH)
"""Limits of a rough power, as its normal quantile is infinite at 0 and 1."""
ROUGH_STEPS: Final = 5
"""Most sizes that `rough_length` tries."""
ROUGH_GAP: Final = 0.07
"""Share of a size by which the next one differs if `rough_length` is close enough."""
MOST_RECORDINGS: Final = 10_000
"""Largest study size considered."""
RANK: Final = 10
"""Rank at which a simulated random test rejects at least, so that p-values of studies are accurate
to a third near the decision."""
LEAST_WAYS: Final = 399
"""Fewest exchanges or resamples of a simulated test; rank 20 at a level of 5 %."""
DRAWN_AT_ONCE: Final = 1_000_000
"""Exchanged recordings held in memory at a time."""
ROUGHLY: Final = 0.015
"""Share by which a size may be off, since it is not known more precisely."""
EXPANDED_FROM: Final = 40
"""Number of recordings from which p of both tests is computed by expansions. In simulated studies,
normal to lognormal, the studentised bootstrap and its expansion then agree in 95 to 100 %."""
LEAST_PARTS: Final = 20
"""Fewest relevant parts for the expansion of the exchange test."""
CONSTANT: Final = 1e-9
"""Largest spread, as a share of the mean, of recordings that vary only by rounding."""
WAYS_AT_ONCE: Final = 100
"""Exchanges or resamples between two checks whether a study is decided."""
GRID: Final = (0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0)
"""Sizes that are tried first, as multiples of a guess."""
WORD_BITS: Final = 64

CountShown = Callable[[int, int], int]
"""Function from the recordings of a study and the number of studies to the number that show it."""


class PowerPoint(NamedTuple):
    """Share of studies of one size that succeed, with its Monte Carlo interval."""

    n_recordings: int
    power: float
    low: float
    high: float
    n_studies: int


class StudyLength(NamedTuple):
    """Smallest study with the desired power (None above `MOST_RECORDINGS`), and the power curve."""

    n_recordings: int | None
    points: tuple[PowerPoint, ...]


def count_differences_shown(
    pilot: Pilot,
    difference: float,
    n_recordings: int,
    n_studies: int,
    *,
    level: float,
    is_rough: bool = False,
) -> int:
    """Count simulated studies that claim a difference in favour of the assumed better system.

    A study draws whole recordings of the pilot with replacement, which keeps all data of a
    recording together. It claims a difference as the verdict does: if both tests of recordings
    reject at equal false alarms, and also as set, unless X and Y are set unequally. If no threshold
    can move, the better system must not have more false alarms.

    Parameters
    ----------
    difference
        Assumed true difference X - Y (`Pilot.parts_for`); with 0, claims for either system count.
    level
        Largest p at which a study shows a difference.
    is_rough
        Compute p of both tests by expansions, however few the recordings.
    """
    n = len(pilot)
    rng = np.random.default_rng([SEED, n_recordings])
    drawn = rng.multinomial(n_recordings, np.full(n, 1 / n), size=n_studies)
    drawn = drawn[drawn @ pilot.differs.astype(np.int64) >= MIN_SWAPPED]
    better_in = partial(_better, rng, weights=pilot.weights, level=level, is_rough=is_rough)
    if pilot.thresholds is None:
        return _count_claims(better_in(drawn, pilot.parts_for(difference)), difference)
    thresholds = pilot.thresholds.change(partial(Curve.widened, factor=pilot.widening))
    x, y = thresholds.as_set
    as_set = x.parts[0] - y.parts[0]
    of_all, is_unequal, more = parts_at_equal_alarms(thresholds, drawn)
    missing = pilot.missing(difference)
    is_open = np.isfinite(of_all).all(axis=1)
    at_equal = np.zeros(len(drawn))
    at_equal[is_open] = better_in(drawn[is_open], of_all[is_open] + missing)
    better = better_in(drawn, as_set + missing)
    closed = np.where(is_unequal | (pilot.sign * better == more), 0, better)
    both = np.where(is_unequal, at_equal, np.where(better == at_equal, better, 0))
    return _count_claims(np.where(is_open, both, closed), difference)


def _count_claims(better: np.ndarray, difference: float) -> int:
    is_meant = better * np.sign(difference) > 0 if difference else better != 0
    return int(np.count_nonzero(is_meant))


def _better(
    rng: np.random.Generator,
    drawn: np.ndarray,
    parts: np.ndarray,
    *,
    weights: np.ndarray,
    level: float,
    is_rough: bool,
) -> np.ndarray:
    """Return the sign of the difference that both tests show in each study, 0 if none.

    As in the table of evidence, the tests are the exchange of X and Y
    (`nvcore.evidence.paired_tests.swap_test`) and the studentised bootstrap.

    Parameters
    ----------
    parts
        Parts of the recordings, shape (n_recordings,), or by study, (n_studies, n_recordings).
    """
    parts = np.broadcast_to(parts, drawn.shape)
    better = np.zeros(len(drawn))
    if not len(drawn):
        return better
    n_recordings = int(drawn[0].sum())
    n_ways = max(int(np.ceil(RANK / level)) - 1, LEAST_WAYS)
    ways: dict[str, Any] = {"n_ways": n_ways, "level": level}
    is_expanded = is_rough or n_recordings >= EXPANDED_FROM
    if not is_expanded:
        rejected = _reject_by_exchange(rng, drawn, parts, **ways)
    else:
        p, is_close = exchange_p(drawn, parts)
        rejected = p <= level
        if not is_rough:
            far = drawn[~is_close], parts[~is_close]
            rejected[~is_close] = _reject_by_exchange(rng, *far, **ways)
    rows = np.flatnonzero(rejected)
    drawn, parts = drawn[rows], parts[rows]
    total = (drawn * parts).sum(axis=1)
    ratio = total / np.maximum(drawn @ weights, 1e-300)
    # each study's parts about its own mean, which is on the positive side
    values = np.sign(ratio)[:, np.newaxis] * (parts - ratio[:, np.newaxis] * weights)
    means = np.abs(total) / n_recordings
    spreads = np.sqrt((drawn * values**2).sum(axis=1) / n_recordings)
    # without variation between recordings there is no studentised test, so the exchange decides
    is_shown = spreads <= CONSTANT * means
    varies = ~is_shown
    if not is_expanded:
        is_shown[varies] = _reject_by_resampling(
            rng, drawn[varies], values[varies], means[varies], **ways
        )
    else:
        tail = studentised_tail(drawn[varies], values[varies], means[varies])
        is_shown[varies] = tail <= level / 2
    better[rows[is_shown]] = np.sign(ratio[is_shown])
    return better


def _reject_by_exchange(
    rng: np.random.Generator, drawn: np.ndarray, parts: np.ndarray, *, n_ways: int, level: float
) -> np.ndarray:
    """Return which studies the exchange test rejects at this level, bool, shape (n_studies,)."""
    totals = (drawn * parts).sum(axis=1)
    least = np.abs(totals) - ROUNDING * np.abs(drawn * parts).sum(axis=1)

    def is_reached(studies: np.ndarray, n_now: int) -> np.ndarray:
        exchanged = np.einsum("swr,sr->sw", _exchange(rng, drawn[studies], n_now), parts[studies])
        sums = np.abs(totals[studies, np.newaxis] - 2 * exchanged)
        is_beyond: np.ndarray = sums >= least[studies, np.newaxis]
        return is_beyond

    return _are_few_reached(is_reached, len(drawn), drawn.shape[1], n_ways=n_ways, share=level)


def exchange_p(drawn: np.ndarray, parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the two-sided p of the exchange test by expansion, and where the expansion is close.

    After an exchange, a study's difference is a sum of its parts with random signs, which is
    symmetrical. The expansion is close unless a few parts make up most of that sum.

    Parameters
    ----------
    drawn
        How often each study has drawn each recording; shape (n_studies, n).
    parts
        Parts of the recordings, shape (n,), or by study, (n_studies, n).
    """
    squares = parts**2
    square, fourth = (drawn * squares).sum(axis=1), (drawn * squares**2).sum(axis=1)
    scale = np.maximum(square, 1e-300)
    t = np.abs((drawn * parts).sum(axis=1)) / np.sqrt(scale)
    share = fourth / scale**2  # 1 over the number of parts that matter
    density = np.exp(-(t**2) / 2) / np.sqrt(2 * np.pi)
    p: np.ndarray = 2 * (scipy.special.ndtr(-t) - density * share * (t**3 - 3 * t) / 12)
    return p, share * LEAST_PARTS <= 1


def _reject_by_resampling(
    rng: np.random.Generator,
    drawn: np.ndarray,
    values: np.ndarray,
    means: np.ndarray,
    *,
    n_ways: int,
    level: float,
) -> np.ndarray:
    """Return which studies the studentised bootstrap rejects at this level, bool, (n_studies,)."""
    if not len(drawn):
        return np.zeros(0, dtype=bool)
    n_recordings = int(drawn[0].sum())
    # every recording of every study
    each = np.repeat(values.ravel(), drawn.ravel()).reshape(len(drawn), n_recordings)
    spread = each.std(axis=1)
    observed = means / spread

    def is_reached(studies: np.ndarray, n_now: int) -> np.ndarray:
        shape = (len(studies), n_now, n_recordings)
        again = rng.integers(0, n_recordings, size=shape, dtype=np.uint16)
        start = n_recordings * np.arange(len(studies))[:, np.newaxis, np.newaxis]
        chosen = each[studies].ravel()[again + start]
        mean = chosen.mean(axis=2)
        square = np.einsum("swr,swr->sw", chosen, chosen) / n_recordings
        spreads = np.sqrt(np.maximum(square - mean**2, 0))
        spreads = np.maximum(spreads, LEAST_SPREAD * spread[studies, np.newaxis])
        is_beyond: np.ndarray = mean >= observed[studies, np.newaxis] * spreads
        return is_beyond

    return _are_few_reached(is_reached, len(drawn), n_recordings, n_ways=n_ways, share=level / 2)


def studentised_tail(drawn: np.ndarray, values: np.ndarray, means: np.ndarray) -> np.ndarray:
    """Return the one-sided p of the studentised bootstrap by its second-order expansion.

    Parameters
    ----------
    drawn
        How often each study has drawn each recording; shape (n_studies, n).
    values
        Parts of the recordings minus the study's mean, in the same shape.
    means
        Tested means, positive; shape (n_studies,).

    References
    ----------
    Hall (1992), The bootstrap and Edgeworth expansion, section 2.6.
    """
    n = drawn.sum(axis=1)
    squares = values**2  # other powers are slow
    square, cube, fourth = (
        (drawn * of).sum(axis=1) / n for of in (squares, squares * values, squares**2)
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        skew, kurtosis = cube / square**1.5, fourth / square**2 - 3
        t = np.sqrt(n) * means / np.sqrt(square)
        density = np.exp(-(t**2) / 2) / np.sqrt(2 * np.pi)
        first = skew * (2 * t**2 + 1) / 6
        second = t * (
            kurtosis * (t**2 - 3) / 12 - skew**2 * (t**4 + 2 * t**2 - 3) / 18 - (t**2 + 3) / 4
        )
        tail: np.ndarray = scipy.special.ndtr(-t) - density * (first / np.sqrt(n) + second / n)
    return tail


def _are_few_reached(
    is_reached: Callable[[np.ndarray, int], np.ndarray],
    n_studies: int,
    size: int,
    *,
    n_ways: int,
    share: float,
) -> np.ndarray:
    """Return the studies in which at most this share of random ways reaches the observed value.

    Parameters
    ----------
    is_reached
        Function of studies and a number of random ways, returning which ways reach it in each
        study.
    size
        Numbers held in memory for each study and way.
    """
    most = int(share * (n_ways + 1) * (1 + 1e-12)) - 1
    n_reached = np.zeros(n_studies, dtype=np.int64)
    batch = max(1, DRAWN_AT_ONCE // (WAYS_AT_ONCE * size))
    for first in range(0, n_studies, batch):
        open_studies = np.arange(first, min(first + batch, n_studies))
        for start in range(0, n_ways, WAYS_AT_ONCE):
            is_now = is_reached(open_studies, min(WAYS_AT_ONCE, n_ways - start))
            n_reached[open_studies] += np.count_nonzero(is_now, axis=1)
            # a study that has too many already is decided
            open_studies = open_studies[n_reached[open_studies] <= most]
            if not len(open_studies):
                break
    is_few: np.ndarray = n_reached <= most
    return is_few


def _exchange(rng: np.random.Generator, drawn: np.ndarray, n_exchanges: int) -> np.ndarray:
    """Draw from Binomial(drawn, 1/2) `n_exchanges` times, as the set bits of random words.

    Shape (n_studies, n) to (n_studies, n_exchanges, n).
    """
    shape = (len(drawn), n_exchanges, drawn.shape[1])
    exchanged = np.zeros(shape)
    left = drawn.astype(np.int64)
    while left.any():
        n_bits = np.minimum(left, WORD_BITS).astype(np.uint64)
        mask = ~(np.uint64(2**64 - 1) << n_bits)  # NumPy shifts all 64 bits out, too
        words = rng.integers(0, 2**64 - 1, size=shape, dtype=np.uint64, endpoint=True)
        exchanged += np.bitwise_count(words & mask[:, np.newaxis, :])
        left = np.maximum(left - WORD_BITS, 0)
    return exchanged


def count_noninferior(
    pilot: Pilot, difference: float, n_recordings: int, n_studies: int, *, margin: float, sign: int
) -> int:
    """Count simulated studies that show that the candidate is worse by less than the margin.

    Studies are drawn as in `count_differences_shown`, at equal false alarms if the pilot has
    thresholds. Each study's 95 % interval is Student's for the ratio of sums, which is close to the
    widened bootstrap interval of the evidence.

    Parameters
    ----------
    margin
        Margin of the measure, positive.
    sign
        1 if a positive difference X - Y favours the candidate, else -1.
    """
    parts, weights, n = pilot.parts_for(difference), pilot.weights, len(pilot)
    rng = np.random.default_rng([SEED, n_recordings])
    drawn = rng.multinomial(n_recordings, np.full(n, 1 / n), size=n_studies)
    with np.errstate(invalid="ignore", divide="ignore"):
        if pilot.thresholds is not None:
            widened = pilot.thresholds.change(partial(Curve.widened, factor=pilot.widening))
            of_all, *_ = parts_at_equal_alarms(widened, drawn)
            parts = of_all + pilot.missing(difference)
        total = drawn @ weights
        ratio = (drawn * parts).sum(axis=1) / total
        rest = parts - ratio[:, np.newaxis] * weights
        variance = n_recordings / (n_recordings - 1) * (drawn * rest**2).sum(axis=1)
        reach = (
            -scipy.special.stdtrit(n_recordings - 1, (1 - CONFIDENCE) / 2)
            * np.sqrt(variance)
            / total
        )
        is_shown = sign * ratio - reach > -margin
    return int(np.count_nonzero(is_shown))


def find_length(
    count: CountShown, *, guess: float, least: int, target: float, progress: Progress = no_progress
) -> StudyLength:
    """Find the smallest study size at which a share `target` of studies succeeds.

    Studies of several sizes around the guess are simulated and smoothed by a line through the
    normal quantiles of their power over the square root of the size, which is the form of the power
    of a mean. The size at which the line reaches the target is simulated again with more studies.
    The result is the first such size whose own power reaches the target.

    Parameters
    ----------
    least
        Fewest recordings with which anything can be shown.
    """
    points: dict[int, PowerPoint] = {}

    def simulate(n_recordings: int, n_studies: int = N_STUDIES) -> None:
        progress(min(len(points) / (len(GRID) + 3), 0.95), f"studies of {n_recordings} recordings")
        shown = share_of(count(n_recordings, n_studies), n_studies)
        of_study = (shown.share, shown.low, shown.high, n_studies)
        points[n_recordings] = PowerPoint(n_recordings, *of_study)

    def found(n_recordings: int | None) -> StudyLength:
        return StudyLength(n_recordings, tuple(points[n] for n in sorted(points)))

    middle = min(max(guess, least), MOST_RECORDINGS / GRID[-1])
    for size in sorted({max(least, round(share * middle)) for share in GRID}):
        simulate(size)
    while points[min(points)].power >= target and min(points) > least:
        simulate(max(min(points) // 2, least))
    n_recordings = 0
    # with more studies, the only size that reached the target may fall below it; then continue
    while not n_recordings or all(point.power < target for point in points.values()):
        while points[max(points)].power < target and max(points) < MOST_RECORDINGS:
            simulate(min(2 * max(points), MOST_RECORDINGS))
        if points[max(points)].power < target:
            return found(None)
        n_recordings = _length_at(points, target, least)
        simulate(n_recordings, N_STUDIES_LAST)
    better = _length_at(points, target, least)
    if abs(better - n_recordings) > ROUGHLY * n_recordings:
        n_recordings = better
        simulate(n_recordings, N_STUDIES_LAST)
    while points[n_recordings].power < target and n_recordings < MOST_RECORDINGS:
        n_recordings = min(n_recordings + max(1, round(ROUGHLY * n_recordings)), MOST_RECORDINGS)
        simulate(n_recordings, N_STUDIES_LAST)
    if points[n_recordings].power < target:
        return found(None)
    # an intermediate size may also reach it with its fewer studies, by luck or truly
    while points[first := min(n for n in points if points[n].power >= target)].n_studies < (
        N_STUDIES_LAST
    ):
        simulate(first, N_STUDIES_LAST)
    return found(first)


def _length_at(points: dict[int, PowerPoint], target: float, least: int) -> int:
    """Return the size at which the smoothed power curve reaches the target."""
    sizes = np.array(sorted(points))
    rows = [points[n] for n in sizes]
    if rows[0].power >= target:
        return int(sizes[0])
    n_studies = np.array([row.n_studies for row in rows], dtype=float)
    power = np.array([row.power for row in rows])
    power = np.clip(power, 0.5 / n_studies, 1 - 0.5 / n_studies)
    quantile = scipy.special.ndtri(power)
    density = np.exp(-(quantile**2) / 2)
    # variance of a share as its normal quantile; far from the target the curve is not a line
    weight = np.sqrt(n_studies * density**2 / (power * (1 - power)))
    weight *= np.exp(-((quantile - scipy.special.ndtri(target)) ** 2) / 2)
    slope, start = np.polyfit(np.sqrt(sizes), quantile, 1, w=weight)
    above = sizes[[row.power >= target for row in rows]][0]
    if slope <= 0:
        return int(above)
    root = (scipy.special.ndtri(target) - start) / slope
    size = int(np.ceil(max(root, 0.0) ** 2))
    return int(np.clip(size, least, min(2 * above, MOST_RECORDINGS)))


def rough_length(
    count: CountShown, *, guess: float, least: int, level: float, target: float, most: float
) -> float:
    """Return about the size that `find_length` finds, at a hundredth of its cost.

    The normal quantile of the power is taken as linear in the square root of the size, from that of
    half the level at size 0. The result is infinite if it is larger than `most`.
    """
    zero, sought = (float(scipy.special.ndtri(share)) for share in (level / 2, target))
    size = guess
    for _ in range(ROUGH_STEPS):
        n = int(np.clip(round(size), least, most))
        power = np.clip(count(n, N_STUDIES_ROUGH) / N_STUDIES_ROUGH, *ROUGH_POWER)
        rise = max(float(scipy.special.ndtri(power)) - zero, (sought - zero) / 2)
        size = n * ((sought - zero) / rise) ** 2
        if abs(size - n) <= ROUGH_GAP * n:
            break
    return np.inf if size > most else max(size, least)


def guess_length(pilot: Pilot, distance: float, *, level: float, target: float) -> float:
    """Return the recordings needed for a normal mean: ``((z_level + z_power) * sd / d)^2``."""
    quantiles = scipy.special.ndtri(1 - level / 2) + scipy.special.ndtri(target)
    return float((quantiles * pilot.spread / distance) ** 2)
