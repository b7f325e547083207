"""Pilot of a study: contribution of each available recording to the difference X - Y."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import EVIDENCE_KEYS, inference_of, key_in
from nvcore.evidence.bootstrap import ROUNDING
from nvcore.evidence.companions import judge_keys
from nvcore.evidence.measures import Evidence, UnitMeasure, unit_measures
from nvcore.evidence.miss_rate import NEEDED, judge_miss_rate, log_average_miss_rate_measure
from nvcore.evidence.paired_tests import MIN_SWAPPED
from nvcore.evidence.planning.thresholds import Curve, Thresholds, parts_at_equal_alarms
from nvcore.evidence.units import WHOLE, Units, find_units, sum_units, units_within
from nvcore.metrics.detection.filtered_truth import filter_truth
from nvcore.settings.protocols import PROTOCOLS, Protocol

MIN_PILOT: Final = MIN_SWAPPED
"""Fewest recordings to plan from. With fewer, there is no test of recordings, either."""
_BY_UNIT: Final = "_by_unit"
PLAN_KEYS: Final = {
    key.removesuffix(_BY_UNIT): key
    for key in EVIDENCE_KEYS
    if inference_of(key).test != "encounters"
}
"""Measures that a study can be planned for (those judged by recordings), by the users' names.
``encounters_detected`` is also the measure by recordings."""


@dataclass(frozen=True, eq=False)
class Pilot:
    """Difference X - Y of a measure, as a ratio of sums over recordings.

    Attributes
    ----------
    difference
        X - Y over all recordings, ``parts.sum() / weights.sum()``.
    parts, weights
        Contribution of each recording to numerator and denominator; float64, shape (n_recordings,).
        For the log-average miss rate, the parts are jackknife pseudo-values and the weights are 1.
    differs
        Recordings in which X and Y differ; bool, shape (n_recordings,).
    n_encounters, duration_s
        Encounters and duration of an average recording.
    thresholds
        Results with other thresholds; None if the measure does not depend on them.
    sign
        1 if a positive difference favours X, else -1.
    """

    difference: float
    parts: np.ndarray
    weights: np.ndarray
    differs: np.ndarray
    n_encounters: float
    duration_s: float
    thresholds: Thresholds | None = None
    sign: int = 1

    def __len__(self) -> int:
        return len(self.parts)

    @property
    def residuals(self) -> np.ndarray:
        """Deviation of each recording's part from its share of the difference."""
        rest: np.ndarray = self.parts - self.difference * self.weights
        return rest

    @property
    def spread(self) -> float:
        """Standard deviation of one recording's difference from that of all recordings."""
        scale = float(self.weights.mean())
        return float(np.sqrt((self.residuals**2).sum() / (len(self) - 1))) / scale

    @property
    def is_constant(self) -> bool:
        """Whether recordings do not vary, so that nothing can be planned from them."""
        size = float(np.abs(self.parts).max(initial=0.0))
        return float(np.abs(self.residuals).max(initial=0.0)) <= 1e3 * ROUNDING * size

    def parts_for(self, difference: float) -> np.ndarray:
        """Return parts that vary as in these recordings, but with another overall difference.

        The residuals are widened because n recordings drawn with replacement vary less than the
        recordings that they come from.
        """
        parts: np.ndarray = difference * self.weights + self.widening * self.residuals
        return parts

    def missing(self, difference: float) -> np.ndarray:
        """Return the addition to each recording's part that gives the pilot this difference."""
        missing: np.ndarray = (difference - self.parts.sum() / self.weights.sum()) * self.weights
        return missing

    def is_withheld(self, difference: float) -> bool:
        """Whether the better system has more false alarms and no threshold can change that."""
        if self.thresholds is None or any(self.thresholds.curves):
            return False
        x, y = (float(of.alarms.sum()) for of in self.thresholds.as_set)
        return bool(np.sign(difference) * self.sign == np.sign(x - y))

    def repeated(self, rng: np.random.Generator, n_times: int) -> Iterator[Pilot]:
        """Yield pilots of as many recordings, drawn from these with replacement.

        At equal false alarms, each has thresholds of its own. Its difference then follows to first
        order, as in `nvcore.evidence.companions.shifts_at_equal_alarms`.
        """
        parts, n = self.parts, len(self)
        if self.thresholds is not None and self.thresholds.is_equalized:
            (shifted,), *_ = parts_at_equal_alarms(self.thresholds, np.ones((1, n), dtype=int))
            parts = shifted if np.isfinite(shifted).all() else parts
        for rows in rng.integers(0, n, (n_times, n)):
            total = float(self.weights[rows].sum())
            yield replace(
                self,
                difference=float(parts[rows].sum()) / total if total else np.nan,
                parts=parts[rows],
                weights=self.weights[rows],
                differs=self.differs[rows],
                thresholds=self.thresholds
                and self.thresholds.change(partial(Curve.of_recordings, rows=rows)),
            )

    @property
    def widening(self) -> float:
        """``sqrt(n / (n - 1))``."""
        return float(np.sqrt(len(self) / (len(self) - 1)))


def plan_key(name: str) -> str:
    """Return the key in the table of evidence for a user's name of a measure.

    Raises
    ------
    ParameterError
        If no study can be planned for it.
    """
    return key_in(PLAN_KEYS, name, "no study can be planned for")


def judge_key(
    result: Result, key: str, *, protocol: Protocol = PROTOCOLS["all"], units: Units | None = None
) -> Evidence:
    """Return the row of the table of evidence for a measure of `PLAN_KEYS`, with uncorrected p."""
    units = find_units(result) if units is None else units
    if inference_of(key).test == "curve":
        return judge_miss_rate(result, units, protocol).evidence
    (row,) = judge_keys(result, [key], units=units)
    return row


def make_pilot(
    result: Result, key: str, *, protocol: Protocol = PROTOCOLS["all"], units: Units | None = None
) -> tuple[Pilot | None, str]:
    """Return the pilot for a measure of `PLAN_KEYS`, or None and the reason for having none.

    At least `MIN_PILOT` recordings are needed, because blocks of time do not represent other
    recordings.
    """
    units = find_units(result) if units is None else units
    measure: UnitMeasure | None
    if inference_of(key).test == "curve":
        try:
            units = _counted_units(result, units, protocol)
        except InputError as error:  # no recording has the protocol's tags
            return None, error.message
        measure = log_average_miss_rate_measure(result, units, protocol)
    else:
        measure = next(measure for measure in unit_measures(result, units) if measure.key == key)
    if units.kind not in WHOLE or len(units) < MIN_PILOT:
        return None, too_few_for_pilot(units.n_recordings, units.n_independent)
    if measure is None:
        return None, result.objects.say(NEEDED)
    pilot = _pilot_of(measure, result, units)
    if not np.isfinite(pilot.difference):
        return None, "the measure is undefined in these recordings"
    if pilot.is_constant:
        return None, _why_constant(pilot)
    return pilot, ""


def too_few_for_pilot(n: int, n_independent: int) -> str:
    """Explain why `n` recordings are too few for a plan. Recordings of one unit count as one."""
    verb = "is" if n == 1 else "are"
    needed, here = "recordings", f"{verb} {n}"
    if n_independent < n:
        needed, here = f"independent {needed}", f"{verb} {n:,}, {n_independent} of them independent"
    return (
        f"a plan needs a pilot of {MIN_PILOT} {needed} or more, here {here}: stretches of time say "
        "nothing of other recordings"
    )


def _why_constant(pilot: Pilot) -> str:
    """Explain why nothing can be planned from recordings that do not vary."""
    if not pilot.differs.any():
        return "X and Y are the same in every recording: there is no variation to plan from"
    n_counting = int(np.count_nonzero(pilot.weights))
    if n_counting < MIN_PILOT:
        verb = "has" if n_counting == 1 else "have"
        return (
            f"too few recordings to plan from: {n_counting} of {len(pilot)} {verb} encounters that "
            f"count for it, at least {MIN_PILOT} are needed"
        )
    which = "" if n_counting == len(pilot) else " that has encounters that count for it"
    return (
        f"X and Y differ by the same in every recording{which}: there is no variation to plan from"
    )


def _pilot_of(measure: UnitMeasure, result: Result, units: Units) -> Pilot:
    x, y, n = measure.x, measure.y, len(measure.x)
    of_all = sum_units(result, units)
    if inference_of(measure.key).test == "curve":
        all_x, all_y = x.sum(axis=0), y.sum(axis=0)
        difference = float(measure.statistic(all_x) - measure.statistic(all_y))
        without = measure.statistic(all_x - x) - measure.statistic(all_y - y)
        pseudo = n * difference - (n - 1) * without
        parts, weights = pseudo - pseudo.mean() + difference, np.ones(n)
    else:  # X and Y have the same denominators: frames, encounters or time of the recording
        parts, weights = x[:, 0] - y[:, 0], x[:, 1].astype(float)
        total = float(weights.sum())
        difference = float(parts.sum()) / total if total else np.nan
    return Pilot(
        difference=difference,
        parts=parts,
        weights=weights,
        differs=np.any(x != y, axis=1),
        n_encounters=float(of_all["n_encounters"].mean()),
        duration_s=float(of_all["duration_s"].mean()),
        sign=1 if measure.better == "higher" else -1,
    )


def _counted_units(result: Result, units: Units, protocol: Protocol) -> Units:
    """Return the units within the recordings that a protocol counts."""
    truth = filter_truth(result.dataset, protocol)
    recordings = np.zeros(len(result.dataset.recordings), dtype=bool)
    recordings[result.dataset.frame_columns.recording[truth.is_counted]] = True
    return units_within(result, units, recordings)
