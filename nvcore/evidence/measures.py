"""Measures with their evidence that the difference between X and Y is more than chance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Final, Literal

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Better
from nvcore.comparison.measures.table import (
    EVIDENCE_KEYS,
    choose_primary,
    doubt_of,
    evidence_keys,
    evidence_label,
    inference_of,
    measure_of,
    repeated_by,
)
from nvcore.dataset import Dataset
from nvcore.evidence.bootstrap import (
    N_RESAMPLES,
    SEED,
    BootstrapDifference,
    Statistic,
    StudentisedTest,
    bootstrap_difference,
    pseudo_values,
    ratio,
    studentised_tests,
)
from nvcore.evidence.paired_tests import (
    SIGNIFICANT,
    McNemar,
    Paired,
    SwapTest,
    mcnemar,
    step_down,
    swap_tests,
)
from nvcore.evidence.units import (
    OTHER_RECORDINGS,
    THESE_RECORDINGS,
    WHOLE,
    Units,
    find_units,
    sum_units,
)
from nvcore.settings.primary import Primary

D_Z: Final = "Cohen's d_z"
ODDS_RATIO: Final = "odds ratio"


@dataclass(frozen=True, eq=False)
class UnitMeasure:
    """Measure that is computed from sums over units.

    Attributes
    ----------
    key, label
        Key, and name with unit for people.
    better
        ``higher`` or ``lower``.
    x, y
        Sums of each unit, shape (n_units, *columns); rows in the order of `Units`.
    statistic
        Function that computes the measure from the sums (`nvcore.evidence.bootstrap.Statistic`).
    """

    key: str
    label: str
    better: Better
    x: np.ndarray
    y: np.ndarray
    statistic: Statistic = ratio


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Evidence on the difference X - Y in one measure.

    Attributes
    ----------
    figure, label, better
        Key of the measure (the files call this column `figure`); name with unit; ``higher`` or
        ``lower``.
    x, y, difference
        Values of both systems, and ``x - y``; NaN if undefined.
    low, high
        95 % interval of the difference; NaN if there is none.
    p, p_corrected
        Two-sided p-value, and the same corrected for all measures tested together. NaN if there is
        none; p_corrected is also NaN if another row tests the same hypothesis.
    least_p
        Smallest p that this number of units can give; NaN without p.
    effect, effect_name
        Size of the difference: Cohen's d_z (the difference over the standard deviation of the
        units' parts in it; positive if X is higher), or the odds ratio of discordant encounters
        (above 1 if X detects more). d_z is NaN if there is neither interval nor p-value.
    n, unit
        Number of things compared, and their kind: encounters, recordings, blocks.
    scope
        Scope of interval and p: ``other recordings`` like these, or only ``these recordings``.
    method
        Method of computing interval and p-value.
    doubt
        Reason why the difference supports no claim, however small p is.
    note
        Reasons for missing values, and limits of the numbers.
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
    p_corrected: float = math.nan
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
        """Create evidence for a measure that these data cannot give. `note` has the reason."""
        return cls(figure=key, label=label, better=better, n=n, unit=unit, note=note)

    def values_only(self) -> Evidence:
        """Return the values without interval, test and effect size."""
        nan = math.nan
        return replace(self, low=nan, high=nan, p=nan, least_p=nan, effect=nan, method="")


COLUMNS: Final = tuple(field.name for field in fields(Evidence))


def significance_table(
    result: Result,
    extra: Sequence[Judged] = (),
    *,
    keys: Sequence[str] | None = None,
    units: Units | None = None,
    shifts: Mapping[str, np.ndarray] = MappingProxyType({}),
    primary: str | None = None,
    has_intervals: bool = True,
) -> pd.DataFrame:
    """Test the scorecard's measures: interval, p-value and effect size.

    `nvcore.evidence.table.evidence_table` adds the log-average miss rate. Encounters detected
    appear twice: by encounter (McNemar), which is only about these drives, and by units, which
    allows for similar encounters within a recording. They are followed by the other measures that
    `nvcore.comparison.measures.entry.Inference` tests by units (except those that do not apply,
    such as measures of urgent encounters if there are none), and by `extra`. If there are too few
    data for a measure, or most encounters are single frames, it is NaN and `note` has the reason.

    Parameters
    ----------
    extra
        Further measures.
    keys
        Some of `nvcore.comparison.measures.table.EVIDENCE_KEYS`; None: all that the comparison has.
    units
        ``find_units(result)``, if already computed.
    shifts
        See `run_together`.
    primary
        Key of the measure that is tested by itself. Empty: all measures are corrected for one
        another. None: the primary measure of the dataset's settings, unless it was changed.
    has_intervals
        False computes only p, which is much faster.

    Returns
    -------
    Columns `COLUMNS` (attributes of `Evidence`), one row per measure. p_corrected is NaN if another
    row tests the same hypothesis: McNemar's test repeats by encounters the test by recordings, and
    lost similarity is equivalent to mean similarity.

    Examples
    --------
    >>> significance_table(result)[["figure", "difference", "low", "high"]]  # doctest: +SKIP
    """
    units = find_units(result) if units is None else units
    keys = evidence_keys(result) if keys is None else keys
    keys = [key for key in keys if inference_of(key).test != "curve"]
    of_units = [measure for measure in unit_measures(result, units) if measure.key in keys]
    known = {of.evidence.figure: of.tested for of in extra if of.tested is not None}
    tests = run_together(of_units, shifts, known) if units.kind in WHOLE else {}
    rows = _judge(
        result, keys, of_units, units=units, tests=tests, shifts=shifts, has_intervals=has_intervals
    )
    table = pd.DataFrame([vars(row) for row in (*rows, *(of.evidence for of in extra))])
    if primary is None:
        own = primary_of(result.dataset)
        primary = "" if own.is_changed else own.key
    family = {key: of for key, of in tests.items() if not repeated_by(key) and _counts(result, key)}
    corrected = correct_together(family, primary)
    return table.assign(p_corrected=[corrected.get(key, np.nan) for key in table["figure"]])


def evidence_of(table: pd.DataFrame, key: str) -> Evidence | None:
    """Return a measure's row of such a table by its key, or None if it has none."""
    rows = table[table["figure"] == key]
    return None if rows.empty else Evidence(**{name: rows[name].iloc[0] for name in COLUMNS})


def primary_of(dataset: Dataset) -> Primary:
    """Return the primary measure for comparisons of these data.

    Raises
    ------
    ParameterError
        If the session names no measure on which a verdict can rest.
    """
    return choose_primary(dataset.primary, None)


def _counts(result: Result, key: str) -> bool:
    """Whether differences in a measure may be claimed at all."""
    return not (result.is_short and inference_of(key).needs_tracks)


def judge(
    result: Result, keys: Sequence[str], *, units: Units | None = None
) -> tuple[Evidence, ...]:
    """Return the evidence on some measures, each by itself: p is not corrected for the others.

    Parameters
    ----------
    keys
        Some of `nvcore.comparison.measures.table.EVIDENCE_KEYS`, except the log-average miss rate.
    units
        See `significance_table`.
    """
    units = find_units(result) if units is None else units
    return _judge(result, keys, unit_measures(result, units), units=units, has_intervals=True)


def _judge(
    result: Result,
    keys: Sequence[str],
    measures: Iterable[UnitMeasure],
    *,
    units: Units,
    tests: Mapping[str, MeasureTests] = MappingProxyType({}),
    shifts: Mapping[str, np.ndarray] = MappingProxyType({}),
    has_intervals: bool,
) -> tuple[Evidence, ...]:
    by_unit = {measure.key: measure for measure in measures}

    def judge_one(key: str) -> Evidence:
        inference = inference_of(key)
        if inference.test == "encounters":
            row = judge_encounters(result, key)
            row = row.values_only() if result.is_short else row
        else:
            row = judge_measure(
                by_unit[key],
                units,
                tested=tests.get(key),
                shift=shifts.get(key),
                has_interval=has_intervals,
            )
            row = with_mean_over_recordings(result, units, row)
        return with_doubt(result, row)

    return tuple(map(judge_one, keys))


def with_doubt(result: Result, row: Evidence) -> Evidence:
    """Add the reason why the row supports no claim, as known to the subjects of its measure."""
    return replace(row, doubt=doubt_of(result, measure_of(row.figure)))


def judge_encounters(result: Result, key: str = "encounters_detected") -> Evidence:
    """Test a share of encounters, encounter by encounter (McNemar's test).

    Parameters
    ----------
    key
        Key of a measure whose `nvcore.comparison.measures.entry.Inference` has a `split`.
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
    """Return the measures that are computed from sums over units."""
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


@dataclass(frozen=True, eq=False)
class MeasureTests:
    """Both tests of a measure over units.

    Attributes
    ----------
    exchange
        Exchange of X and Y unit by unit.
    skewed
        The studentised bootstrap, which allows for skew.
    """

    exchange: SwapTest
    skewed: StudentisedTest

    @property
    def p(self) -> float:
        """Larger p of the two, NaN if there is none."""
        has_p = np.isfinite(self.exchange.p)
        return float(np.fmax(self.exchange.p, self.skewed.p)) if has_p else np.nan


@dataclass(frozen=True, eq=False)
class Judged:
    """Measure judged by itself, for inclusion in a table of others.

    Attributes
    ----------
    evidence
        Evidence on the measure.
    tested
        Tests over all units; None if it was not tested.
    """

    evidence: Evidence
    tested: MeasureTests | None = None


def run_together(
    measures: Iterable[UnitMeasure],
    shifts: Mapping[str, np.ndarray] = MappingProxyType({}),
    known: Mapping[str, MeasureTests] = MappingProxyType({}),
) -> dict[str, MeasureTests]:
    """Test measures of the same recordings, all by the same exchanges and the same draws.

    Parameters
    ----------
    shifts
        Amount to subtract from each recording's part in the difference of a measure, by measure key
        (`nvcore.evidence.paired_tests.Paired`).
    known
        Existing tests, made without shifts.
    """
    every = [measure for measure in measures if measure.key not in known]
    if not every:
        return dict(known)
    paired = [Paired(of.x, of.y, of.statistic, shifts.get(of.key)) for of in every]
    exchanges = swap_tests(paired)
    parts = np.full((len(every[0].x), len(every)), np.nan)
    is_part = np.ones(parts.shape, dtype=bool)
    for column, (of, test) in enumerate(zip(paired, exchanges, strict=True)):
        if np.isfinite(test.p):
            is_part[:, column] = own = of.has_part
            share = np.count_nonzero(own) / len(own)
            values = pseudo_values(of.x[own], of.y[own], of.statistic)
            parts[own, column] = values - share * of.taken_off[own]
    skewed = studentised_tests(parts, is_part)
    tests = map(MeasureTests, exchanges, skewed)
    return {**dict(zip((of.key for of in every), tests, strict=True)), **known}


def correct_together(tests: Mapping[str, MeasureTests], primary: str) -> dict[str, float]:
    """Correct the p-values of measures that are tested together, NaN for measures without p.

    The primary measure is tested by itself. All others are claimed only if it is, and are corrected
    for one another (`nvcore.evidence.paired_tests.step_down`), so their corrected p is at least its
    p. At most 5 % of comparisons without a difference thus claim any at 5 %, provided that each
    test keeps its own level.

    Parameters
    ----------
    primary
        Key of the primary measure. If it has no p or is not among these measures, all are corrected
        for one another.

    References
    ----------
    Westfall and Krishen (2001), Optimally weighted, fixed sequence and gatekeeper multiple testing
    procedures, Journal of Statistical Planning and Inference 99:25.
    """
    known = {key: of for key, of in tests.items() if np.isfinite(of.p)}
    first = known[primary].p if primary in known else 0.0
    family = [key for key in known if key != primary]
    corrected = dict.fromkeys(tests, np.nan)
    if primary in known:
        corrected[primary] = first
    if family:
        p_together = np.fmax(*(_step_down(kind, known, family) for kind in ("exchange", "skewed")))
        corrected.update(zip(family, np.maximum(p_together, first).tolist(), strict=True))
    return corrected


def _step_down(
    kind: Literal["exchange", "skewed"], tests: Mapping[str, MeasureTests], family: Sequence[str]
) -> np.ndarray:
    """Return the corrected p of the measures by one of the tests, NaN if it has no p."""
    if kind == "exchange":
        of_kind = [tests[key].exchange for key in family]
        is_exact = of_kind[0].is_exact
        draws = np.column_stack([test.sizes for test in of_kind])
        p = np.array([test.p for test in of_kind])
        return step_down(draws, p, n_added=0 if is_exact else 1)
    corrected = np.full(len(family), np.nan)
    skewed = [tests[key].skewed for key in family]
    has_p = np.array([np.isfinite(test.p) for test in skewed])
    if has_p.any():
        draws = np.column_stack([test.t for test in skewed if np.isfinite(test.p)])
        p = np.array([test.p for test in skewed])[has_p]
        corrected[has_p] = np.minimum(2 * step_down(draws, p / 2, n_added=1), 1)
    return corrected


NOT_TESTED: Final = MeasureTests(
    SwapTest(np.nan, 0, 0, is_exact=False, seed=SEED, reason="", sizes=np.empty(0)),
    StudentisedTest(np.nan, np.empty(0)),
)
"""Tests of blocks of time, which have no p."""


def judge_measure(
    measure: UnitMeasure,
    units: Units,
    *,
    tested: MeasureTests | None = None,
    shift: np.ndarray | None = None,
    has_interval: bool = True,
) -> Evidence:
    """Compute a measure's difference with bootstrap interval, test and effect size.

    p is the larger of the exact exchange's (`swap_test`) and the studentised bootstrap's, which
    allows for skew. Blocks of time have no p.

    Parameters
    ----------
    tested
        Result of `run_together`; None: test this measure by itself.
    shift
        See `run_together`.
    """
    x, y, statistic = measure.x, measure.y, measure.statistic
    n_resamples = N_RESAMPLES if has_interval else 0
    interval = bootstrap_difference(
        x, y, statistic, shift=shift, n_resamples=n_resamples, units=units.kind
    )
    if units.kind not in WHOLE:
        tested = NOT_TESTED
    elif tested is None:
        of_key = {} if shift is None else {measure.key: shift}
        tested = run_together([measure], of_key)[measure.key]
    test, p_of_skewed, p = tested.exchange, tested.skewed.p, tested.p
    notes = [*dict.fromkeys((interval.reason, test.reason)), units.note]
    if test.p <= SIGNIFICANT < p:
        notes.append(
            "the recordings' differences are very skewed: a few large ones against many small ones"
        )
    has_evidence = np.isfinite(interval.low) or np.isfinite(p)
    return Evidence(
        figure=measure.key,
        label=measure.label,
        better=measure.better,
        x=interval.x,
        y=interval.y,
        difference=interval.difference,
        low=interval.low,
        high=interval.high,
        p=p,
        least_p=test.least_p,
        effect=_effect_size(measure) if has_evidence else np.nan,
        n=len(units),
        unit=units.kind,
        scope=units.scope,
        method=_unit_method(interval, test, p_of_skewed, units),
        note=_join(notes),
    )


def with_mean_over_recordings(result: Result, units: Units, row: Evidence) -> Evidence:
    """Fill in the values of a mean over recordings that cannot be split into blocks of time."""
    inference, by_recording = inference_of(row.figure), measure_of(row.figure).by_recording
    if inference.per != "share_of_recording" or units.kind in WHOLE:
        return row
    if inference.parts is None or by_recording is None or inference.parts(result, result.x):
        return row
    recordings = units.of_recording >= 0
    x, y = (float(by_recording(result, system)[recordings].mean()) for _, system in result.sides)
    note = _join([inference.not_in_blocks, units.note])
    return replace(row, x=x, y=y, difference=x - y, note=note)


def _effect_size(measure: UnitMeasure) -> float:
    """Compute Cohen's d_z from jackknife pseudo-values."""
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
