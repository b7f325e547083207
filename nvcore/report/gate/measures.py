"""Measures that rules may name, and their values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence, Set
from typing import Any, Final, get_args

import numpy as np
import pandas as pd

from nvcore.common.arguments.plan import Side
from nvcore.common.findings import Finding, Severity
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import is_met
from nvcore.comparison.measures.table import MEASURES, is_usable, measure_of
from nvcore.dataset.schema import Category
from nvcore.evidence.companions import Companions
from nvcore.evidence.measures import evidence_of
from nvcore.evidence.operating_points import is_undecided
from nvcore.evidence.planning import PLAN_KEYS, judge_key, worse_at_most
from nvcore.evidence.table import judge_both
from nvcore.evidence.units import find_units
from nvcore.metrics.detection.curve_summary import summarise_curve
from nvcore.metrics.detection.curves import detection_curve
from nvcore.metrics.encounter_classes import classes_of
from nvcore.metrics.venn import Venn, count_categories
from nvcore.report.gate.added import added_rules
from nvcore.report.gate.rules import OF_CLASSES, class_in
from nvcore.report.verdict import verdict
from nvcore.settings.protocols import Protocol
from nvcore.tables.column import CellKind, Column
from nvcore.tables.encounters.changes import Change, count_changes
from nvcore.tables.summary import SYSTEM_KEYS, summary, summary_keys, system_summary

_OF_CURVE: Final = {
    measure.rule: measure.of_curve for measure in MEASURES if measure.rule and measure.of_curve
}
"""Measures of the detection curve, by their names in rules."""
WORSE: Final = {
    f"{measure_of(key).rule or name}_worse_{letter}": (key, letter)
    for name, key in PLAN_KEYS.items()
    for letter in get_args(Side)
}
"""Measures of how much worse a system may be, by the interval over recordings: measure and system.
"""
COUNTED_ENCOUNTERS: Final = {
    "newly_missed": Category.X_ONLY,
    "fixed": Category.Y_ONLY,
    "missed_by_both": Category.NEITHER,
    "venn.x_only": Category.X_ONLY,
    "venn.y_only": Category.Y_ONLY,
    "venn.neither": Category.NEITHER,
}
"""Measures that count encounters, which a failed rule lists."""
COUNTED_ALARMS: Final = {"newly_false": Change.NEWLY_FALSE, "gone": Change.GONE}
"""Measures that count false-alert episodes of one version alone, which a failed rule lists."""
COUNTED_FINDINGS: Final = {"audit_errors": Severity.ERROR, "audit_warnings": Severity.WARNING}
"""Measures that count findings of the audit, which a failed rule lists as well."""
COUNTED_CLAIMS: Final = {"claims_x": "x", "claims_y": "y"}
"""Measures that count the verdict's claims for a system. They take a moment to compute."""
_OTHER_NAMES: Final = (
    "newly_missed",
    "fixed",
    "missed_by_both",
    "encounters",
    "mcnemar_p",
    *COUNTED_ALARMS,
    *COUNTED_FINDINGS,
    *COUNTED_CLAIMS,
)


def _numeric(columns: Iterable[Column]) -> list[str]:
    return [column.name for column in columns if column.kind in (CellKind.INTEGER, CellKind.NUMBER)]


SUMMARY_NAMES: Final = (
    *_numeric(summary_keys()),
    *(f"fusion.{kind}.{name}" for kind in ("x_or_y", "x_and_y") for name in _numeric(SYSTEM_KEYS)),
)
"""Measures in ``summary.json`` of neither X nor Y, computed only if a rule names one."""


def _with_endings(names: Iterable[str]) -> list[str]:
    return [f"{name}_{end}" for name in names for end in ("x", "y", "difference")]


MEASURE_OF: Final = {
    **{
        name: measure
        for measure in MEASURES
        for name in (
            *_with_endings([measure.rule or measure.key]),
            *(f"fusion.{kind}.{measure.key}" for kind in ("x_or_y", "x_and_y")),
        )
    },
    **{name: measure_of(key) for name, (key, _) in WORSE.items()},
}
"""Measure whose value, difference or interval a name stands for."""
CONDITIONS: Final = {
    **{
        name: measure.only_if for name, measure in MEASURE_OF.items() if measure.only_if is not None
    },
    **{column.name: column.only_if for column in summary_keys() if column.only_if is not None},
}
"""Conditions on comparisons for listing these names. All other names are always listed."""


def measure_names() -> list[str]:
    """Return the names of all measures that a rule may name."""
    of_systems = _with_endings([*_numeric(SYSTEM_KEYS), *_OF_CURVE])
    return [*of_systems, *WORSE, *_OTHER_NAMES, *SUMMARY_NAMES]


def listed_names(result: Result, values: Mapping[str, float]) -> list[str]:
    """Return the names of these measures, sorted, without those whose `CONDITIONS` are not met."""
    return sorted(name for name in values if is_met(CONDITIONS.get(name), result))


def gate_measures(
    result: Result, findings: Sequence[Finding], protocol: Protocol, names: Iterable[str]
) -> dict[str, float]:
    """Compute the measures that rules may name, slow ones only if they are needed.

    ``newly_missed`` are the encounters that X detects and Y does not, ``fixed`` the opposite, and
    ``newly_false`` and ``gone`` the false-alert episodes of Y alone and of X alone: X is the
    current release, Y the candidate. ``mean_similarity_worse_y`` and the like are the ends
    of 95 % intervals against a system (`nvcore.evidence.planning.worse_at_most`). They are
    undefined if X and Y are set to different operating points, because the verdict claims nothing
    from these either. Measures that no rule can rest on are undefined as well
    (`nvcore.comparison.measures.table.is_usable`, and additions of subjects).

    Parameters
    ----------
    protocol
        Protocol of the detection curves.
    names
        Names in rules. Measures of detection curves, of `SUMMARY_NAMES` and the number of claims
        are each computed if one of the group is named. Intervals are computed only for named
        measures.
    """
    needed = set(names)
    values = {f"{name}_{letter}": math.nan for name in _numeric(SYSTEM_KEYS) for letter in "xy"}
    for letter, system in result.sides:
        for name, value in _numbers(system_summary(result, system)):
            values[f"{name}_{letter}"] = value
    if any(name.rsplit("_", 1)[0] in _OF_CURVE for name in needed):
        values |= _of_curves(result, protocol)
    for name in [key.removesuffix("_x") for key in values if key.endswith("_x")]:
        values[f"{name}_difference"] = values[f"{name}_x"] - values[f"{name}_y"]
    if not needed.isdisjoint(SUMMARY_NAMES):
        of_all = dict(_numbers(summary(result)))
        values |= {name: of_all.get(name, math.nan) for name in SUMMARY_NAMES}
    evidence = None
    if not needed.isdisjoint(COUNTED_CLAIMS):
        evidence, companions = judge_both(result, protocol)
        values |= _count_claims(result, findings, evidence, companions)
    values |= _may_be_worse(result, protocol, needed, evidence)
    values |= _of_classes(result, needed)
    if not needed.isdisjoint(COUNTED_ALARMS):
        counts = count_changes(result)
        values |= {name: float(counts[kind]) for name, kind in COUNTED_ALARMS.items()}
    undefined = {name for of in added_rules() for name in of.undefined(result)}
    unusable = {measure.key for measure in MEASURES if not is_usable(result, measure)}
    undefined |= {name for name, measure in MEASURE_OF.items() if measure.key in unusable}
    values |= dict.fromkeys(values.keys() & undefined, math.nan)
    count = Counter(finding.severity for finding in findings)
    venn = result.venn
    return values | {
        **_counts_of_encounters(venn),
        "mcnemar_p": result.mcnemar_p,
        "audit_errors": float(count[Severity.ERROR]),
        "audit_warnings": float(count[Severity.WARNING]),
    }


def _counts_of_encounters(venn: Venn) -> dict[str, float]:
    """Return the values of `OF_CLASSES`."""
    # undefined without encounters, so that no rule passes just because nothing can be missed
    one_or_nan = 1.0 if venn.n_near else math.nan
    counts = (venn.x_only, venn.y_only, venn.neither)
    misses = (count * one_or_nan for count in counts)
    return dict(zip(OF_CLASSES, (*misses, float(venn.n_near)), strict=True))


def _of_classes(result: Result, names: Set[str]) -> dict[str, float]:
    """Return the measures requested for a class. The number of a class without encounters is 0."""
    values = {}
    for name in sorted(name for name in names if class_in(name)):
        venn = count_categories(result.category[members(result, name)])
        values[name] = _counts_of_encounters(venn)[name.partition(".")[0]]
    return values


def members(result: Result, name: str) -> np.ndarray:
    """Return the encounters that a measure of a class, or of all, covers, bool, (n_encounters,)."""
    wanted, n = class_in(name), len(result.encounters)
    if not wanted:
        return np.ones(n, dtype=bool)
    return classes_of(result.dataset).members.get(wanted, np.zeros(n, dtype=bool))


def _of_curves(result: Result, protocol: Protocol) -> dict[str, float]:
    """Return the measures of the detection curves of both systems."""
    values = {}
    for letter, system in result.sides:
        curve = detection_curve(result.dataset, system.name, result.params, protocol)
        of_curve = summarise_curve(curve, system.threshold)
        for name, value_of in _OF_CURVE.items():
            values[f"{name}_{letter}"] = float(value_of(of_curve))
    return values


def _count_claims(
    result: Result, findings: Sequence[Finding], evidence: pd.DataFrame, companions: Companions
) -> dict[str, float]:
    """Count the differences that the verdict claims for each system."""
    claims = verdict(result, findings, evidence=evidence, companions=companions).claims
    return {
        name: float(sum(claim.winner == letter for claim in claims))
        for name, letter in COUNTED_CLAIMS.items()
    }


def _may_be_worse(
    result: Result, protocol: Protocol, names: Set[str], evidence: pd.DataFrame | None
) -> dict[str, float]:
    """Return the needed values of `WORSE`, NaN without an interval or without claims.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result, if already computed.
    """
    sides_of: dict[str, dict[str, Side]] = {}
    for name in sorted(names & WORSE.keys()):
        key, side = WORSE[name]
        sides_of.setdefault(key, {})[name] = side
    units = find_units(result) if sides_of and evidence is None else None
    values: dict[str, float] = {}
    for key, sides in sides_of.items():
        if is_undecided(result, key) or not is_usable(result, measure_of(key)):
            values |= dict.fromkeys(sides, math.nan)
            continue
        row = None if evidence is None else evidence_of(evidence, key)
        row = judge_key(result, key, protocol=protocol, units=units) if row is None else row
        values |= {name: worse_at_most(row, side) for name, side in sides.items()}
    return values


def _numbers(content: Mapping[str, Any], before: str = "") -> Iterable[tuple[str, float]]:
    """Yield numeric entries, nested ones as ``outer.inner``."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _numbers(value, f"{before}{name}.")
        elif isinstance(value, int | float) or value is None:
            yield f"{before}{name}", math.nan if value is None else float(value)
