"""Plan how many recordings would show a difference, or non-inferiority by a margin."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final, Literal, get_args

import numpy as np
import pandas as pd

from nvcore.common.arguments.plan import PlanArguments, Side
from nvcore.common.errors import ParameterError
from nvcore.common.progress import Progress, no_progress, part_of
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Better
from nvcore.comparison.measures.table import inference_of
from nvcore.evidence.bootstrap import MIN_UNITS
from nvcore.evidence.measures import Evidence, primary_of
from nvcore.evidence.operating_points import are_delivered, is_undecided
from nvcore.evidence.paired_tests import MIN_SWAPPED, SIGNIFICANT
from nvcore.evidence.planning.notes import notes_of_plan
from nvcore.evidence.planning.pilot import Pilot, judge_key, make_pilot, plan_key
from nvcore.evidence.planning.power import (
    MOST_RECORDINGS,
    PowerPoint,
    count_differences_shown,
    count_noninferior,
    find_length,
    guess_length,
)
from nvcore.evidence.planning.repeated_pilots import WIDEST, find_range
from nvcore.evidence.planning.thresholds import Thresholds, vary_thresholds
from nvcore.evidence.units import WHOLE, Units, find_units
from nvcore.notes import say
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.protocols import PROTOCOLS, Protocol

ONE_SIDED: Final = 0.025
"""Level at which the 95 % interval shows non-inferiority."""

Assumption = Literal["as found", "as named", "equal"]


@dataclass(frozen=True)
class PlanSize:
    """Required size of a study for one assumed difference.

    Attributes
    ----------
    assumption
        Source of the difference: ``as found`` in these recordings, ``as named`` by the user, or
        ``equal`` systems.
    difference
        Assumed difference X - Y, in the unit of the measure.
    n_recordings, n_encounters, duration_s
        Size of the study. None and NaN without one; see `reason`.
    power, power_low, power_high
        Share of simulated studies of that size that succeed, with 95 % Monte Carlo interval.
    least_recordings, most_recordings
        Range of `n_recordings` that 80 % of pilots like this one ask for. A study of the larger
        one keeps the promised power more surely.
    points
        Power of the simulated studies.
    reason
        Reason for having no size, else empty.
    """

    assumption: Assumption
    difference: float
    n_recordings: int | None = None
    n_encounters: int | None = None
    duration_s: float = math.nan
    power: float = math.nan
    power_low: float = math.nan
    power_high: float = math.nan
    least_recordings: int | None = None
    most_recordings: int | None = None
    points: tuple[PowerPoint, ...] = field(default=(), repr=False)
    reason: str = ""


@dataclass(frozen=True)
class NonInferiority:
    """Result of testing that a system is at most a margin worse than the other.

    Attributes
    ----------
    candidate
        System that is preferred for other reasons, such as its price: ``x`` or ``y``.
    margin
        Largest acceptable loss, in the unit of the measure (shares: 0 to 1).
    worse
        Loss in these recordings. Negative: the candidate is better.
    worse_at_most
        Unfavourable end of the 95 % interval: largest loss with other recordings, at 97.5 %. NaN
        without an interval.
    is_shown
        True if `worse_at_most` is less than the margin. None if it cannot be determined.
    reason
        Reason if it cannot be determined, else empty.
    """

    candidate: Side
    margin: float
    worse: float
    worse_at_most: float
    is_shown: bool | None
    reason: str


@dataclass(frozen=True)
class Plan:
    """Evidence of these recordings on a measure, and study sizes that would show more.

    Attributes
    ----------
    evidence
        Difference X - Y in these recordings, with interval and uncorrected p.
    n_encounters, duration_s
        Encounters that count and duration of these recordings, or of the pilot's if there is one.
    power
        Desired share of studies that show it.
    n_tests
        Number of measures that the study's p is corrected for.
    sizes
        Sizes of studies, one for each assumed difference.
    n_differing
        Number of recordings in which X and Y differ. None without a pilot.
    is_unequal
        True if X and Y have different operating points and the measure depends on them.
    has_equal_alarms
        True if studies are also compared at equal false alarms, with thresholds of their own.
    noninferiority
        Result of the test that the candidate is at most the margin worse. None: not asked.
    """

    evidence: Evidence
    n_encounters: int
    duration_s: float
    power: float
    n_tests: int
    sizes: tuple[PlanSize, ...]
    n_differing: int | None = None
    is_unequal: bool = False
    has_equal_alarms: bool = False
    noninferiority: NonInferiority | None = None

    def __str__(self) -> str:
        return "\n".join(self.sentences)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Conclusions of the plan, in sentences."""
        return tuple(say(note, PEDESTRIAN) for note in notes_of_plan(self))  # none names objects

    @property
    def level(self) -> float:
        """Largest p at which a study shows a difference."""
        return SIGNIFICANT / self.n_tests

    @property
    def curve(self) -> pd.DataFrame:
        """Power of every simulated study size.

        Columns: ``assumption``, ``difference``, ``n_recordings``, ``n_encounters``, ``power``,
        ``low``, ``high``, ``n_studies``.
        """
        of_sizes = ("assumption", "difference")
        rows = [
            (size.assumption, size.difference, *point)
            for size in self.sizes
            for point in size.points
        ]
        table = pd.DataFrame(rows, columns=[*of_sizes, *PowerPoint._fields])
        per_recording = self.n_encounters / max(self.evidence.n, 1)
        n_encounters = [round(per_recording * n) for n in table["n_recordings"]]
        table.insert(3, "n_encounters", n_encounters)
        return table


def plan_recordings(
    result: Result,
    asked: PlanArguments = PlanArguments(),  # noqa: B008
    *,
    protocol: Protocol = PROTOCOLS["all"],
    units: Units | None = None,
    evidence: Evidence | None = None,
    thresholds: Mapping[str, Thresholds] | None = None,
    progress: Progress = no_progress,
) -> Plan:
    """Plan how many recordings like these would show a difference, or non-inferiority.

    Parameters
    ----------
    asked
        Measure and question.
    protocol
        Selection of the pedestrians that count in the log-average miss rate.
    units, evidence, thresholds
        ``find_units(result)``, ``judge_key(result, key)`` and ``vary_thresholds(result, units)`` if
        already computed. A difference has to be shown at equal false alarms, too, unless the
        thresholds are delivered ones; the plan then leaves out their false alarms.

    Raises
    ------
    ParameterError
        If a study cannot be planned for this measure, or a value is outside its range.

    Examples
    --------
    >>> asked = PlanArguments(difference=0.03)
    >>> plan_recordings(result, asked).sizes[0].n_recordings  # doctest: +SKIP
    212
    """
    key = plan_key(asked.measure or primary_of(result.dataset).key)
    _check(key, asked)
    margin, difference = asked.margin, asked.difference
    units = find_units(result) if units is None else units
    if evidence is None:
        evidence = judge_key(result, key, protocol=protocol, units=units)
    assert evidence.figure == key
    pilot, why_not = make_pilot(result, key, protocol=protocol, units=units)
    is_tested_alike = result.as_set is not None or (margin is None and not are_delivered(result))
    if pilot is not None and is_tested_alike:
        thresholds = vary_thresholds(result, units) if thresholds is None else thresholds
        pilot = replace(pilot, thresholds=thresholds.get(key))
    assumed: list[tuple[Assumption, float]] = [("as found", evidence.difference)]
    if margin is not None:
        assumed.insert(0, ("equal", 0.0))
    elif difference is not None:
        named = -difference if evidence.difference < 0 else difference
        assumed.insert(0, ("as named", named))
    sizes = [PlanSize(*size, reason=why_not) for size in assumed]
    n_differing, n_encounters, duration_s = None, result.venn.n_near, result.duration_s
    if pilot is not None:
        for index, size in enumerate(sizes):
            part = part_of(progress, index / len(sizes), (index + 1) / len(sizes))
            sizes[index] = _size(pilot, size, asked, evidence.better, part)
        n_differing = int(np.count_nonzero(pilot.differs))
        n_encounters = round(pilot.n_encounters * len(pilot))
        duration_s = pilot.duration_s * len(pilot)
    is_unequal = is_undecided(result, key)
    return Plan(
        evidence=evidence,
        n_encounters=n_encounters,
        duration_s=duration_s,
        power=asked.power,
        n_tests=asked.n_tests,
        sizes=tuple(sizes),
        n_differing=n_differing,
        is_unequal=is_unequal,
        has_equal_alarms=pilot is not None and pilot.thresholds is not None,
        noninferiority=None
        if margin is None
        else judge_noninferiority(evidence, asked.candidate, margin, is_undecided=is_unequal),
    )


def _check(key: str, asked: PlanArguments) -> None:
    if asked.difference is not None and asked.margin is not None:
        raise ParameterError(
            "a study looks for a difference, or for no more than a margin: give one of the two"
        )
    for name, value in (("difference", asked.difference), ("margin", asked.margin)):
        if value is None:
            continue
        if not (math.isfinite(value) and value > 0):
            raise ParameterError(f"{name} is {value:g}: expected a number above 0")
        if inference_of(key).scale.is_share and value >= 1:
            raise ParameterError(
                f"{name} is {value:g}: expected a share below 1, such as 0.03 for 3 percentage "
                "points"
            )
    if asked.candidate not in get_args(Side):
        raise ParameterError(f"candidate is {asked.candidate!r}: expected x or y")
    if not 0.5 <= asked.power <= 0.99:
        raise ParameterError(f"power is {asked.power:g}: expected a share from 0.5 to 0.99")
    if asked.n_tests < 1:
        raise ParameterError(f"{asked.n_tests} tests: expected 1 or more")


def _size(
    pilot: Pilot, size: PlanSize, asked: PlanArguments, better: Better, progress: Progress
) -> PlanSize:
    """Compute the study size for one assumed difference, or the reason for having none."""
    shown: Callable[..., int]
    difference, reason = size.difference, ""
    if asked.margin is None:
        distance, least, level = difference, MIN_SWAPPED, SIGNIFICANT / asked.n_tests
        shown = partial(count_differences_shown, level=level)
        rough = partial(shown, is_rough=True)
        if difference == 0:
            reason = "X and Y are equal in these recordings: name a difference"
        elif pilot.is_withheld(difference):
            reason = (
                "the better system also has more false alarms, and without scores that differ "
                "the two cannot be set to equal false alarms: more recordings do not change that"
            )
    else:
        sign = favour(asked.candidate, better)
        distance, least, level = sign * difference + asked.margin, MIN_UNITS, 2 * ONE_SIDED
        shown = rough = partial(count_noninferior, margin=asked.margin, sign=sign)
        if distance <= 0:
            reason = (
                "the candidate is then worse by the margin or more: no study shows that it is not"
            )
    if reason:
        return replace(size, reason=reason)
    guess = guess_length(pilot, distance, level=level, target=asked.power)
    length = find_length(
        partial(shown, pilot, difference),
        guess=guess,
        least=least,
        target=asked.power,
        progress=progress,
    )
    n = length.n_recordings
    if n is None:
        reason = f"more than {MOST_RECORDINGS:,} recordings like these"
        return replace(size, points=length.points, reason=reason)
    progress(0.95, "repeated pilots")
    ends = find_range(
        lambda of: partial(rough, of, difference),
        pilot,
        n,
        least=least,
        level=level,
        target=asked.power,
    )
    if ends is None:
        reason = (
            f"too few recordings to plan from: the sizes that pilots of {len(pilot)} like these "
            f"ask for differ by a factor of more than {WIDEST}"
        )
        return replace(size, reason=reason)
    point = next(point for point in length.points if point.n_recordings == n)
    return replace(
        size,
        n_recordings=n,
        n_encounters=round(n * pilot.n_encounters),
        duration_s=n * pilot.duration_s,
        power=point.power,
        power_low=point.low,
        power_high=point.high,
        least_recordings=ends[0],
        most_recordings=ends[1],
        points=length.points,
    )


def favour(candidate: Side, better: Better) -> int:
    """Return 1 if a positive difference X - Y favours the candidate, else -1."""
    return 1 if (candidate == "x") == (better == "higher") else -1


def worse_at_most(evidence: Evidence, candidate: Side) -> float:
    """Return the candidate's largest loss within the 95 % interval of the difference.

    Positive is worse. NaN without an interval, or if the evidence is about blocks of time.
    """
    if evidence.unit not in WHOLE:
        return math.nan
    sign = favour(candidate, evidence.better)
    return -sign * (evidence.low if sign > 0 else evidence.high)


def judge_noninferiority(
    evidence: Evidence, candidate: Side, margin: float, *, is_undecided: bool = False
) -> NonInferiority:
    """Compare the margin with the confidence interval of a difference.

    It is shown if the whole 95 % interval of the difference is on the better side of the margin: a
    one-sided test at 2.5 %. Blocks of time show nothing, as they do not represent other recordings.

    Parameters
    ----------
    is_undecided
        Value of `nvcore.evidence.operating_points.is_undecided` for the comparison and measure.
        Unequal operating points show nothing.

    Examples
    --------
    >>> row = Evidence(figure="mean_similarity", label="", better="higher", n=20, note="",
    ...     unit="recordings", difference=0.01, low=-0.01, high=0.02)
    >>> judge_noninferiority(row, "y", 0.03).is_shown  # Y is at most 0.02 worse
    True
    >>> judge_noninferiority(row, "y", 0.015).is_shown
    False
    """
    end = math.nan if is_undecided else worse_at_most(evidence, candidate)
    reason = ""
    if is_undecided:
        reason = "X and Y are set to different operating points"
    elif evidence.unit not in WHOLE:
        reason = "stretches of time say nothing of other recordings"
    elif evidence.doubt:
        reason = evidence.doubt
    elif math.isnan(end):
        reason = evidence.note or "the difference has no interval"
    return NonInferiority(
        candidate=candidate,
        margin=margin,
        worse=-favour(candidate, evidence.better) * evidence.difference,
        worse_at_most=end,
        is_shown=None if reason else end < margin,
        reason=reason,
    )
