"""Sections on what the measures are worth: verdict, chance, subgroups, evidence frames."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.bootstrap import INTERVAL_RULE
from nvcore.evidence.companions import Companions
from nvcore.evidence.planning.plan import Plan
from nvcore.evidence.subgroups import ALL
from nvcore.figures.forest import forest_in_words, subgroup_forest
from nvcore.measures.of_encounters import DETECTED
from nvcore.measures.table import as_shown, evidence_form
from nvcore.objects import Objects
from nvcore.palette import Theme
from nvcore.report.html import words
from nvcore.report.html.blocks import (
    Block,
    Chart,
    Fold,
    Photo,
    Photos,
    Section,
    Sentences,
    Table,
    Topics,
    table,
)
from nvcore.report.html.charts import interval_plot
from nvcore.report.plan import verdict_plan
from nvcore.report.verdict import Verdict, verdict
from nvcore.report.words import effect_text
from nvcore.wording import (
    ARROWS,
    UNDEFINED,
    capitalised,
    count_text,
    difference,
    interval_text,
    number,
    one_line,
)

IN_SUBGROUPS: Final = "in subgroups.csv"


def planned_verdict(
    result: Result,
    findings: Sequence[Any],
    evidence: pd.DataFrame,
    companions: Companions,
    plans: Mapping[str, Plan],
) -> Verdict:
    """What the comparison supports, and how many recordings would show more.

    Parameters
    ----------
    companions
        `nvcore.evidence.companions.find_companions` of the result.
    plans
        Of `nvcore.report.html.plan_section.plan_measures`: the verdict's own may be among them.
    """
    plan = verdict_plan(result, evidence, companions, plans=plans)
    return verdict(result, findings, evidence=evidence, companions=companions, plan=plan)


def verdict_section(conclusion: Verdict) -> Section:
    """What the headline, which stands on the first page, rests on."""
    blocks = (Topics(conclusion.topics),)
    return Section("verdict", "What the verdict rests on", words.VERDICT, blocks)


def significance_section(result: Result, evidence: pd.DataFrame, theme: Theme) -> Section:
    """Every difference with its interval and p-value, and how these were computed."""
    evidence = as_shown(result, evidence)
    rows, ways = [], []
    for row in evidence.to_dict("records"):
        values = (number(row[letter], evidence_form(row["figure"])) for letter in "xy")
        label = row["label"] + ARROWS[row["better"]]
        rows.append((label, *values, *_evidence_of(row), effect_text(row)))
        how = row["method"] or UNDEFINED, row["note"] or UNDEFINED
        ways.append((row["label"], f"{row['n']:,} {row['unit']}", *how))
    head = ("Measure", "X", "Y", "X − Y", "95 % interval", "p", "p (corrected)", "Effect")
    note = (
        "↑ higher is better, ↓ lower is better. Effect: Cohen's d_z or the odds ratio of "
        "the encounters that only one detects."
    )
    return Section(
        "significance",
        "Is the difference real",
        words.SIGNIFICANCE,
        (
            table(
                "Differences and tests",
                head,
                rows,
                right=range(1, 8),
                note=note,
                printed=len(rows),
            ),
            Chart(
                "intervals", interval_plot(evidence, theme), "Differences with their 95 % intervals"
            ),
            Fold(
                "Methods",
                (table("Methods", ("Measure", "From", "Method", "Note"), ways),),
                "in significance.csv",
            ),
            *([Sentences((INTERVAL_RULE,))] if np.isfinite(evidence["low"]).any() else []),
        ),
    )


def subgroups_section(subgroups: pd.DataFrame, theme: Theme) -> Section:
    """Every measure for parts of the encounters, and who detects more of which."""
    is_detected = subgroups["figure"] == DETECTED
    is_shown = subgroups[["low", "p"]].notna().any(axis=1) | (subgroups["factor"] == ALL)
    n_left_out = int((np.isfinite(subgroups["x"]) & ~is_shown).sum())
    detection_rows = subgroups[is_detected]
    shown_rows = subgroups[is_detected & is_shown]
    head = (
        "Factor",
        "Group",
        "Encounters",
        "Both",
        "Only X",
        "Only Y",
        "Neither",
        "X − Y",
        "95 % interval",
        "p",
        "p (Holm)",
    )
    counts = ("n", "both", "x_only", "y_only", "neither")
    rows = [
        (*_group_of(row), *(row[name] for name in counts), *_evidence_of(row))
        for row in shown_rows.to_dict("records")
    ]
    title = "Encounters detected by subgroup"
    detected = table(title, head, rows, right=range(2, 11), note=_notes_of(shown_rows))
    others = tuple(
        _table_by_subgroup(of_measure)
        for _, of_measure in subgroups[~is_detected & is_shown].groupby("figure", sort=False)
        if len(of_measure) > 1
    )
    left_out = (
        f"{count_text(n_left_out, 'row')} with too little data for an interval or a test left "
        f"out of these tables: {IN_SUBGROUPS}."
    )
    return Section(
        "subgroups",
        "Subgroups",
        words.SUBGROUPS,
        (
            Sentences((nothing,))
            if (nothing := forest_in_words(detection_rows))
            else Chart(
                "forest",
                subgroup_forest(detection_rows, theme=theme),
                "Difference in the share detected by group",
            ),
            Fold("All measures by subgroup", (detected, *others), IN_SUBGROUPS),
            *([Sentences((left_out,))] if n_left_out else []),
        ),
    )


def _table_by_subgroup(subgroups: pd.DataFrame) -> Table:
    """One measure, for all encounters and the groups given."""
    head = ("Factor", "Group", "From", "X", "Y", "X − Y", "95 % interval", "p", "p (Holm)")
    form = evidence_form(subgroups["figure"].iloc[0])
    rows = [
        (
            *_group_of(row),
            f"{row['n']:,} {row['unit']}",
            *(number(row[letter], form) for letter in "xy"),
            *_evidence_of(row),
        )
        for row in subgroups.to_dict("records")
    ]
    label = subgroups["label"].iloc[0]
    title = f"{capitalised(label)}, by subgroup"
    return table(title, head, rows, right=range(3, 9), note=_notes_of(subgroups))


def _group_of(row: Mapping[Hashable, Any]) -> tuple[str, str]:
    return row["factor"], row["group"] if row["factor"] != ALL else ""


def _evidence_of(row: Mapping[Hashable, Any]) -> tuple[str, str, str, str]:
    """Difference, interval, p and corrected p of a row."""
    form = evidence_form(row["figure"])
    span = interval_text(row["low"], row["high"], form)
    p, p_corrected = number(row["p"], ".2g"), number(row["p_corrected"], ".2g")
    return difference(row["x"], row["y"], form), span, p, p_corrected


def _notes_of(rows: pd.DataFrame) -> str:
    """Each note once, with the groups that it concerns."""
    groups: dict[str, list[str]] = {}
    for row in rows.to_dict("records"):
        for note in filter(None, row["note"].split("; ")):
            groups.setdefault(note, []).append(" ".join(_group_of(row)).strip())
    texts = [
        f"{'All' if len(of) == len(rows) else ', '.join(of)}: {note}."
        for note, of in groups.items()
    ]
    return one_line(" ".join(texts))


def frames_section(photos: Sequence[Photo], troubles: Sequence[str], objects: Objects) -> Section:
    """The evidence frames; what holds for all of them comes once."""
    blocks: list[Block] = []
    if troubles:
        blocks.append(Sentences(("Some pictures cannot be shown.", *troubles)))
    if photos and all(photo.why_blank for photo in photos):
        blocks.append(Sentences((words.NO_PICTURES,)))
        photos = [replace(photo, why_blank="") for photo in photos]
    nothing = "Neither system misses {a_one} or is low anywhere: nothing to show."
    blocks.append(Photos(tuple(photos)) if photos else Sentences((objects.say(nothing),)))
    return Section("frames", "Evidence frames", words.EVIDENCE, tuple(blocks))
