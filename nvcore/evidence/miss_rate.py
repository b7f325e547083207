"""The log-average miss rate from sums over units, for testing its difference."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import measure_of
from nvcore.evidence.measures import Evidence, Judged, UnitMeasure, judge_measure, run_together
from nvcore.evidence.units import WHOLE, Units, has_any_of, units_within
from nvcore.metrics.detection.curves import Outcomes, detection_outcomes
from nvcore.metrics.detection.filtered_truth import filter_truth
from nvcore.metrics.detection.miss_rate import FPPI_REFERENCES, explain_few, explain_zero
from nvcore.metrics.detection.operating_point import has_one_score
from nvcore.settings.protocols import PROTOCOLS, Protocol

KEY: Final = "log_average_miss_rate"
N_POINTS: Final = 200
"""Number of operating points, in addition to the references, that resamples can use."""
POINT_RANGE: Final = (0.002, 4.0)
"""Range of these points in false positives per image. The references are 0.01 to 1."""


def log_average_miss_rate_measure(
    result: Result, units: Units, protocol: Protocol = PROTOCOLS["all"]
) -> UnitMeasure | None:
    """Return the log-average miss rate for `nvcore.evidence.measures.judge_measure`.

    Each system is counted at the same levels of false positives per image: 200 levels and the nine
    references. A resample or exchange looks up the references among these levels. Over all units,
    the measure is exactly `nvcore.metrics.detection.miss_rate.log_average_miss_rate`.

    Returns
    -------
    None if a system has detections without a score, all its scores are equal, or no pedestrian
    counts.

    References
    ----------
    ``docs/detection.md``, log-average miss rate.
    """
    sums = []
    for _, system in result.sides:
        outcomes = detection_outcomes(result.dataset, system.name, result.params, protocol)
        is_unranked = np.isnan(outcomes.score).any() or has_one_score(result.dataset, system.name)
        if is_unranked or not outcomes.truth.n_truth:
            return None
        sums.append(_sums(outcomes, units))
    better = measure_of(KEY).better
    x, y = sums
    return UnitMeasure(KEY, _label(protocol), better, x, y, statistic=_log_average)


NEEDED: Final = (
    "the log-average miss rate needs {many} that count, and detections with scores that differ"
)


def judge_miss_rate(
    result: Result,
    units: Units,
    protocol: Protocol = PROTOCOLS["all"],
    *,
    has_interval: bool = True,
) -> Judged:
    """Test the difference of the log-average miss rate.

    `note` has the reason if it is undefined or 0. The interval covers the units within the
    recordings that the protocol counts. The test covers all units, because units without a part in
    it do not change p.
    """

    def undefined(why: str) -> Judged:
        return Judged(
            Evidence.undefined(
                *(KEY, _label(protocol), measure_of(KEY).better),
                unit=units.kind,
                n=len(units),
                note=why,
            )
        )

    try:
        truth = filter_truth(result.dataset, protocol)
    except InputError as error:  # no recording has the protocol's tags
        return undefined(error.message)
    recordings = np.zeros(len(result.dataset.recordings), dtype=bool)
    recordings[result.dataset.frame_columns.recording[truth.is_counted]] = True
    of_all = log_average_miss_rate_measure(result, units, protocol)
    if of_all is None:
        units = units_within(result, units, recordings)
        return undefined(result.objects.say(NEEDED))
    measure = of_all
    is_within = has_any_of(units, recordings)
    if not is_within.all():
        units = units_within(result, units, recordings)
        measure = replace(measure, x=measure.x[is_within], y=measure.y[is_within])
    tested = run_together([of_all])[KEY] if units.kind in WHOLE else None
    evidence = judge_measure(measure, units, tested=tested, has_interval=has_interval)
    sums = (measure.x.sum(axis=0), measure.y.sum(axis=0))
    evidence = replace(evidence, doubt=_doubt(evidence, *(_reach(totals) for totals in sums)))
    notes = [evidence.note]
    n_with = np.count_nonzero(measure.x[:, 1])
    if np.isnan(evidence.low) and n_with < len(units):
        many = result.objects.plural
        notes.append(f"only {n_with} of {len(units)} {units.kind} have {many} that count")
    notes.append(explain_few(int(sums[0][1]), result.objects))
    for letter, system_sums in zip("XY", sums, strict=True):
        why_zero = explain_zero(_rates(system_sums))
        notes.append(f"log-average miss rate of {letter}: {why_zero}" if why_zero else "")
    evidence = replace(evidence, note="; ".join(filter(None, notes)))
    return Judged(evidence, tested)


def _label(protocol: Protocol) -> str:
    is_plain = protocol == PROTOCOLS["all"]
    return measure_of(KEY).label + ("" if is_plain else f", {protocol.title}")


def _reach(sums: np.ndarray) -> float:
    """Return the most false positives per image of a curve, within the counted range."""
    n_levels = (len(sums) - 2) // 2
    return float(sums[1 + n_levels] / max(sums[0], 1))


def _doubt(evidence: Evidence, reach_x: float, reach_y: float) -> str:
    """Explain why the worse average may only be due to a list of detections that ends early."""
    worse, better = (reach_x, reach_y) if evidence.difference > 0 else (reach_y, reach_x)
    if worse >= FPPI_REFERENCES[-1] or worse > better:
        return ""
    return (
        f"the detections of X reach {reach_x:.2g} false positives per image and those of Y "
        f"{reach_y:.2g}: beyond the end of a list its last miss rate counts"
    )


def _sums(outcomes: Outcomes, units: Units) -> np.ndarray:
    """Count images, pedestrians, and false and true positives at each level, by unit.

    Shape (n_units, 1 + 1 + 2 * n_levels).
    """
    n = len(units)
    unit = units.unit_of_frame
    truth = outcomes.truth
    n_images = np.bincount(unit[truth.is_counted], minlength=n)
    n_truth = np.bincount(unit[truth.truth.frame_index[truth.counts]], minlength=n)
    # number of detections, from the highest score down, that pass at each level; equal scores pass
    # together
    fp = np.cumsum(~outcomes.is_match)
    is_last = np.ones(len(fp), dtype=bool)
    is_last[:-1] = outcomes.score[1:] != outcomes.score[:-1]
    ends = np.flatnonzero(is_last)
    fppi = fp[ends] / max(truth.n_images, 1)
    levels = np.union1d(np.geomspace(*POINT_RANGE, N_POINTS), FPPI_REFERENCES)
    last = np.searchsorted(fppi, levels, side="right") - 1
    n_passing = np.where(last < 0, 0, ends[np.maximum(last, 0)] + 1) if len(ends) else 0 * last
    level = np.searchsorted(n_passing, np.arange(len(fp)), side="right")  # first that counts it
    of_unit = unit[outcomes.frame_index]
    counts, n_levels = [], len(n_passing) + 1
    for is_kind in (~outcomes.is_match, outcomes.is_match):
        place = of_unit[is_kind] * n_levels + level[is_kind]
        first = np.bincount(place, minlength=n * n_levels).reshape(n, n_levels)
        counts.append(np.cumsum(first[:, :-1], axis=1, dtype=float))
    return np.column_stack([n_images, n_truth, *counts])


def _log_average(sums: np.ndarray) -> np.ndarray:
    """Compute LAMR from such sums, shape (..., columns) to (...), NaN without pedestrians."""
    with np.errstate(invalid="ignore", divide="ignore"):
        lamr: np.ndarray = np.exp(np.log(_rates(sums)).mean(axis=-1))
    return np.where(sums[..., 1] > 0, lamr, np.nan)


def _rates(sums: np.ndarray) -> np.ndarray:
    """Compute miss rates at the references from such sums, shape (..., columns) to (..., 9)."""
    n_levels = (sums.shape[-1] - 2) // 2
    fp, tp = sums[..., 2 : 2 + n_levels], sums[..., 2 + n_levels :]
    most = sums[..., :1] * (FPPI_REFERENCES * (1 + 1e-12))
    n_within = _count_up_to(fp, most)
    tp_within = np.take_along_axis(tp, np.maximum(n_within - 1, 0), axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        rates: np.ndarray = np.maximum(1 - np.where(n_within > 0, tp_within, 0) / sums[..., 1:2], 0)
    return rates


def _count_up_to(values: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Count the values, increasing along the last axis, that are at most each limit.

    Shapes (..., n) and (..., m) to (..., m). This is `np.searchsorted` for many rows at once.
    """
    n = values.shape[-1]
    flat = values.ravel()
    before = np.arange(-1, flat.size - 1, n).reshape(*values.shape[:-1], 1)  # each row, in `flat`
    count = np.zeros(limits.shape, dtype=np.int64)
    for bit in reversed(range(n.bit_length())):
        more = count + (1 << bit)
        probe = flat.take(before + np.minimum(more, n))
        count = np.where((more <= n) & (probe <= limits), more, count)
    return count
