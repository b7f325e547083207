"""The comparison at equal false alarms that a verdict rests on, as rows, words and JSON."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.operating_points import EqualAlarms, are_unequal
from nvcore.evidence.table import evidence_table
from nvcore.measures.table import MEASURES
from nvcore.protocols import PROTOCOLS, Protocol
from nvcore.schema import Category
from nvcore.tables.scorecard import ScoreRow, score_rows
from nvcore.tables.summary import system_summary

COUNTED: Final = {
    Category.BOTH: "both",
    Category.X_ONLY: "only X",
    Category.Y_ONLY: "only Y",
    Category.NEITHER: "neither",
}


def equal_alarms_of(result: Result, companions: Companions | None) -> EqualAlarms | None:
    """The comparison that the verdict is about instead of the one as set; None: there is none."""
    return companions.equal if companions is not None and are_unequal(result) else None


def short_rows(result: Result) -> list[ScoreRow]:
    """The scorecard in short."""
    return score_rows(result, keys=[measure.key for measure in MEASURES if measure.leads])


def detected_text(result: Result) -> str:
    """Encounters by who detects them: "both 22, only X 8, only Y 5, neither 3"."""
    counts = result.venn.counts()
    return ", ".join(f"{words} {counts[kind]}" for kind, words in COUNTED.items())


def weights_text(result: Result) -> str:
    """What each system's failures weigh, by who detects the encounter; adds up to the severity."""
    x, y = (result.severity_of(system) for _, system in result.sides)
    parts = [
        f"{words}: X misses {x[kind]:.2f} s and Y {y[kind]:.2f} s"
        for kind, words in COUNTED.items()
    ]
    return "; ".join(parts)


def unequal_companions(
    result: Result,
    protocol: Protocol = PROTOCOLS["all"],
    *,
    evidence: pd.DataFrame | None = None,
) -> Companions | None:
    """The companions where X and Y are set to different operating points; else None.

    Parameters
    ----------
    protocol
        Which pedestrians count in the log-average miss rate.
    evidence
        ``evidence_table(result, protocol)``, if already computed.
    """
    if not are_unequal(result):
        return None
    if evidence is None:
        evidence = evidence_table(result, protocol)
    return find_companions(result, evidence, protocol)


def at_equal_alarms(companions: Companions | None) -> dict[str, Any] | None:
    """Every number of the comparison at equal false alarms, for ``summary.json``.

    Parameters
    ----------
    companions
        Of a comparison at unequal operating points; None: of another one.
    """
    if companions is None or companions.equal is None or companions.evidence is None:
        return None
    equal = companions.equal.result
    weights = {letter: equal.severity_of(system) for letter, system in equal.sides}
    return {
        "moved": companions.equal.moved,
        **{letter: system_summary(equal, system) for letter, system in equal.sides},
        "venn": {kind.value: equal.venn.counts()[kind.value] for kind in COUNTED},
        "venn_severity_s": {
            f"{kind.value}_{letter}": weights[letter][kind] for kind in COUNTED for letter in "xy"
        },
        "evidence": {
            str(row["figure"]): {
                name: None if np.isnan(row[name]) else row[name]
                for name in ("x", "y", "difference", "low", "high", "p", "p_corrected")
            }
            for row in companions.evidence.to_dict("records")
        },
    }
