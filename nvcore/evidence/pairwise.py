"""Every two systems of a dataset against each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, Final

import pandas as pd

from nvcore.comparison import Result, compare
from nvcore.dataset import Dataset
from nvcore.errors import InputError
from nvcore.evidence.measures import (
    Evidence,
    judge_encounters,
    judge_measure,
    unit_measures,
)
from nvcore.evidence.paired_tests import holm
from nvcore.evidence.units import find_units
from nvcore.params import Params

COLUMNS: Final = (
    "x",
    "y",
    "n_encounters",
    "x_only",
    "y_only",
    "detected_x",
    "detected_y",
    "difference",
    "low",
    "high",
    "odds_ratio",
    "mcnemar_p",
    "n_units",
    "unit",
    "detected_by_unit_low",
    "detected_by_unit_high",
    "detected_by_unit_p",
    "detected_by_unit_p_holm",
    "similarity_x",
    "similarity_y",
    "similarity_difference",
    "similarity_low",
    "similarity_high",
    "similarity_p",
    "similarity_p_holm",
    "note",
)
CORRECTED: Final = ("detected_by_unit_p", "similarity_p")


def pairwise_table(
    dataset: Dataset,
    params: Params | None = None,
    *,
    systems: Sequence[str] | None = None,
    thresholds: Mapping[str, float | None] | None = None,
) -> pd.DataFrame:
    """Who detects more, and who has the higher similarity, for every two systems.

    Parameters
    ----------
    params
        Settings; the thresholds of X and Y are not used.
    systems
        Names; the earlier of a pair is X; None: all of the dataset.
    thresholds
        Score threshold of each system; without one every detection counts.

    Returns
    -------
    Columns `COLUMNS`, one row per pair: shares of encounters detected with interval and exact
    McNemar p, both within these recordings; interval and p of the same difference by units
    (recordings; blocks of time have no p); mean similarity, 1 is best, with interval and p. Holm
    corrects the p by units of both measures together over the pairs.
    All differences are X - Y. NaN: undefined, `note` says why.

    Raises
    ------
    InputError
        If there are fewer than two systems, an unknown one, or the same one twice.
    """
    params = params or Params()
    names = tuple(dataset.systems if systems is None else systems)
    thresholds = dict(thresholds or {})
    if len(names) < 2 or len(set(names)) < len(names):
        raise InputError(
            "a comparison in pairs needs two systems or more, each once; given: "
            f"{', '.join(names) or 'none'}"
        )
    for name in (*names, *thresholds):
        dataset.system(name)
    rows, previous = [], None
    for x, y in combinations(names, 2):  # a loop over pairs of systems
        setting = replace(params, threshold_x=thresholds.get(x), threshold_y=thresholds.get(y))
        previous = compare(dataset, setting, x=x, y=y, previous=previous)
        rows.append(_row(previous))
    table = pd.DataFrame(rows)
    p_holm = holm(table[list(CORRECTED)].to_numpy(dtype=float).T.ravel())
    for column, of_column in zip(CORRECTED, p_holm.reshape(len(CORRECTED), -1), strict=True):
        table[f"{column}_holm"] = of_column
    return table[list(COLUMNS)]


def _row(result: Result) -> dict[str, Any]:
    units = find_units(result)
    measures = {measure.key: measure for measure in unit_measures(result, units)}
    split = judge_encounters(result)
    split = split.values_only() if result.is_short else split
    by_unit = judge_measure(measures["encounters_detected_by_unit"], units)
    similarity = judge_measure(measures["mean_similarity"], units)
    return {
        "x": result.x.name,
        "y": result.y.name,
        "n_encounters": result.venn.n_near,
        "x_only": result.venn.x_only,
        "y_only": result.venn.y_only,
        "detected_x": split.x,
        "detected_y": split.y,
        "difference": split.difference,
        "low": split.low,
        "high": split.high,
        "odds_ratio": split.effect,
        "mcnemar_p": split.p,
        "n_units": len(units),
        "unit": units.kind,
        "detected_by_unit_low": by_unit.low,
        "detected_by_unit_high": by_unit.high,
        "detected_by_unit_p": by_unit.p,
        "similarity_x": similarity.x,
        "similarity_y": similarity.y,
        "similarity_difference": similarity.difference,
        "similarity_low": similarity.low,
        "similarity_high": similarity.high,
        "similarity_p": similarity.p,
        "note": _note(split, by_unit, similarity),
    }


def _note(*evidence: Evidence) -> str:
    notes = (part for row in evidence for part in row.note.split("; "))
    return "; ".join(part for part in dict.fromkeys(notes) if part)
