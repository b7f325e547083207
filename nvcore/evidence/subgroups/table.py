"""Measures of a comparison for groups of its encounters, each with its evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.subject import subjects
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import evidence_keys, inference_of, repeated_by
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset import Dataset
from nvcore.dataset.schema import Category
from nvcore.evidence.companions import judge_equal_alarms
from nvcore.evidence.measures import COLUMNS as EVIDENCE_COLUMNS
from nvcore.evidence.measures import (
    Evidence,
    evidence_of,
    judge_encounters,
    judge_measure,
    unit_measures,
    with_doubt,
    with_mean_over_recordings,
)
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.paired_tests import holm, mcnemar
from nvcore.evidence.subgroups import ALL, Subgroup, everyone, find_subgroups
from nvcore.evidence.table import mark_undecided
from nvcore.evidence.units import Units, find_units, units_within
from nvcore.metrics.venn import count_categories
from nvcore.settings.protocols import PROTOCOLS, Protocol

GIVEN_THRESHOLD: Final = "takes the threshold for equal false alarms as given"
"""Note on groups: only the interval and p of all encounters allow for other recordings' threshold.
"""
_COUNTS: Final = ("n", "unit", "both", "x_only", "y_only", "neither")
_FIRST: Final = ("factor", "group", "figure", "label", "better", *_COUNTS)
_OTHERS: Final = [name for name in EVIDENCE_COLUMNS if name not in _FIRST]
_ODDS: Final = _OTHERS.index("effect_name") + 1
COLUMNS: Final = (*_FIRST, *_OTHERS[:_ODDS], "odds_low", "odds_high", *_OTHERS[_ODDS:])


def subgroup_table(
    result: Result,
    keys: Sequence[str] | None = None,
    *,
    protocol: Protocol = PROTOCOLS["all"],
    units: Units | None = None,
) -> pd.DataFrame:
    """Compute the difference X - Y of each measure for all encounters and for every group.

    The table is ready for forest plots: each measure has one row per group, the first for all
    encounters. A group of recordings (a tag) has every measure, from the units within these
    recordings. A group of pedestrians has its own encounters detected. Its saliency is that of its
    events, over the recordings with such pedestrians. Its log-average miss rate ignores all other
    pedestrians and counts the false positives of all frames. Frames and false alerts belong to no
    such group, so their measures are NaN and `note` has the reason.

    Parameters
    ----------
    keys
        Some of `nvcore.comparison.measures.table.EVIDENCE_KEYS`; None: all that the comparison has.
    protocol
        Selection of the pedestrians that count in the log-average miss rate.
    units
        ``find_units(result)``, if already computed.

    Returns
    -------
    Columns `COLUMNS`. both, x_only, y_only, neither: near encounters of the group by the systems
    that detect them, unless `Inference.split_in_group` defines another split for the measure;
    odds_low, odds_high: 95 % interval of the odds ratio; p_corrected: by Holm, for all groups and
    measures of the table (rows of all encounters are not groups). The others are attributes of
    `measures.Evidence`. Groups of different factors overlap, and so do groups of tags.

    References
    ----------
    ``docs/significance.md``, groups; ``docs/decisions/032-figures-of-subgroups.md``.

    Examples
    --------
    >>> subgroup_table(result, ["saliency"])[["group", "n", "difference"]]  # doctest: +SKIP
    """
    units = find_units(result) if units is None else units
    keys = evidence_keys(result) if keys is None else keys
    parts = (everyone(result), *find_subgroups(result))
    by_part = [_judge_part(result, part, keys, units=units, protocol=protocol) for part in parts]
    tables = []
    for of_measure in zip(*by_part, strict=True):
        rows = [_row(result, *pair) for pair in zip(parts, of_measure, strict=True)]
        table = pd.DataFrame(rows)
        table["label"] = of_measure[0].label  # the label of a tag's miss rate names the tag
        tables.append(table)
    whole = pd.concat(tables, ignore_index=True)
    is_group = (whole["factor"] != ALL).to_numpy()
    whole["p_corrected"] = np.nan
    is_repeated = np.array([bool(repeated_by(key)) for key in whole["figure"]], dtype=bool)
    is_tested = is_group & ~is_repeated
    whole.loc[is_tested, "p_corrected"] = holm(whole.loc[is_tested, "p"].to_numpy(dtype=float))
    return mark_undecided(result, whole[list(COLUMNS)])


def judge_groups(
    result: Result, groups: Sequence[Subgroup], keys: Sequence[str], *, units: Units | None = None
) -> dict[str, dict[str, Evidence]]:
    """Return the evidence on some measures for groups of encounters, by group, then by key.

    p is not corrected for the number of groups.
    """
    units = find_units(result) if units is None else units
    judged = {}
    for group in groups:
        rows = _judge_part(result, group, keys, units=units, protocol=PROTOCOLS["all"])
        judged[group.group] = dict(zip(keys, rows, strict=True))
    return judged


def _row(result: Result, part: Subgroup, evidence: Evidence) -> dict[str, Any]:
    venn = count_categories(result.category[part.is_member])
    odds = (np.nan, np.nan)
    split = inference_of(evidence.figure).split
    if split is not None:
        venn = split(_narrow(result, part))
        test = mcnemar(venn)
        odds = test.odds_low, test.odds_high
    counts = venn.counts()
    return {
        "factor": part.factor,
        "group": part.group,
        **vars(evidence),
        **{name: counts[name] for name in ("both", "x_only", "y_only", "neither")},
        "odds_low": odds[0],
        "odds_high": odds[1],
    }


def _judge_part(
    result: Result, part: Subgroup, keys: Sequence[str], *, units: Units, protocol: Protocol
) -> list[Evidence]:
    """Return the evidence on the measures for a group, in the order of `keys`."""
    part_result = _narrow(result, part)
    within = units_within(result, units, part.recordings)
    known: dict[str, Evidence | None] = {}
    if part.factor == ALL and result.as_set is not None:
        at_equal = judge_equal_alarms(result, keys=keys, units=units)
        known = {key: evidence_of(at_equal, key) for key in at_equal["figure"]}
    of_units = {measure.key: measure for measure in unit_measures(part_result, within)}

    def judge(key: str) -> Evidence:
        if (row := known.get(key)) is not None:
            return row
        inference = inference_of(key)
        if inference.test == "encounters":
            split = judge_encounters(part_result, key)
            return split.values_only() if result.is_short else split
        if inference.test == "curve":
            return _miss_rate(result, part, units, protocol)
        measure = of_units[key]
        if inference.not_of_pedestrians and not part.has_frames:
            why = result.objects.say(inference.not_of_pedestrians)
            return Evidence.undefined(
                measure.key, measure.label, measure.better, unit=units.kind, note=why
            )
        row = with_mean_over_recordings(part_result, within, judge_measure(measure, within))
        if result.as_set is None:
            return row
        return replace(row, note="; ".join(filter(None, (row.note, GIVEN_THRESHOLD))))

    return [
        row if inference_of(row.figure).test == "curve" else with_doubt(result, row)
        for row in map(judge, keys)
    ]


def _narrow(result: Result, part: Subgroup) -> Result:
    """Return the result in which only the encounters and events of a group count."""
    category = np.where(part.is_member, result.category, Category.DISTANT.value)
    # distant encounters can be urgent, and belong to groups of recordings alone
    is_of_part = part.is_member
    if part.has_frames:
        is_of_part = part.recordings[result.encounters.recording]
    made = dict(result.made)
    for subject in subjects():
        made |= subject.scores().restrict(made, is_of_part)
    return replace(
        result,
        category=category,
        made=made,
        venn=count_categories(category),
        x=_with_events_of(part, result.x),
        y=_with_events_of(part, result.y),
    )


def _with_events_of(part: Subgroup, system: SystemResult) -> SystemResult:
    if part.has_frames:
        return system
    encounter = system.events["encounter"].to_numpy(dtype=np.int64)
    return replace(system, events=system.events[part.is_member[encounter]])


def _miss_rate(result: Result, part: Subgroup, units: Units, protocol: Protocol) -> Evidence:
    """Judge the log-average miss rate of a group, ignoring other pedestrians."""
    if part.factor == ALL:
        return judge_miss_rate(result, units, protocol).evidence
    if part.has_frames:
        with_tag = replace(protocol, tags=(*protocol.tags, part.group))
        return judge_miss_rate(result, units, with_tag).evidence
    return judge_miss_rate(replace(result, dataset=_only(result, part)), units, protocol).evidence


def _only(result: Result, part: Subgroup) -> Dataset:
    """Return the dataset with the pedestrians of all other encounters ignored."""
    dataset, encounter_of = result.dataset, result.encounters.encounter_of
    ignore = dataset.boxes["ignore"].to_numpy(dtype=bool, copy=True)
    is_of_part = np.append(part.is_member, False)[encounter_of]  # -1: in none
    ignore[: len(encounter_of)] |= ~is_of_part
    return replace(dataset, boxes=dataset.boxes.assign(ignore=ignore))
