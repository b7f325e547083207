"""Comparison of every pair of systems of a dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.progress import Progress, no_progress
from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.evidence.claims import find_claims, values_of
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.measures import Evidence, judge, judge_encounters
from nvcore.evidence.operating_points import are_unequal, why_not_equal
from nvcore.evidence.paired_tests import SIGNIFICANT, holm
from nvcore.evidence.units import find_units
from nvcore.notes import Note, phrase
from nvcore.settings.params import Params

COLUMNS: Final = (
    "x",
    "y",
    "threshold_x",
    "threshold_y",
    "false_alarms_per_frame_x",
    "false_alarms_per_frame_y",
    "is_unequal",
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
    "mcnemar_note",
    "n_units",
    "unit",
    "detected_by_unit_low",
    "detected_by_unit_high",
    "detected_by_unit_p",
    "detected_by_unit_p_holm",
    "detected_by_unit_note",
    "similarity_x",
    "similarity_y",
    "similarity_difference",
    "similarity_low",
    "similarity_high",
    "similarity_p",
    "similarity_p_holm",
    "similarity_note",
    "detects_more",
    "higher_similarity",
    "withheld",
)
CORRECTED: Final = ("detected_by_unit_p", "similarity_p")
CLAIMED: Final = {
    "encounters_detected_by_unit": "detects_more",
    "mean_similarity": "higher_similarity",
}
"""Columns for the better system of a pair, by measure."""


SYSTEM_COLUMNS: Final = ("system", "threshold", "false_alarms_per_frame", "detected", "similarity")


def thresholds_in_use(dataset: Dataset, params: Params) -> dict[str, float | None]:
    """Return each system's threshold: that of the parameters for X and Y, else its own.

    Parameters
    ----------
    params
        The live parameters, or ``dataset.params_of()``.
    """
    own = dict(zip(dataset.systems, dataset.settings.thresholds, strict=False))
    live = zip(dataset.compared(), (params.threshold_x, params.threshold_y), strict=True)
    return own | {name: threshold for name, threshold in live if name is not None}


def pairwise_table(
    dataset: Dataset,
    params: Params | None = None,
    *,
    systems: Sequence[str] | None = None,
    thresholds: Mapping[str, float | None] | None = None,
    progress: Progress = no_progress,
) -> pd.DataFrame:
    """Compare detections and similarity of every two systems.

    Parameters
    ----------
    params
        Settings; the thresholds of X and Y are not used.
    systems
        Names. The earlier system of a pair is X. None: all systems of the dataset.
    thresholds
        Score threshold of each system. Every detection counts for a system without one.

    Returns
    -------
    Columns `COLUMNS`, one row per pair: shares of encounters detected with interval and exact
    McNemar p, both within these recordings; interval and p of the same difference by units
    (recordings; blocks of time have no p); mean similarity, 1 is best, with interval and p. Holm's
    method corrects the p by units of both measures together over the pairs. Differences are X - Y.
    NaN is undefined, and `mcnemar_note`, `detected_by_unit_note` and `similarity_note` give the
    reason.

    At unequal operating points (`is_unequal`), p and its note refer to the pair at equal false
    alarms. All other numbers are as set.

    `detects_more` and `higher_similarity` name the system that may be claimed to be better, or are
    empty. The rules are those of `nvcore.evidence.claims.find_claims`, with p corrected over the
    pairs, as set and at equal false alarms. `withheld` says why a small enough p is no claim.

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
    pairs = list(combinations(names, 2))
    rows, judged, previous = [], [], None
    for number, (x, y) in enumerate(pairs):  # a loop over pairs of systems
        progress(0.6 * number / len(pairs), "comparing every two systems")
        setting = replace(params, threshold_x=thresholds.get(x), threshold_y=thresholds.get(y))
        previous = compare(dataset, setting, x=x, y=y, previous=previous)
        row, evidence = _row(previous)
        rows.append(row)
        judged.append(evidence)
    table = pd.DataFrame(rows)
    p = table[list(CORRECTED)].to_numpy(dtype=float).T
    corrected = _holm_over_pairs(p)
    for column, of_column in zip(CORRECTED, corrected, strict=True):
        table[f"{column}_holm"] = of_column
    is_small = corrected <= SIGNIFICANT
    tried: dict[int, tuple[Result, Companions]] = {}
    # a claim has to hold at equal false alarms, too: p of the same difference there
    largest = np.where(is_small | np.isnan(p), p, 1.0)
    for number in map(int, np.flatnonzero(is_small.any(axis=0))):
        progress(0.6 + 0.4 * number / len(pairs), "comparing at equal false alarms")
        x, y = pairs[number]
        setting = replace(params, threshold_x=thresholds.get(x), threshold_y=thresholds.get(y))
        previous = compare(dataset, setting, x=x, y=y, previous=previous)
        as_set = _evidence(judged[number], corrected[:, number])
        companions = find_companions(previous, as_set, primary="", is_graded=False)
        tried[number] = previous, companions
        if companions.evidence is not None:
            largest[:, number] = np.fmax(largest[:, number], companions.evidence["p"])
    decisive = _holm_over_pairs(largest)
    for number, (result, companions) in tried.items():
        as_set = _evidence(judged[number], corrected[:, number])
        claims = _claims(result, as_set, companions, decisive[:, number])
        table.loc[number, list(claims)] = list(claims.values())
    return table[list(COLUMNS)]


def systems_of(table: pd.DataFrame) -> pd.DataFrame:
    """Return one row per system of a `pairwise_table`, with the columns `SYSTEM_COLUMNS`."""
    sides = [
        table[[letter, *(f"{name}_{letter}" for name in SYSTEM_COLUMNS[1:])]].set_axis(
            list(SYSTEM_COLUMNS), axis=1
        )
        for letter in "xy"
    ]
    return pd.concat(sides).drop_duplicates("system", ignore_index=True)


def _row(result: Result) -> tuple[dict[str, Any], tuple[Evidence, Evidence]]:
    """Return a pair's row without corrected p-values, and the evidence on `CLAIMED` measures."""
    units = find_units(result)
    split = judge_encounters(result)
    split = split.values_only() if result.is_short else split
    by_unit, similarity = judge(result, tuple(CLAIMED), units=units)
    alarms = values_of("false_alarms_per_frame", result)
    tested = [(of.p, of.note) for of in (by_unit, similarity)]
    if are_unequal(result):
        judged = _evidence((by_unit, similarity))
        at_equal = find_companions(result, judged, primary="", is_graded=False).evidence
        if at_equal is None:
            why = why_not_equal(result)
            tested = [(np.nan, f"{note}; {why}" if note else why) for _, note in tested]
        else:
            tested = [*zip(at_equal["p"], at_equal["note"], strict=True)]
    (p_by_unit, note_by_unit), (p_similarity, note_of_similarity) = tested
    row = {
        "x": result.x.name,
        "y": result.y.name,
        "threshold_x": _number(result.x.threshold),
        "threshold_y": _number(result.y.threshold),
        "false_alarms_per_frame_x": alarms[0],
        "false_alarms_per_frame_y": alarms[1],
        "is_unequal": are_unequal(result),
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
        "mcnemar_note": split.note,
        "n_units": len(units),
        "unit": units.kind,
        "detected_by_unit_low": by_unit.low,
        "detected_by_unit_high": by_unit.high,
        "detected_by_unit_p": p_by_unit,
        "detected_by_unit_note": _note(note_by_unit),
        "similarity_x": similarity.x,
        "similarity_y": similarity.y,
        "similarity_difference": similarity.difference,
        "similarity_low": similarity.low,
        "similarity_high": similarity.high,
        "similarity_p": p_similarity,
        "similarity_note": _note(note_of_similarity),
        **dict.fromkeys((*CLAIMED.values(), "withheld"), ""),
    }
    return row, (by_unit, similarity)


def _holm_over_pairs(p: np.ndarray) -> np.ndarray:
    """Correct p over measures and pairs by Holm's method, shape (n_measures, n_pairs)."""
    return holm(p.ravel()).reshape(p.shape)


def _claims(
    result: Result, evidence: pd.DataFrame, companions: Companions, p_at_equal: np.ndarray
) -> dict[str, str]:
    """Return a pair's `CLAIMED` columns with the better system, and `withheld` with reasons.

    Parameters
    ----------
    evidence
        Evidence as set, with p corrected over the pairs.
    p_at_equal
        P of the measures at equal false alarms, corrected over the pairs.
    """
    if companions.evidence is not None:
        at_equal = companions.evidence.assign(p_corrected=p_at_equal)
        companions = replace(companions, evidence=at_equal)
    support = find_claims(result, evidence, companions)
    names = {letter: system.name for letter, system in result.sides}
    better = {CLAIMED[claim.key]: names[claim.winner] for claim in support.claims}
    reasons = [
        phrase(
            Note("verdict.unclaimed_of_pair", key=key, reason=_by_name(why, names)), result.objects
        )
        for key, why in support.withheld.items()
    ]
    return {**better, "withheld": "; ".join(reasons)}


def _by_name(why: Note, names: Mapping[str, str]) -> Note:
    """Return the reason with the winner's name in its `winner` field, instead of X or Y."""
    winner = names.get(why.fields.get("winner", ""))
    return Note(why.key, **{**why.fields, "winner": winner})


def _evidence(rows: Sequence[Evidence], p_corrected: np.ndarray | float = np.nan) -> pd.DataFrame:
    return pd.DataFrame([vars(row) for row in rows]).assign(p_corrected=p_corrected)


def _number(threshold: float | None) -> float:
    return np.nan if threshold is None else threshold


def _note(text: str) -> str:
    """Return a reason for a missing interval or p, with "the two" in place of "X and Y"."""
    return text.replace("X and Y", "the two")
