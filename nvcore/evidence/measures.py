"""Is the difference between X and Y more than chance? Measures with their evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.bootstrap import (
    N_RESAMPLES,
    BootstrapDifference,
    Statistic,
    bootstrap_difference,
    pseudo_values,
    ratio,
    studentised_p,
)
from nvcore.evidence.paired_tests import SIGNIFICANT, McNemar, SwapTest, holm, mcnemar, swap_test
from nvcore.evidence.units import (
    OTHER_RECORDINGS,
    RECORDINGS,
    THESE_RECORDINGS,
    Units,
    find_units,
    sum_units,
)
from nvcore.measures.entry import Better
from nvcore.measures.table import (
    EVIDENCE_KEYS,
    doubt_of,
    evidence_keys,
    evidence_label,
    inference_of,
    measure_of,
    repeated_by,
)

D_Z: Final = "Cohen's d_z"
ODDS_RATIO: Final = "odds ratio"


@dataclass(frozen=True, eq=False)
class UnitMeasure:
    """A measure computed from sums over units.

    Attributes
    ----------
    key, label
        Key, and name with unit for people.
    better
        ``higher`` or ``lower``.
    x, y
        Sums of each unit, shape (n_units, *columns); rows in the order of `Units`.
    statistic
        The measure from such sums (`nvcore.evidence.bootstrap.Statistic`).
    """

    key: str
    label: str
    better: Better
    x: np.ndarray
    y: np.ndarray
    statistic: Statistic = ratio


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What the data say about the difference X - Y in one measure.

    Attributes
    ----------
    figure, label, better
        Key of the measure (the files call this column `figure`); name with unit; ``higher`` or
        ``lower``.
    x, y, difference
        Values of both systems, and ``x - y``; NaN undefined.
    low, high
        95 % interval of the difference; NaN where none can be given.
    p, p_holm
        Two-sided p-value, and by Holm's correction for all measures shown together; NaN where none
        can be given, and p_holm where the hypothesis is that of another row.
    least_p
        The least p that so many units could give; NaN without p.
    effect, effect_name
        Size of the difference: Cohen's d_z (the difference over the standard deviation of the
        units' parts in it; positive where X is higher), or the odds ratio of discordant encounters
        (above 1 where X detects more). NaN for d_z where there is neither interval nor p-value.
    n, unit
        How many were compared, and of what: encounters, recordings, blocks.
    scope
        What interval and p are about: ``other recordings`` like these, or ``these recordings``
        alone.
    method
        How interval and p-value were computed.
    doubt
        Why no claim can rest on the difference, however small p is.
    note
        Why something is missing, and what the numbers do not say.
    """

    figure: str
    label: str
    better: Better
    x: float = math.nan
    y: float = math.nan
    difference: float = math.nan
    low: float = math.nan
    high: float = math.nan
    p: float = math.nan
    p_holm: float = math.nan
    least_p: float = math.nan
    effect: float = math.nan
    effect_name: str = D_Z
    n: int
    unit: str
    scope: str = OTHER_RECORDINGS
    method: str = ""
    doubt: str = ""
    note: str

    @classmethod
    def undefined(
        cls, key: str, label: str, better: Better, *, unit: str, note: str, n: int = 0
    ) -> Evidence:
        """Evidence of a measure that these data cannot give; `note` says why."""
        return cls(figure=key, label=label, better=better, n=n, unit=unit, note=note)

    def values_only(self) -> Evidence:
        """The values without interval, test and effect size."""
        nan = math.nan
        return replace(self, low=nan, high=nan, p=nan, least_p=nan, effect=nan, method="")


COLUMNS: Final = tuple(field.name for field in fields(Evidence))


def significance_table(
    result: Result,
    extra: Sequence[Evidence] = (),
    *,
    units: Units | None = None,
    has_intervals: bool = True,
) -> pd.DataFrame:
    """The scorecard's measures with interval, p-value and effect size.

    `nvcore.evidence.table.evidence_table` adds the log-average miss rate.

    Encounters detected come twice: encounter by encounter (McNemar), which is about these drives
    alone, and by units, which allows for encounters of one recording being alike. Then come the
    other measures that `nvcore.measures.Inference` judges so (without those that do not apply, such
    as those of urgent encounters where nobody is urgent), and `extra`. Where the data are
    too few for a measure, or most encounters are single frames, it is NaN and `note` says why.

    Parameters
    ----------
    extra
        Further measures, included in Holm's correction.
    units
        ``find_units(result)``, if already computed.
    has_intervals
        Without them, p alone: much faster.

    Returns
    -------
    Columns `COLUMNS` (attributes of `Evidence`), one row per measure. p_holm corrects for all of
    them but those whose hypothesis another row has already (`corrected`).

    Examples
    --------
    >>> significance_table(result)[["figure", "difference", "low", "high"]]  # doctest: +SKIP
    """
    keys = [key for key in evidence_keys(result) if inference_of(key).test != "curve"]
    rows = judge(result, keys, units=units, has_intervals=has_intervals)
    table = pd.DataFrame([vars(row) for row in (*rows, *extra)])
    table["p_holm"] = corrected(table)
    return table


def judge(
    result: Result,
    keys: Sequence[str],
    *,
    units: Units | None = None,
    has_intervals: bool = True,
) -> tuple[Evidence, ...]:
    """The evidence of some measures, each by itself: p is not corrected for the others.

    Parameters
    ----------
    keys
        Of `nvcore.measures.EVIDENCE_KEYS`, without the log-average miss rate.
    units, has_intervals
        As of `significance_table`.
    """
    units = find_units(result) if units is None else units
    by_unit = {measure.key: measure for measure in unit_measures(result, units)}

    def judge_one(key: str) -> Evidence:
        inference = inference_of(key)
        if inference.test == "encounters":
            row = judge_encounters(result, key)
            row = row.values_only() if result.is_short else row
        else:
            row = judge_measure(by_unit[key], units, has_interval=has_intervals)
            row = with_mean_over_recordings(result, units, row)
        return with_doubt(result, row)

    return tuple(map(judge_one, keys))


def with_doubt(result: Result, row: Evidence) -> Evidence:
    """The row with why no claim can rest on it, by what subjects know of its measure."""
    return replace(row, doubt=doubt_of(result, measure_of(row.figure)))


def corrected(table: pd.DataFrame) -> np.ndarray:
    """Holm's correction of p over rows of `Evidence`; NaN where another row has the hypothesis.

    McNemar's test asks by encounters what is asked by recordings, and lost similarity is mean
    similarity in other words: they make the family no larger.
    """
    is_repeated = np.array([bool(repeated_by(key)) for key in table["figure"]], dtype=bool)
    return holm(np.where(is_repeated, np.nan, table["p"].to_numpy(dtype=float)))


def judge_encounters(result: Result, key: str = "encounters_detected") -> Evidence:
    """A share of encounters, encounter by encounter: McNemar's test.

    Parameters
    ----------
    key
        Of a measure of which `nvcore.measures.Inference` says how encounters split.
    """
    split = inference_of(key).split
    assert split is not None, key
    test = mcnemar(split(result))
    notes = [test.reason]
    if result.is_short:
        notes.append(
            f"most encounters are one frame long, so they are frames rather than "
            f"{result.objects.plural}, and not independent: go by the measure by recordings or "
            "blocks"
        )
    return Evidence(
        figure=key,
        label=evidence_label(key, result, units=""),
        better=measure_of(key).better,
        x=test.share_x,
        y=test.share_y,
        difference=test.difference,
        low=test.low,
        high=test.high,
        p=test.p,
        effect=test.odds_ratio,
        effect_name=ODDS_RATIO,
        n=test.n,
        unit="encounters",
        scope=THESE_RECORDINGS,
        method=_mcnemar_method(test),
        note=_join(notes),
    )


def _mcnemar_method(test: McNemar) -> str:
    parts = []
    if not np.isnan(test.low):
        parts.append("Newcombe's interval for paired shares")
    if not np.isnan(test.p):
        parts.append(f"exact McNemar test of {test.x_only} to {test.y_only}")
    return "; ".join(parts)


def unit_measures(result: Result, units: Units) -> tuple[UnitMeasure, ...]:
    """The measures that are computed from sums over units."""
    sums = sum_units(result, units)
    measures = []
    for key in EVIDENCE_KEYS:
        inference = inference_of(key)
        if inference.test != "units":
            continue
        x, y = (
            np.column_stack([inference.factor * sums[f"{key}_{letter}"], sums[inference.per]])
            for letter in "xy"
        )
        label = evidence_label(key, result, units.kind)
        measures.append(UnitMeasure(key, label, measure_of(key).better, x, y))
    return tuple(measures)


def judge_measure(measure: UnitMeasure, units: Units, *, has_interval: bool = True) -> Evidence:
    """Difference of a measure with bootstrap interval, test and effect size.

    p is the larger of the exact exchange's (`swap_test`) and the studentised bootstrap's, which
    allows for skew. Blocks of time have none.
    """
    x, y, statistic = measure.x, measure.y, measure.statistic
    n_resamples = N_RESAMPLES if has_interval else 0
    interval = bootstrap_difference(x, y, statistic, n_resamples=n_resamples, units=units.kind)
    if units.kind == RECORDINGS:
        test = swap_test(x, y, statistic)
    else:
        test = SwapTest(np.nan, 0, 0, is_exact=False, seed=interval.seed, reason="")
    has_p = bool(np.isfinite(test.p))
    parts = pseudo_values(x, y, statistic) if has_p else np.empty(0)
    p_of_skewed = studentised_p(parts)
    p = np.fmax(test.p, p_of_skewed) if has_p else np.nan
    notes = [*dict.fromkeys((interval.reason, test.reason)), units.note]
    if test.p <= SIGNIFICANT < p:
        notes.append(
            "the recordings' differences are very skewed: a few large ones against many small ones"
        )
    has_evidence = np.isfinite(interval.low) or has_p
    return Evidence(
        figure=measure.key,
        label=measure.label,
        better=measure.better,
        x=interval.x,
        y=interval.y,
        difference=interval.difference,
        low=interval.low,
        high=interval.high,
        p=float(p),
        least_p=test.least_p,
        effect=_effect_size(measure) if has_evidence else np.nan,
        n=len(units),
        unit=units.kind,
        scope=units.scope,
        method=_unit_method(interval, test, p_of_skewed, units),
        note=_join(notes),
    )


def with_mean_over_recordings(result: Result, units: Units, row: Evidence) -> Evidence:
    """The row, with values at least where blocks of time cannot share a mean over recordings."""
    inference, by_recording = inference_of(row.figure), measure_of(row.figure).by_recording
    if inference.per != "share_of_recording" or units.kind == RECORDINGS:
        return row
    if inference.parts is None or by_recording is None or inference.parts(result, result.x):
        return row
    recordings = np.unique(units.recording)
    x, y = (float(by_recording(result, system)[recordings].mean()) for _, system in result.sides)
    note = _join([inference.not_in_blocks, units.note])
    return replace(row, x=x, y=y, difference=x - y, note=note)


def _effect_size(measure: UnitMeasure) -> float:
    """Cohen's d_z from jackknife pseudo-values."""
    x, y = measure.x, measure.y
    if len(x) < 2:
        return float("nan")
    difference = float(measure.statistic(x.sum(axis=0)) - measure.statistic(y.sum(axis=0)))
    spread = float(pseudo_values(x, y, measure.statistic).std(ddof=1))
    # the spread of equal differences may be a rounding error instead of 0
    if not spread > 1e-9 * abs(difference):
        return float("nan")
    return difference / spread


def _unit_method(
    interval: BootstrapDifference, test: SwapTest, p_of_skewed: float, units: Units
) -> str:
    parts = []
    if interval.method:
        parts.append(
            f"{interval.method} of {units.text}, {N_RESAMPLES:,} resamples, seed {interval.seed}"
        )
    if not np.isnan(test.p):
        ways = (
            f"all {test.n_permutations:,}" if test.is_exact else f"{test.n_permutations:,} random"
        )
        where = f"the {test.n_swapped:,} {units.kind} that differ"
        parts.append(f"X and Y exchanged within {where}, in {ways} ways (p = {test.p:.2g})")
    if not np.isnan(p_of_skewed):
        parts.append(f"studentised bootstrap (p = {p_of_skewed:.2g}); p is the larger of the two")
    return "; ".join(parts)


def _join(notes: Sequence[str]) -> str:
    return "; ".join(note for note in notes if note)
