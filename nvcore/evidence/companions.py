"""Comparisons beside the one as set, without which it may mislead: at equal false alarms, strict.

A system with a lower threshold detects more and has more false alarms, and false alarms near a
missed pedestrian raise similarity. So whatever a verdict claims has to hold where both systems have
equally many false alarms, and when boxes are paired strictly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Final, Literal

import numpy as np
import pandas as pd

from nvcore.comparison import Result, compare
from nvcore.detection.operating_point import (
    are_unequal_alarms,
    choose_moved,
    threshold_with_alarms,
)
from nvcore.evidence.measures import Evidence, significance_table
from nvcore.evidence.miss_rate import KEY as MISS_RATE
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.measures import inference_of
from nvcore.scoring import SystemResult
from nvcore.wording import capitalised

AS_SET: Final = "as set: at unequal operating points"
"""What marks numbers of X and Y that nothing is claimed from."""

STRICT_KEYS: Final = ("mean_similarity", "saliency")
"""Measures that strict pairing changes."""
STANDARD_ERRORS: Final = 1.96
"""By so many, the systems' false alarms may be apart where they are counted as equal. With 0,
verdicts claimed a difference in 17 % of pairs of equal systems (16 recordings)."""


@dataclass(frozen=True, eq=False)
class Companions:
    """The same two systems at equal false alarms, and paired strictly.

    Numbers of false alarms that are equal in these recordings need not be in others, and a number
    holds for a range of thresholds. So a claim has to hold where the thresholds are at the end of
    what may pass for equal that is worst for the system that it favours.

    Attributes
    ----------
    equal
        Both at equal false alarms, the threshold about as low as these allow; None: no threshold
        gives them, or it is not asked: X and Y are set alike, and no difference could be claimed.
    moved
        System with another threshold in `equal`, ``x`` or ``y``; empty: neither.
    evidence
        Evidence at both ends of what may pass for equal. It has intervals where X and Y are set to
        different operating points. Empty without `equal`.
    strict
        The comparison that the verdict rests on (`equal` where the one as set is unequal), with
        ``pairing="matched"``.
    of_equal
        Evidence of `equal` itself, with intervals; None where `equal` only confirms the comparison
        as set.
    """

    equal: Result | None
    moved: str
    evidence: tuple[pd.DataFrame, ...]
    strict: Result
    of_equal: pd.DataFrame | None = None

    @property
    def weaker_evidence(self) -> pd.DataFrame:
        """The evidence of `equal`, as weak as anywhere in what may pass for equal.

        p and corrected p are the larger ones of both ends, and intervals reach over those of
        `equal` and of both ends. NaN where an end has none.
        """
        assert self.of_equal is not None
        tables = (self.of_equal, *self.evidence)

        def of_all(extreme: np.ufunc, name: str, tables: Sequence[pd.DataFrame]) -> np.ndarray:
            ends: np.ndarray = extreme.reduce([table[name].to_numpy() for table in tables])
            return ends

        return self.of_equal.assign(
            p=of_all(np.maximum, "p", self.evidence),
            p_holm=of_all(np.maximum, "p_holm", self.evidence),
            low=of_all(np.minimum, "low", tables),
            high=of_all(np.maximum, "high", tables),
        )

    @property
    def setting(self) -> str:
        """How X and Y are set in `equal`: "X with scores of 0.6 or more, 0.05 per frame"."""
        assert self.equal is not None
        per_frame = count_alarms(self.equal.x) / max(len(self.equal.dataset.frames), 1)
        threshold = self.equal.system(self.moved).threshold
        at = "with all detections" if threshold is None else f"with scores of {threshold:g} or more"
        return f"{self.moved.upper()} {at}, {per_frame:.3g} per frame"


def count_alarms(system: SystemResult) -> int:
    """False alarms of a system, 0 is best."""
    return int(system.false_alarms.sum())


def are_unequal(result: Result) -> bool:
    """Whether X and Y are set to different operating points, so that neither can be preferred."""
    n_x, n_y = (count_alarms(system) for _, system in result.sides)
    return are_unequal_alarms(n_x, n_y)


def describe_alarms(result: Result) -> str:
    """False alarms of both, such as "X has 0.05 and Y 0.3 false alarms per frame"."""
    n_frames = max(len(result.dataset.frames), 1)
    x, y = (f"{count_alarms(system) / n_frames:.3g}" for _, system in result.sides)
    return f"X has {x} and Y {y} false alarms per frame"


def as_set_note(result: Result) -> str:
    """What stands above numbers of X and Y at unequal operating points; empty: they are equal."""
    if not are_unequal(result):
        return ""
    return f"{capitalised(AS_SET)} ({describe_alarms(result)}). Nothing is claimed from these."


def is_undecided(result: Result, key: str) -> bool:
    """Whether unequal operating points forbid conclusions from a measure of `EVIDENCE_KEYS`.

    Detection curves run over all thresholds, so their measures do not depend on those in use.
    """
    return inference_of(key).test != "curve" and are_unequal(result)


def has_scores(result: Result, letter: str) -> bool:
    """Whether a threshold could move this system."""
    return bool(np.isfinite(result.dataset.system(result.system(letter).name).score).any())


def find_companions(result: Result, evidence: pd.DataFrame) -> Companions:
    """The companions of a comparison, made from its own stages.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result; its miss rate does not depend on
        thresholds and is taken over.
    """
    is_unequal = are_unequal(result)
    has_candidates = bool((evidence["p_holm"] <= SIGNIFICANT).any())
    moved = which_moves(result) if is_unequal or has_candidates else ""
    equal = _at_equal_alarms(result, moved) if moved else None
    if equal is not None and are_unequal(equal):
        equal = None
    basis = equal if equal is not None and is_unequal else result
    strict = basis
    if result.params.pairing != "matched":
        params = replace(basis.params, pairing="matched")
        strict = compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=basis)
    if equal is None:
        return Companions(None, "", (), strict)
    has_p = bool(np.isfinite(evidence["p_holm"]).any())
    ends = _ends(result, equal, moved) if has_p else [equal]
    miss_rates = _miss_rates(evidence)

    def judged(at_end: Result) -> pd.DataFrame:
        return significance_table(at_end, miss_rates, has_intervals=is_unequal)

    tables = tuple(judged(at_end) for at_end in ends)
    of_equal = None
    if is_unequal:
        of_equal = tables[0] if len(ends) == 1 else judged(equal)
    return Companions(equal, moved, tables, strict, of_equal)


def which_moves(result: Result) -> str:
    """The system whose threshold is moved; empty: none can be."""
    systems = [system for _, system in result.sides]
    index = choose_moved(
        [has_scores(result, letter) for letter, _ in result.sides],
        [count_alarms(system) for system in systems],
        [int(system.n_det.sum()) for system in systems],
    )
    return "" if index is None else "xy"[index]


def _ends(result: Result, equal: Result, moved: str) -> list[Result]:
    """The comparisons at equal false alarms that are worst for each system.

    Equal numbers were counted in these recordings; others would count other ones. How far the two
    may be apart follows from the recordings' differences: the number for the system at a
    disadvantage is lower by `STANDARD_ERRORS` of the logarithm of their ratio, and its
    threshold is the highest that gives it.
    """
    n_target = count_alarms(equal.y if moved == "x" else equal.x)
    if not n_target:
        return [equal]
    other = "y" if moved == "x" else "x"
    n_fewer = max(1, int(n_target * np.exp(-STANDARD_ERRORS * _spread_of_alarms(equal) / n_target)))
    worst_for_moved = {f"threshold_{moved}": _threshold(result, moved, n_fewer, "highest")}
    if has_scores(result, other):
        worst_for_other = {
            f"threshold_{moved}": _threshold(result, moved, n_target, "lowest"),
            f"threshold_{other}": _threshold(result, other, n_fewer, "highest"),
        }
    else:
        n_more = int(np.ceil(n_target**2 / n_fewer))
        worst_for_other = {f"threshold_{moved}": _threshold(result, moved, n_more, "lowest")}
    return [_with_thresholds(result, changed) for changed in (worst_for_other, worst_for_moved)]


def _spread_of_alarms(result: Result) -> float:
    """Standard error of the difference of the two numbers of false alarms, over recordings."""
    recording = result.dataset.frame_columns.recording
    apart = np.bincount(recording, weights=result.x.false_alarms - result.y.false_alarms)
    return float(np.sqrt((apart**2).sum()))


def _at_equal_alarms(result: Result, moved: str) -> Result:
    """Both systems with equally many false alarms, by a round threshold."""
    n_target = count_alarms(result.y if moved == "x" else result.x)
    threshold = _threshold(result, moved, n_target, "round")
    return _with_thresholds(result, {f"threshold_{moved}": threshold})


def _threshold(
    result: Result, letter: str, n_alarms: int, end: Literal["round", "lowest", "highest"]
) -> float | None:
    name = result.system(letter).name
    return threshold_with_alarms(result.dataset, name, result.params, n_alarms, end=end)


def _with_thresholds(result: Result, thresholds: Mapping[str, float | None]) -> Result:
    changed: dict[str, Any] = dict(thresholds)
    params = replace(result.params, **changed)
    return compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=result)


def _miss_rates(evidence: pd.DataFrame) -> list[Evidence]:
    rows = evidence[evidence["figure"] == MISS_RATE].to_dict("records")
    names = [field.name for field in fields(Evidence)]
    return [Evidence(**{name: row[name] for name in names}) for row in rows]
