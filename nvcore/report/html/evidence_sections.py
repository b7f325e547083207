"""Sections on what the measures are worth: chance, subgroups, curves, stability, frames."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.detection.curve_summary import summarise_curve
from nvcore.detection.curves import DetectionCurve, detection_curve
from nvcore.detection.filtered_truth import filter_truth
from nvcore.detection.miss_rate import explain_few
from nvcore.errors import InputError
from nvcore.evidence.bootstrap import INTERVAL_RULE
from nvcore.evidence.companions import Companions
from nvcore.evidence.planning.plan import Plan
from nvcore.evidence.subgroups import ALL
from nvcore.figures.detection import CurveKind, curve_plot, legend_text
from nvcore.figures.forest import forest_in_words, subgroup_forest
from nvcore.figures.stability import stability_map
from nvcore.measures.of_encounters import DETECTED
from nvcore.measures.table import as_shown, evidence_form
from nvcore.objects import Objects
from nvcore.palette import Theme
from nvcore.progress import Progress, no_progress
from nvcore.protocols import Protocol
from nvcore.report.html import words
from nvcore.report.html.blocks import (
    IN_THE_FILE,
    Block,
    Chart,
    Fold,
    Photo,
    Photos,
    Points,
    Section,
    Sentences,
    Table,
    table,
)
from nvcore.report.html.charts import interval_plot
from nvcore.report.html.result_sections import MEASURES_HEAD, PART
from nvcore.report.plan import verdict_plan
from nvcore.report.verdict import Verdict, verdict
from nvcore.report.words import effect_text, score_cells
from nvcore.stability.survey import SurveyRow, survey_stability, survey_table
from nvcore.stability.words import (
    CRITERIA,
    PLANES,
    describe_chance,
    describe_equal_alarms,
    describe_stability,
)
from nvcore.tables.scorecard import curve_rows
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

CURVES: Final[dict[CurveKind, tuple[str, str]]] = {
    "miss_rate": ("Miss rate against false positives per image", "lower is better"),
    "precision_recall": ("Precision against recall", "higher is better"),
}
STABILITY_TITLE: Final = "Does the verdict depend on the settings"
IN_SUBGROUPS: Final = "in subgroups.csv"
AT_ONCE: Final = 20_000
"""Most frames for which the stability maps are computed by default."""


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
    blocks = (Points(conclusion.topics),)
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


def detection_section(result: Result, protocol: Protocol) -> Section:
    """Curves of both systems under a protocol, and their measures."""
    try:
        curves = [
            detection_curve(result.dataset, system.name, result.params, protocol)
            for _, system in result.sides
        ]
    except InputError as error:
        why_not = Sentences((f"There are no curves: {error}.",))
        return Section("detection", "Detection curves", words.DETECTION, (why_not,))
    thresholds = [system.threshold for _, system in result.sides]
    summaries = [
        summarise_curve(curve, threshold)
        for curve, threshold in zip(curves, thresholds, strict=True)
    ]
    rows = score_cells(curve_rows(*summaries), indent=PART)
    notes = [
        f"{letter} has no averages and no areas ({summary.why_undefined})."
        for letter, summary in zip("XY", summaries, strict=True)
        if summary.why_undefined is not None
    ]
    notes += [
        f"Log-average miss rate of {letter}: {'; '.join(summary.notes)}."
        for letter, summary in zip("XY", summaries, strict=True)
        if summary.notes
    ]
    few = explain_few(curves[0].n_truth, result.objects)
    notes += [f"{capitalised(few)}."] if few else []
    filters = f"Filters: {'; '.join(protocol.filters)}." if protocol.filters else ""
    protocol_text = f"Protocol {protocol.title}: {result.objects.say(protocol.text)} {filters}"
    blocks: list[Block] = [Sentences((protocol_text.strip(), _left_out(result, protocol), *notes))]
    blocks.append(table("Detection measures", MEASURES_HEAD, rows, right=(1, 2, 3)))
    miss_rate, precision_recall = (
        _curve(
            curves,
            thresholds,
            kind,
            [legend_text(summary, kind) for summary in summaries],
            result,
        )
        for kind in CURVES
    )
    blocks += [miss_rate, Fold(CURVES["precision_recall"][0], (precision_recall,))]
    return Section("detection", "Detection curves", words.DETECTION, tuple(blocks))


def _left_out(result: Result, protocol: Protocol) -> str:
    """How many pedestrians count, and why the others do not."""
    truth = filter_truth(result.dataset, protocol)
    counted = count_text(truth.n_truth, result.objects.singular, result.objects.plural)
    images = count_text(truth.n_images, "image")
    return f"{counted} in {images} count; {truth.left_out or 'none is ignored'}."


def _curve(
    curves: Sequence[DetectionCurve],
    thresholds: Sequence[float | None],
    kind: CurveKind,
    legend: Sequence[str],
    result: Result,
) -> Chart:
    title, best = CURVES[kind]
    figure = curve_plot(
        curves,
        thresholds,
        kind,
        theme=result.scheme("light"),
        summaries=legend,
        hint=best,
        published=result.dataset.settings.published,
        objects=result.objects,
    )
    return Chart(f"curve-{kind.replace('_', '-')}", figure, f"{title} of X and Y; {best}")


def stability_section(
    result: Result,
    evidence: pd.DataFrame,
    *,
    is_wanted: bool | None,
    progress: Progress = no_progress,
) -> Section:
    """All maps of the verdict in a table, and one of them drawn; or why there are none.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result.
    is_wanted
        None: if there are at most `AT_ONCE` frames.
    progress
        Progress of the maps.
    """
    n_frames = len(result.dataset.frames)
    intro = words.STABILITY
    if is_wanted is False or (is_wanted is None and n_frames > AT_ONCE):
        why_not = Sentences((f"Not computed for these {n_frames:,} frames: not asked for.",))
        return Section("stability", STABILITY_TITLE, intro, (why_not,))
    with ThreadPoolExecutor() as pool:
        rows = survey_stability(result, executor=pool, progress=progress)
    order = sorted(range(len(rows)), key=lambda number: _holds(rows[number]))  # the others first
    survey = survey_table(rows)[["settings", "by", "verdict", "share", "nearest"]].iloc[order]
    head = (
        "Settings",
        "Better by",
        "As analysed",
        "Holds in (of the plausible range)",
        "Nearest setting that overturns it",
    )
    blocks: list[Block] = [
        table(
            "Verdict and settings",
            head,
            survey.to_numpy().tolist(),
            printed=len(rows) - sum(map(_holds, rows)),
            rest=f"the verdict holds throughout the plausible range, {IN_THE_FILE}",
        ),
        Fold(
            "Is that more than chance, and at equal false alarms",
            (Sentences((*_chance_of_each(rows, evidence), *_at_equal_alarms(rows))),),
        ),
    ]
    first = rows[0]  # alpha and midpoint, by mean similarity
    assert first.stability is not None
    sentences = describe_stability(first.stability)
    title = f"{PLANES[first.plane]}, by {CRITERIA[first.criterion]}: {sentences[0]}"
    blocks += [
        Chart(
            "stability", stability_map(first.stability, theme=result.scheme("light")), sentences[0]
        ),
        Fold("This map in words", (Sentences((title, *sentences[1:])),)),
    ]
    return Section("stability", STABILITY_TITLE, intro, tuple(blocks))


def _holds(row: SurveyRow) -> bool:
    """Whether the verdict holds in all of the plausible range."""
    stability = row.stability
    if stability is None or stability.verdict == "undefined":
        return False
    return not row.is_dependent or stability.share_held == 1


def _at_equal_alarms(rows: Sequence[SurveyRow]) -> tuple[str, ...]:
    """Which system is better at thresholds that are fair to both."""
    maps = [stability.stability for stability in rows if stability.stability is not None]
    return tuple(filter(None, (describe_equal_alarms(stability) for stability in maps)))


def _chance_of_each(rows: Sequence[SurveyRow], evidence: pd.DataFrame) -> tuple[str, ...]:
    """For each criterion, whether its difference as analysed is more than chance."""
    maps = {row.criterion: row.stability for row in rows if row.stability is not None}
    texts = {criterion: describe_chance(a_map, evidence) for criterion, a_map in maps.items()}
    return tuple(
        f"By {CRITERIA[criterion]}: {text[0].lower()}{text[1:]}"
        for criterion, text in texts.items()
        if text
    )


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
