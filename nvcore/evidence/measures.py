"""Whether the difference between X and Y is more than chance: every figure with its evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.bootstrap import (
    N_RESAMPLES,
    BootstrapDifference,
    Statistic,
    bootstrap_difference,
    ratio,
)
from nvcore.evidence.paired_tests import McNemar, SwapTest, holm, mcnemar, swap_test
from nvcore.evidence.units import RECORDINGS, Units, find_units, sum_units

HIGHER: Final = "higher"
LOWER: Final = "lower"
D_Z: Final = "Cohen's d_z"
ODDS_RATIO: Final = "odds ratio"


@dataclass(frozen=True, eq=False)
class UnitFigure:
    """A figure that is a function of sums over units.

    Attributes
    ----------
    figure, label
        Key, and name with unit of measure for people.
    better
        ``higher`` or ``lower``.
    x, y
        Sums of each unit, shape (n_units, *columns); rows as numbered in `Units`.
    statistic
        The figure from such sums (`nvcore.evidence.bootstrap.Statistic`).
    """

    figure: str
    label: str
    better: str
    x: np.ndarray
    y: np.ndarray
    statistic: Statistic = ratio


@dataclass(frozen=True)
class Evidence:
    """What the data say about the difference X - Y in one figure.

    Attributes
    ----------
    figure, label, better
        Key, name with unit of measure, ``higher`` or ``lower``.
    x, y, difference
        The figure of both systems, and ``x - y``; NaN undefined.
    low, high
        95 % interval of the difference; NaN where none can be given.
    p
        Two-sided p-value; NaN where none can be given.
    effect, effect_name
        Size of the difference: Cohen's d_z (the difference over the standard deviation of the
        units' parts in it; positive where X is higher), or the odds ratio of discordant encounters
        (above 1 where X detects more). NaN for d_z where there is neither interval nor p-value.
    n, unit
        How many of what were compared: encounters, recordings, blocks.
    method
        How interval and p-value were made.
    note
        Why something is not given, and what the figures do not say.
    p_holm
        `p` by Holm's correction for all figures shown together.
    """

    figure: str
    label: str
    better: str
    x: float
    y: float
    difference: float
    low: float
    high: float
    p: float
    effect: float
    effect_name: str
    n: int
    unit: str
    method: str
    note: str
    p_holm: float = float("nan")

    @classmethod
    def undefined(
        cls, figure: str, label: str, better: str, *, unit: str, note: str, n: int = 0
    ) -> Evidence:
        """Evidence of a figure that these data do not have; `note` says why."""
        nan = float("nan")
        return cls(
            figure=figure, label=label, better=better, x=nan, y=nan, difference=nan, low=nan,
            high=nan, p=nan, effect=nan, effect_name=D_Z, n=n, unit=unit, method="", note=note,
        )  # fmt: skip

    def withheld(self) -> Evidence:
        """The figure alone: without interval, test and effect size."""
        nan = float("nan")
        return replace(self, low=nan, high=nan, p=nan, effect=nan, method="")


COLUMNS: Final = (
    "figure", "label", "better", "x", "y", "difference", "low", "high", "p", "p_holm", "effect",
    "effect_name", "n", "unit", "method", "note",
)  # fmt: skip


def significance_table(
    result: Result, extra: Sequence[Evidence] = (), *, units: Units | None = None
) -> pd.DataFrame:
    """The scorecard's figures with interval, p-value and effect size.

    `nvcore.evidence.table.evidence_table` has the log-average miss rate as well.

    Encounters detected come twice: every encounter for itself (McNemar), and by units, which
    allows for encounters of one recording being alike. Then mean similarity, share of low frames,
    saliency, false-alert episodes per hour, and `extra`. Where too little is known for a figure,
    or most encounters are single frames, it is NaN and `note` says so in words.

    Parameters
    ----------
    extra
        Further figures, which Holm's correction then allows for.
    units
        ``find_units(result)``, if known already.

    Returns
    -------
    Columns `COLUMNS` (attributes of `Evidence`), one row per figure. p_holm corrects for all of
    them.

    Examples
    --------
    >>> significance_table(result)[["figure", "difference", "low", "high"]]  # doctest: +SKIP
    """
    units = find_units(result) if units is None else units
    judged = [judge_figure(one, units) for one in unit_figures(result, units)]
    judged = [
        with_largest_events(result, units, row) if row.figure == "saliency" else row
        for row in judged
    ]
    encounters = judge_encounters_detected(result)
    rows = [encounters.withheld() if result.is_short else encounters, *judged, *extra]
    table = pd.DataFrame([vars(row) for row in rows])
    table["p_holm"] = holm(table["p"].to_numpy())
    return table[list(COLUMNS)]


def judge_encounters_detected(result: Result) -> Evidence:
    """Share of encounters detected, encounter by encounter: McNemar's test."""
    found = mcnemar(result.venn)
    notes = [found.reason]
    if result.is_short:
        notes.append(
            "most encounters are one frame long, so they are frames rather than persons, and not "
            "independent: go by the figure by recordings or blocks"
        )
    return Evidence(
        figure="encounters_detected", label="share of encounters detected", better=HIGHER,
        x=found.share_x, y=found.share_y, difference=found.difference, low=found.low,
        high=found.high, p=found.p, effect=found.odds_ratio, effect_name=ODDS_RATIO, n=found.n,
        unit="encounters", method=_mcnemar_method(found), note=_joined(notes),
    )  # fmt: skip


def _mcnemar_method(found: McNemar) -> str:
    parts = []
    if not np.isnan(found.low):
        parts.append("Newcombe's interval for paired shares")
    if not np.isnan(found.p):
        parts.append(f"exact McNemar test of {found.x_only} to {found.y_only}")
    return "; ".join(parts)


def unit_figures(result: Result, units: Units) -> tuple[UnitFigure, ...]:
    """The figures of the scorecard that are made from sums over units."""
    sums = sum_units(result, units)
    low, by = result.params.low, units.kind
    worst = "largest event" if result.params.saliency_aggregate == "max" else "sum of events"
    made = (
        ("encounters_detected_by_unit", f"share of encounters detected, by {by}", HIGHER,
         "detected", "n_encounters", 1.0),
        ("mean_similarity", "mean similarity", HIGHER, "similarity", "n_frames", 1.0),
        ("share_low", f"share of frames with similarity below {low:g}", LOWER,
         "low", "n_frames", 1.0),
        ("saliency", f"saliency of a recording, {worst} (s)", LOWER,
         "saliency", "share_of_recording", 1.0),
        ("false_alert_episodes_per_hour", "false-alert episodes per hour", LOWER,
         "episodes", "duration_s", 3600.0),
    )  # fmt: skip
    figures = []
    for key, label, better, above, below, factor in made:
        x, y = (
            np.column_stack([factor * sums[f"{above}_{letter}"], sums[below]]) for letter in "xy"
        )
        figures.append(UnitFigure(key, label, better, x, y))
    return tuple(figures)


def judge_figure(figure: UnitFigure, units: Units) -> Evidence:
    """Difference of a figure with bootstrap interval, permutation test and effect size."""
    interval = bootstrap_difference(figure.x, figure.y, figure.statistic)
    test = swap_test(figure.x, figure.y, figure.statistic)
    notes = [*dict.fromkeys((interval.reason, test.reason)), units.note]
    is_judged = np.isfinite(interval.low) or np.isfinite(test.p)
    return Evidence(
        figure=figure.figure, label=figure.label, better=figure.better, x=interval.x, y=interval.y,
        difference=interval.difference, low=interval.low, high=interval.high, p=test.p,
        effect=_standardised(figure) if is_judged else np.nan, effect_name=D_Z, n=len(units),
        unit=units.kind, method=_unit_method(interval, test, units), note=_joined(notes),
    )  # fmt: skip


def with_largest_events(result: Result, units: Units, row: Evidence) -> Evidence:
    """The row of saliency, which blocks of time do not have if it is the largest event."""
    if units.kind == RECORDINGS or result.params.saliency_aggregate == "sum":
        return row
    used = np.unique(units.recording)
    x, y = (float(result.saliency_of_recordings(system)[used].mean()) for _, system in result.sides)
    note = "the largest event of a recording cannot be shared out to blocks of time"
    return replace(row, x=x, y=y, difference=x - y, note=_joined([note, units.note]))


def _standardised(figure: UnitFigure) -> float:
    """Cohen's d_z from jackknife pseudo-values.

    For a mean over units of equal weight that is the mean of their differences over the standard
    deviation; for other figures each unit counts by what leaving it out changes.
    """
    x, y, n = figure.x, figure.y, len(figure.x)
    if n < 2:
        return float("nan")
    difference = float(figure.statistic(x.sum(axis=0)) - figure.statistic(y.sum(axis=0)))
    without = figure.statistic(x.sum(axis=0) - x) - figure.statistic(y.sum(axis=0) - y)
    spread = (n - 1) * float(without.std(ddof=1))
    # equal differences have a spread of a rounding error, not always 0
    if not spread > 1e-9 * abs(difference):
        return float("nan")
    return difference / spread


def _unit_method(interval: BootstrapDifference, test: SwapTest, units: Units) -> str:
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
        parts.append(f"X and Y exchanged within {where}, in {ways} ways")
    return "; ".join(parts)


def _joined(notes: Sequence[str]) -> str:
    return "; ".join(note for note in notes if note)
