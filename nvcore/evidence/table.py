"""Table of evidence on every measure, for the verdict, the dashboard and the reports."""

from __future__ import annotations

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.evidence.companions import Companions, find_companions, judge_equal_alarms
from nvcore.evidence.measures import Judged, significance_table
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.operating_points import AS_SET, is_undecided
from nvcore.evidence.units import Units, find_units
from nvcore.settings.protocols import PROTOCOLS, Protocol


def evidence_table(
    result: Result,
    protocol: Protocol = PROTOCOLS["all"],
    *,
    units: Units | None = None,
    miss_rate: Judged | None = None,
    primary: str | None = None,
    has_intervals: bool = True,
) -> pd.DataFrame:
    """Return the evidence on every measure, the log-average miss rate last.

    Columns are those of `nvcore.evidence.measures.significance_table`. A comparison at equal false
    alarms uses `nvcore.evidence.companions.judge_equal_alarms`. At unequal operating points, the
    note of each measure that depends on them says so.

    Parameters
    ----------
    protocol
        Selection of the pedestrians that count in the log-average miss rate.
    units, miss_rate
        ``find_units(result)``, ``judge_miss_rate(result, units, protocol)``, if already computed.
    primary
        See `significance_table`.
    has_intervals
        False computes only p, which is much faster.

    Examples
    --------
    >>> evidence_table(result)[["label", "difference", "p_corrected"]]  # doctest: +SKIP
    """
    units = find_units(result) if units is None else units
    if miss_rate is None:
        miss_rate = judge_miss_rate(result, units, protocol, has_interval=has_intervals)
    judge = significance_table if result.as_set is None else judge_equal_alarms
    table = judge(result, [miss_rate], units=units, primary=primary, has_intervals=has_intervals)
    return mark_undecided(result, table)


def judge_both(
    result: Result, protocol: Protocol = PROTOCOLS["all"], *, has_intervals: bool = True
) -> tuple[pd.DataFrame, Companions]:
    """Return the `evidence_table` of a comparison, and its companions (`find_companions`)."""
    units = find_units(result)
    miss_rate = judge_miss_rate(result, units, protocol, has_interval=has_intervals)
    evidence = evidence_table(
        result, protocol, units=units, miss_rate=miss_rate, has_intervals=has_intervals
    )
    return evidence, find_companions(result, evidence, protocol, miss_rate=miss_rate)


def mark_undecided(result: Result, table: pd.DataFrame) -> pd.DataFrame:
    """Add notes on undecided and doubtful measures to the table of evidence.

    A measure is undecided if it depends on operating points and these are unequal.

    Parameters
    ----------
    table
        With columns figure, label, difference and note, and doubt if it has some.
    """
    is_defined = np.isfinite(table["difference"].to_numpy(dtype=float))
    doubts = table["doubt"] if "doubt" in table else [""] * len(table)
    notes = [
        "; ".join(
            filter(
                None,
                (
                    note,
                    AS_SET if has and is_undecided(result, key) else "",
                    f"no claim: {doubt}" if has and doubt else "",
                ),
            )
        )
        for key, has, note, doubt in zip(
            table["figure"], is_defined, table["note"], doubts, strict=True
        )
    ]
    return table.assign(note=notes)
