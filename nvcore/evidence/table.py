"""Every measure with its evidence, for the verdict, the dashboard and the reports."""

from __future__ import annotations

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.measures import Judged, significance_table
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.operating_points import is_undecided
from nvcore.evidence.units import Units, find_units
from nvcore.protocols import PROTOCOLS, Protocol
from nvcore.sentences.texts import AS_SET


def evidence_table(
    result: Result,
    protocol: Protocol = PROTOCOLS["all"],
    *,
    units: Units | None = None,
    miss_rate: Judged | None = None,
    primary: str | None = None,
    has_intervals: bool = True,
) -> pd.DataFrame:
    """`nvcore.evidence.measures.significance_table` with the log-average miss rate as its last row.

    The note of each measure that depends on unequal operating points says so.

    Parameters
    ----------
    protocol
        Which pedestrians count in the log-average miss rate.
    units, miss_rate
        ``find_units(result)``, ``judge_miss_rate(result, units, protocol)``, if already computed.
    primary
        As of `significance_table`.
    has_intervals
        Without them, p alone: much faster.

    Examples
    --------
    >>> evidence_table(result)[["label", "difference", "p_corrected"]]  # doctest: +SKIP
    """
    units = find_units(result) if units is None else units
    if miss_rate is None:
        miss_rate = judge_miss_rate(result, units, protocol, has_interval=has_intervals)
    table = significance_table(
        result, [miss_rate], units=units, primary=primary, has_intervals=has_intervals
    )
    return mark_undecided(result, table)


def mark_undecided(result: Result, table: pd.DataFrame) -> pd.DataFrame:
    """The table of evidence, with notes on what is undecided and what is in doubt.

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
