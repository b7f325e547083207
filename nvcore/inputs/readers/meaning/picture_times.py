"""Times in names of pictures, and the frame numbers that follow from them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

LEAST_TIME: Final = 10**9
"""Whole numbers from ten digits on are times rather than frames."""
LEAST_STEP: Final = 4
"""Usual step from which on shorter numbers can be times: milliseconds at 250 Hz."""
_SECONDS = re.compile(
    r"(?P<prefix>.*?)(?<!\d)(?P<whole>[1-9]\d{9})(?P<sign>[._\-])(?P<part>\d{3,9})$"
)
_TICKS = re.compile(r"(?P<prefix>.*?)(?<!\d)0*(?P<whole>[1-9]\d{9,18})$")
_SHORT_TICKS = re.compile(r"(?P<prefix>.*?)(?P<whole>\d{1,18})$")
_DATE = re.compile(
    r"(?P<prefix>.*?)(?<!\d)(?P<year>(?:19|20)\d\d)[-_.]?(?P<month>\d\d)[-_.]?(?P<day>\d\d)"
    r"[-_.T ]*(?P<hour>\d\d)[-_.:h]?(?P<minute>\d\d)[-_.:m]?(?P<second>\d\d)"
    r"(?:[-_.,s]?(?P<part>\d{1,9}))?Z?$"
)
_UNITS: Final = {"seconds": 10**9, "milliseconds": 10**6, "microseconds": 10**3, "nanoseconds": 1}
"""Nanoseconds of each."""
_EPOCH: Final = (10**9, 22 * 10**8)
"""Seconds since 1970 of the years 2001 to 2039."""
RATES: Final = (0.05, 300.0)
"""Pictures per second that a camera takes."""
_USUAL_RATES: Final = np.array([*range(1, 301), 7.5, 12.5, 23.976, 29.97, 59.94, 119.88])
_SNAP: Final = 0.005
_JITTER: Final = 0.3
"""How far steps between pictures may differ from whole periods, in periods ..."""
_EVEN_SHARE: Final = 0.9
"""... for this share of them."""
_NEAR_STEPS: Final = 3
"""Periods up to which steps are held against the period: in longer gaps its error adds up."""


@dataclass(frozen=True)
class NamedTimes:
    """Times of pictures by their names.

    Attributes
    ----------
    prefix
        What stands before the time in each name.
    ns
        Nanoseconds, int64, shape (n,); from 1970 or from any other moment.
    unit
        In words, what the numbers are: "milliseconds".
    """

    prefix: list[str]
    ns: np.ndarray
    unit: str


def times_in(stems: Sequence[str], *, is_stated: bool = False) -> NamedTimes | None:
    """The times that all the names end in; None: they do not, or no camera takes pictures so.

    Numbers of fewer than ten digits are times only where somebody says so (`is_stated`).

    Examples
    --------
    >>> times = times_in(["a_1598000000123", "a_1598000000223", "a_1598000000323"])
    >>> times.prefix[0], np.diff(times.ns).tolist(), times.unit
    ('a_', [100000000, 100000000], 'milliseconds')
    """
    ways = ((_SECONDS, _of_seconds), (_TICKS, _of_ticks), (_DATE, _of_dates))
    for pattern, read in (*ways, *[(_SHORT_TICKS, _of_ticks)] * is_stated):
        matches = _all_matches(pattern, stems)
        times = read(matches, [match["prefix"] for match in matches]) if matches else None
        if times is not None:
            return times
    return None


def _all_matches(pattern: re.Pattern[str], stems: Sequence[str]) -> list[re.Match[str]]:
    """The match of every stem; none where one does not match."""
    matches = []
    for stem in stems:  # text: one by one
        match = pattern.match(stem)
        if match is None:
            return []
        matches.append(match)
    return matches


def _of_seconds(matches: Sequence[re.Match[str]], prefix: list[str]) -> NamedTimes | None:
    # after a point digits are a fraction; else nanoseconds may lack their leading zeros
    is_fraction = matches[0]["sign"] == "." or len({len(match["part"]) for match in matches}) == 1
    parts = [match["part"].ljust(9, "0") if is_fraction else match["part"] for match in matches]
    whole = np.array([int(match["whole"]) for match in matches], np.int64)
    ns = whole * 10**9 + np.array([*map(int, parts)], np.int64)
    is_time = whole.max() < _EPOCH[1] and _is_plausible(ns, prefix)
    return NamedTimes(prefix, ns, "seconds and their fractions") if is_time else None


def _of_ticks(matches: Sequence[re.Match[str]], prefix: list[str]) -> NamedTimes | None:
    ticks = [int(match["whole"]) for match in matches]
    return times_of_numbers(np.array(ticks, np.int64), prefix) if max(ticks) < 2**63 else None


def times_of_numbers(numbers: np.ndarray, prefix: list[str]) -> NamedTimes | None:
    """Large numbers as times, in the unit in which a camera takes such pictures.

    Parameters
    ----------
    numbers
        int64 or float64, shape (n,).
    prefix
        What stands before each: pictures with another prefix are of another recording.
    """
    low, high = numbers.min(), numbers.max()
    for unit, ns in _UNITS.items():
        per_second = 10**9 // ns
        if low >= _EPOCH[0] * per_second and high < _EPOCH[1] * per_second:
            since_1970 = _in_ns(numbers, ns)
            if _is_plausible(since_1970, prefix):
                return NamedTimes(prefix, since_1970, unit)
    step = _usual_step(numbers, prefix)
    if step is None or (high < LEAST_TIME and step < LEAST_STEP):
        return None
    # since the start of something: of units that a camera's rate allows, that nearest to 10 Hz
    rate = {unit: 1e9 / (step * ns) for unit, ns in _UNITS.items()}
    unit = min(rate, key=lambda name: abs(np.log10(rate[name] / 10)))
    if not RATES[0] <= rate[unit] <= RATES[1] or float(high) * _UNITS[unit] >= 2**63:
        return None
    return NamedTimes(prefix, _in_ns(numbers, _UNITS[unit]), unit)


def _in_ns(numbers: np.ndarray, ns: int) -> np.ndarray:
    if numbers.dtype.kind == "f":
        numbers, ns = np.rint(numbers * ns), 1
    whole: np.ndarray = numbers.astype(np.int64)
    return whole * ns


def _of_dates(matches: Sequence[re.Match[str]], prefix: list[str]) -> NamedTimes | None:
    names = ("year", "month", "day", "hour", "minute", "second")
    columns = {name: [int(match[name]) for match in matches] for name in names}
    moments = pd.to_datetime(pd.DataFrame(columns), errors="coerce")
    if moments.isna().any():
        return None
    parts = np.array([int((match["part"] or "").ljust(9, "0")) for match in matches], np.int64)
    ns = moments.to_numpy().astype("datetime64[ns]").astype(np.int64) + parts
    return NamedTimes(prefix, ns, "date and time") if _is_plausible(ns, prefix) else None


def _usual_step(numbers: np.ndarray, prefix: list[str]) -> float | None:
    """Usual distance of neighbours of one prefix; None where there are none."""
    table = pd.DataFrame({"prefix": prefix, "number": numbers}).drop_duplicates()
    steps = table.sort_values("number").groupby("prefix")["number"].diff().dropna()
    return None if steps.empty else float(steps.quantile(0.25))


def _is_plausible(ns: np.ndarray, prefix: list[str]) -> bool:
    """Whether a camera takes pictures at such times; so it is where there is one alone."""
    step = _usual_step(ns, prefix)
    return step is None or RATES[0] <= 1e9 / step <= RATES[1]


def frames_by_times(ns: np.ndarray) -> tuple[np.ndarray, float, bool]:
    """Frame number of each time: the first is 0, and pictures that are missing leave gaps.

    Parameters
    ----------
    ns
        Sorted, unique, int64, shape (n,).

    Returns
    -------
    tuple
        Frames, int64, shape (n,); the period in ns, NaN for a single time; and whether the times
        are nearly even.
    """
    steps = np.diff(ns).astype(float)
    if not len(steps):
        return np.zeros(len(ns), np.int64), np.nan, True
    period = float(np.quantile(steps, 0.25))
    period = float(steps[steps < 1.5 * period].mean())
    n_periods = np.maximum(np.rint(steps / period), 1)
    is_near = n_periods <= _NEAR_STEPS
    period = float(steps[is_near].sum() / n_periods[is_near].sum())
    n_periods = np.maximum(np.rint(steps / period), 1)
    is_even = np.abs(steps / period - n_periods)[is_near] <= _JITTER
    frames = np.concatenate([[0], np.cumsum(n_periods)]).astype(np.int64)
    return frames, period, bool(is_even.mean() >= _EVEN_SHARE and is_near.mean() > 0.5)


def rate_of(period_ns: float) -> float:
    """Pictures per second; the usual rate where that is within half a per cent."""
    rate = 1e9 / period_ns
    usual = float(_USUAL_RATES[np.argmin(np.abs(_USUAL_RATES - rate))])
    return usual if abs(rate / usual - 1) <= _SNAP else float(f"{rate:.5g}")


def nearest_times(
    ns: np.ndarray, their_ns: np.ndarray, period_ns: float
) -> tuple[np.ndarray, np.ndarray]:
    """The nearest of known times, -1 where another lies nearer to the same frame.

    A time within half a period of one that is known is of the same frame.

    Parameters
    ----------
    ns
        Unique, int64, shape (n,).
    their_ns
        Sorted, unique, int64, shape (m,), m > 0.

    Returns
    -------
    tuple
        Index of the known time, and how many periods later a time is; int64, shape (n,).
    """
    after = np.clip(np.searchsorted(their_ns, ns), 1, max(1, len(their_ns) - 1))
    before = after - 1
    after = np.minimum(after, len(their_ns) - 1)
    is_before = np.abs(ns - their_ns[before]) <= np.abs(their_ns[after] - ns)
    nearest = np.where(is_before, before, after)
    period = 1.0 if np.isnan(period_ns) else period_ns
    away = (ns - their_ns[nearest]).astype(float)
    n_periods = np.rint(away / period).astype(np.int64)
    if np.isnan(period_ns):
        n_periods[:] = 0
    error = np.abs(away - n_periods * period)
    table = pd.DataFrame({"nearest": nearest, "n_periods": n_periods, "error": error})
    best = table.sort_values("error", kind="stable").drop_duplicates(["nearest", "n_periods"])
    is_best = np.isin(np.arange(len(ns)), best.index)
    return np.where(is_best, nearest, -1), n_periods
