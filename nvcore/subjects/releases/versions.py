"""Versions of a system in a session, and their measures with the limits of the gate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result, compare
from nvcore.comparison.measures.table import applies_to, measure_of
from nvcore.dataset import Dataset
from nvcore.evidence.pairwise import thresholds_in_use
from nvcore.inputs.session import Session
from nvcore.report.gate.measures import COUNTED_CLAIMS, COUNTED_FINDINGS, WORSE, gate_measures
from nvcore.report.gate.outcomes import judge
from nvcore.report.gate.rules import Rule
from nvcore.tables.scorecard import LEADING


def version_lines(dataset: Dataset) -> tuple[tuple[str, ...], ...]:
    """Return the systems that are versions of one another, in the session's order, by product."""
    settings = dataset.settings
    if not isinstance(settings, Session):
        return ()
    earlier = {
        name: source.version_of
        for name, source in zip(dataset.systems, settings.systems, strict=False)
    }
    lines: dict[str, list[str]] = {}
    for name in dataset.systems:
        product, passed = name, {name}
        while (of := earlier.get(product)) is not None and of not in passed:
            product = of
            passed.add(of)
        lines.setdefault(product, []).append(name)
    return tuple(tuple(line) for line in lines.values() if len(line) > 1)


def latest_versions(dataset: Dataset) -> tuple[str | None, str | None]:
    """Return the last two versions of the only product that has some. Without any: X and Y.

    Raises
    ------
    InputError
        If several products have versions.
    """
    lines = version_lines(dataset)
    if len(lines) > 1:
        known = "; ".join(", ".join(line) for line in lines)
        raise InputError(f"expected an old and a new version, of {known}")
    return (lines[0][-2], lines[0][-1]) if lines else dataset.compared()


def measures_of_versions(result: Result, rules: Sequence[Rule] = ()) -> pd.DataFrame:
    """Return the measures of every version, each compared with the one before it.

    Parameters
    ----------
    result
        Comparison of two versions, as they are set. Its settings apply to all versions.
    rules
        Rules of the gate. Those about the audit or the verdict are left out. Without any, the
        measures are the leading ones of the scorecard.

    Returns
    -------
    One row per measure (or rule) and version: version, measure (its name in rules: Y is the
    version, X the one before it), value (NaN if the first version has none), rule (its text, or
    missing) and is_met (whether it holds, or missing).
    """
    dataset, previous, old_and_new = result.dataset, result, {*result.names}
    rules = [of for of in rules if of.name not in (*COUNTED_FINDINGS, *COUNTED_CLAIMS)]
    leading = [of for of in map(measure_of, LEADING) if applies_to(result, of)]
    names = [of.name for of in rules] or [f"{of.rule or of.key}_y" for of in leading]
    lines = version_lines(dataset)
    versions = next((line for line in lines if old_and_new <= {*line}), result.names)
    thresholds = thresholds_in_use(dataset, result.params)
    rows: list[dict[str, Any]] = []
    for number, version in enumerate(versions):  # a loop over a handful of versions
        before = versions[number - 1] if number else versions[1]
        of_x, of_y = thresholds.get(before), thresholds.get(version)
        params = replace(result.params, threshold_x=of_x, threshold_y=of_y)
        previous = compare(dataset, params, x=before, y=version, previous=previous)
        values = gate_measures(previous, (), dataset.settings.protocol, names)
        for place, name in enumerate(names):
            is_known = number > 0 or (name.endswith("_y") and name not in WORSE)
            value = values[name] if is_known else np.nan
            row = {"place": place, "version": version, "measure": name, "value": value}
            if rules:
                (outcome,) = judge([rules[place]], values)
                is_met = outcome.is_passed if is_known else None
                row |= {"rule": outcome.rule.text, "is_met": is_met}
            rows.append(row)
    columns = ["place", "version", "measure", "value", "rule", "is_met"]
    table = pd.DataFrame(rows, columns=columns).astype({"is_met": "boolean"})
    return table.sort_values("place", kind="stable", ignore_index=True).drop(columns="place")
