"""How many open cases would have to be wrong truth to turn the verdict."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import inference_of, measure_of
from nvcore.comparison.scoring import SystemResult
from nvcore.evidence.measures import UnitMeasure, primary_of, run_together
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.units import WHOLE, find_units
from nvcore.subjects.review.cases import CaseKind, CaseList
from nvcore.subjects.review.decisions import LEAVES_OUT, decided

MOST_TRIED: Final = 12
"""Number of open cases tried at each step of the search for the claim, the weightiest first."""

PER_ENCOUNTER: Final[Mapping[str, Callable[[SystemResult], np.ndarray]]] = {
    "severity_s_per_encounter": lambda of: of.failures["severity_s"].to_numpy(),
    "encounters_detected_by_unit": lambda of: of.encounters["is_detected"].to_numpy(float),
}
"""Part of each encounter in the measures that are means over encounters."""


class Robustness(NamedTuple):
    """Open cases that would have to be wrong truth to turn a measure.

    Attributes
    ----------
    measure
        Key of the measure.
    turns_sign
        Cases (rows) without which the leader no longer leads: the fewest there are. None: no number
        of open cases does it.
    turns_claim
        Cases without which p is above 0.05. A greedy search finds them, so fewer may do it. Empty
        if p is above 0.05 already; None: no number of open cases does it, or there is no p.
    """

    measure: str
    turns_sign: tuple[int, ...] | None
    turns_claim: tuple[int, ...] | None


def find_robustness(
    result: Result,
    cases: CaseList,
    is_open: np.ndarray,
    measure: str,
    *,
    is_left_out: np.ndarray | None = None,
) -> Robustness | None:
    """Search the fewest open misses that would turn the sign of a difference, or its claim.

    Parameters
    ----------
    is_open
        Cases on which nothing is decided; bool, shape (n_cases,).
    measure
        Key of a measure.
    is_left_out
        Cases that the review leaves out already; bool, shape (n_cases,). None: none.

    Returns
    -------
    None if the measure is not a mean over encounters (`PER_ENCOUNTER`), or X and Y are equal.
    """
    of_encounter = PER_ENCOUNTER.get(measure)
    if of_encounter is None:
        return None
    x, y = (of_encounter(system) for _, system in result.sides)
    is_miss = (cases.table["kind"] == CaseKind.MISS).to_numpy()
    encounter = cases.table["encounter"].to_numpy()
    counts = result.is_near.copy()
    if is_left_out is not None:
        counts[encounter[is_left_out & is_miss]] = False
    total = float((x - y)[counts].sum())
    if not total:
        return None
    candidates = np.flatnonzero(is_open & is_miss)
    candidates = candidates[counts[encounter[candidates]]]
    lead = (x - y)[encounter[candidates]] * np.sign(total)
    order = np.argsort(-lead, kind="stable")
    order = order[lead[order] > 0]
    candidates, lead = candidates[order], lead[order]
    left = abs(total) - np.cumsum(lead)
    n_sign = int(np.searchsorted(-left, -1e-12 * abs(total)))
    turns_sign = tuple(candidates[: n_sign + 1].tolist()) if n_sign < len(left) else None
    p_without = _tester(result, measure, x, y, counts)
    turns_claim = _search_claim(candidates.tolist(), encounter, p_without)
    return Robustness(measure, turns_sign, turns_claim)


def primary_robustness(
    result: Result, cases: CaseList, decisions: pd.DataFrame
) -> Robustness | None:
    """Search the fewest open misses that would turn the primary measure after the review."""
    key = primary_of(result.dataset).key
    measure = next((of for of in PER_ENCOUNTER if of.startswith(key)), key)
    states = decided(cases, decisions)
    return find_robustness(
        *(result, cases, ~states["is_done"].to_numpy(bool), measure),
        is_left_out=states["decision"].isin(LEAVES_OUT).to_numpy(bool),
    )


def _search_claim(
    candidates: list[int], encounter: np.ndarray, p_without: Callable[[Collection[int]], float]
) -> tuple[int, ...] | None:
    """Leave out one case after the other, each time the one that raises p most."""
    chosen: list[int] = []
    p = p_without(())
    while p <= SIGNIFICANT and candidates:
        tried = candidates[:MOST_TRIED]
        ps = [p_without(encounter[[*chosen, case]].tolist()) for case in tried]
        best = int(np.argmax(ps))
        chosen.append(tried[best])
        candidates = [case for case in candidates if case != tried[best]]
        p = ps[best]
    return None if p <= SIGNIFICANT or np.isnan(p) else tuple(chosen)


def _tester(
    result: Result, measure: str, x: np.ndarray, y: np.ndarray, counts: np.ndarray
) -> Callable[[Collection[int]], float]:
    """Return a function that gives p of the difference without some encounters that count."""
    units = find_units(result)
    unit = units.unit_of_frame[result.encounters.first_row]
    assert inference_of(measure).per == "n_encounters"

    def p_without(encounters: Collection[int]) -> float:
        if units.kind not in WHOLE:
            return float("nan")
        is_in = counts.copy()
        is_in[list(encounters)] = False
        own, count = unit[is_in], units.total(unit[is_in])
        sums_x, sums_y = (np.column_stack([units.total(own, of[is_in]), count]) for of in (x, y))
        made = UnitMeasure(measure, "", measure_of(measure).better, sums_x, sums_y)
        return run_together([made])[measure].p

    return p_without
