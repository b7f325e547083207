"""Sections of what the figures are worth: chance, subgroups, curves, stability, frames."""

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
from nvcore.evidence.subgroups import ALL
from nvcore.figures.detection import CurveKind, curve_plot, legend_figure
from nvcore.figures.forest import subgroup_forest
from nvcore.figures.stability import stability_map
from nvcore.measures import evidence_form, inference_of
from nvcore.progress import Progress, no_progress
from nvcore.protocols import Protocol
from nvcore.report.html import words
from nvcore.report.html.blocks import Block, Chart, Photo, Photos, Section, Sentences, Table, table
from nvcore.report.html.charts import THEME, interval_plot
from nvcore.report.html.result_sections import MEASURES_HEAD, score_row
from nvcore.report.verdict import verdict
from nvcore.stability.survey import SurveyRow, survey_stability, survey_table
from nvcore.stability.words import (
    CRITERIA,
    PLANES,
    describe_chance,
    describe_equal_alarms,
    describe_stability,
)
from nvcore.tables.scorecard import curve_rows
from nvcore.wording import UNDEFINED, count_text, difference, number, one_line

CURVES: Final[dict[CurveKind, tuple[str, str]]] = {
    "miss_rate": ("Miss rate against false positives per image", "lower is better"),
    "precision_recall": ("Precision against recall", "higher is better"),
}
STABILITY_TITLE: Final = "Does the verdict depend on the settings"
AT_ONCE: Final = 20_000
"""Frames up to which the stability maps are made without being asked for."""


def verdict_section(result: Result, findings: Sequence[Any], evidence: pd.DataFrame) -> Section:
    """What the comparison supports."""
    told = verdict(result, tuple(findings), evidence=evidence)
    return Section("verdict", "Verdict", words.VERDICT, (Sentences(told, is_strong=True),))


def significance_section(evidence: pd.DataFrame) -> Section:
    """Every difference with interval, p-value and how they were made."""
    rows, ways = [], []
    for one in evidence.to_dict("records"):
        form = evidence_form(one["figure"])
        span = UNDEFINED
        if np.isfinite(one["low"]):
            span = f"{difference(one['low'], 0, form)} to {difference(one['high'], 0, form)}"
        effect = f"{one['effect_name']} {one['effect']:.2f}"
        rows.append((
            one["label"], number(one["x"], form), number(one["y"], form),
            difference(one["x"], one["y"], form), span, number(one["p"], ".2g"),
            number(one["p_holm"], ".2g"), effect if np.isfinite(one["effect"]) else UNDEFINED,
            one["better"],
        ))  # fmt: skip
        ways.append((one["label"], f"{one['n']:,} {one['unit']}", one["method"] or UNDEFINED,
                     one["note"] or UNDEFINED))  # fmt: skip
    head = ("Figure", "X", "Y", "X - Y", "95 % interval", "p", "p (Holm)", "Effect size", "Better")
    return Section(
        "significance", "Is the difference real", words.SIGNIFICANCE,
        (
            table("Differences and tests", head, rows, right=range(1, 7)),
            Chart("intervals", interval_plot(evidence),
                  "Differences with their 95 % intervals"),
            table("How they were made", ("Figure", "From", "Method", "Note"), ways),
        ),
    )  # fmt: skip


def subgroups_section(subgroups: pd.DataFrame) -> Section:
    """Every measure for parts of the encounters, and who detects more of which."""
    is_detected = np.array(
        [inference_of(key).test == "encounters" for key in subgroups["figure"]], dtype=bool
    )
    detected = subgroups[is_detected]
    head = ("Factor", "Group", "Encounters", "Both", "Only X", "Only Y", "Neither", "X - Y",
            "95 % interval", "p", "p (Holm)")  # fmt: skip
    rows = [
        (*_group_of(one), one["n"], one["both"], one["x_only"], one["y_only"], one["neither"],
         *_evidence_of(one))
        for one in detected.to_dict("records")
    ]  # fmt: skip
    others = [rows for _, rows in subgroups[~is_detected].groupby("figure", sort=False)]
    return Section(
        "subgroups", "Subgroups", words.SUBGROUPS,
        (
            Chart("forest", subgroup_forest(detected, theme=THEME),
                  "Difference in the share detected by group"),
            table("Encounters detected by subgroup", head, rows, right=range(2, 11),
                  note=_notes_of(detected)),
            *(_table_by_subgroup(of_measure) for of_measure in others
              if np.isfinite(of_measure["x"].iloc[1:]).any()),
        ),
    )  # fmt: skip


def _table_by_subgroup(subgroups: pd.DataFrame) -> Table:
    """One measure, for the groups that have it."""
    defined = subgroups[np.isfinite(subgroups["x"])]
    head = ("Factor", "Group", "From", "X", "Y", "X - Y", "95 % interval", "p", "p (Holm)")
    form = evidence_form(subgroups["figure"].iloc[0])
    rows = [
        (*_group_of(one), f"{one['n']:,} {one['unit']}",
         *(number(one[letter], form) for letter in "xy"), *_evidence_of(one))
        for one in defined.to_dict("records")
    ]  # fmt: skip
    label = subgroups["label"].iloc[0]
    title = f"{label[0].upper()}{label[1:]}, by subgroup"
    return table(title, head, rows, right=range(3, 9), note=_notes_of(defined))


def _group_of(one: Mapping[Hashable, Any]) -> tuple[str, str]:
    return one["factor"], one["group"] if one["factor"] != ALL else ""


def _evidence_of(one: Mapping[Hashable, Any]) -> tuple[str, str, str, str]:
    """Difference, interval, p and corrected p of a row."""
    form = evidence_form(one["figure"])
    span = UNDEFINED
    if np.isfinite(one["low"]):
        span = f"{difference(one['low'], 0, form)} to {difference(one['high'], 0, form)}"
    p, p_holm = number(one["p"], ".2g"), number(one["p_holm"], ".2g")
    return difference(one["x"], one["y"], form), span, p, p_holm


def _notes_of(rows: pd.DataFrame) -> str:
    """Each note once, with the groups that it is about."""
    groups: dict[str, list[str]] = {}
    for one in rows.to_dict("records"):
        for note in filter(None, one["note"].split("; ")):
            groups.setdefault(note, []).append(" ".join(_group_of(one)).strip())
    told = [
        f"{'All' if len(of) == len(rows) else ', '.join(of)}: {note}."
        for note, of in groups.items()
    ]
    return one_line(" ".join(told))


def detection_section(result: Result, protocol: Protocol) -> Section:
    """Curves of both systems under a protocol, and their figures."""
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
    rows = [score_row(row) for row in curve_rows(*summaries)]
    why = [
        f"{letter} has no averages and no areas ({one.why_undefined})."
        for letter, one in zip("XY", summaries, strict=True)
        if one.why_undefined is not None
    ]
    why += [
        f"Log-average miss rate of {letter}: {'; '.join(one.notes)}."
        for letter, one in zip("XY", summaries, strict=True)
        if one.notes
    ]
    few = explain_few(curves[0].n_truth)
    why += [f"{few[0].upper()}{few[1:]}."] if few else []
    filters = "; ".join(protocol.filters)
    told = f"Protocol {protocol.title}: {protocol.text} {f'Filters: {filters}.' if filters else ''}"
    blocks: list[Block] = [Sentences((told.strip(), _left_out(result, protocol), *why))]
    blocks.append(table("Detection figures", MEASURES_HEAD, rows, right=(1, 2, 3)))
    blocks += [
        _curve(curves, thresholds, kind, [legend_figure(one, kind) for one in summaries])
        for kind in CURVES
    ]
    return Section("detection", "Detection curves", words.DETECTION, tuple(blocks))


def _left_out(result: Result, protocol: Protocol) -> str:
    """How many pedestrians count, and why the others do not."""
    truth = filter_truth(result.dataset, protocol)
    counted = f"{count_text(truth.n_truth, 'pedestrian')} in {count_text(truth.n_images, 'image')}"
    return f"{counted} count; {truth.left_out or 'none is ignored'}."


def _curve(
    curves: Sequence[DetectionCurve], thresholds: Sequence[float | None], kind: CurveKind,
    legend: Sequence[str],
) -> Chart:  # fmt: skip
    title, best = CURVES[kind]
    figure = curve_plot(curves, thresholds, kind, theme=THEME, summaries=legend, hint=best)
    return Chart(f"curve-{kind.replace('_', '-')}", figure, f"{title} of X and Y; {best}")


def stability_section(
    result: Result,
    evidence: pd.DataFrame,
    *,
    wanted: bool | None,
    progress: Progress = no_progress,
) -> Section:
    """All maps of the verdict in a table, and one of them drawn; or why there is none.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result.
    wanted
        None: if there are at most `AT_ONCE` frames.
    progress
        Of the maps.
    """
    n_frames = len(result.dataset.frames)
    if wanted is False or (wanted is None and n_frames > AT_ONCE):
        why_not = Sentences((f"Not computed for these {n_frames:,} frames: not asked for.",))
        return Section("stability", STABILITY_TITLE, words.STABILITY, (why_not,))
    with ThreadPoolExecutor() as pool:
        rows = survey_stability(result, executor=pool, progress=progress)
    shown = survey_table(rows)[["settings", "by", "verdict", "share", "nearest"]]
    head = ("Settings", "Better by", "As analysed", "Holds in (of the plausible range)",
            "Nearest setting that overturns it")  # fmt: skip
    blocks: list[Block] = [
        table("Verdict and settings", head, shown.to_numpy().tolist()),
        Sentences((*_chance_of_each(rows, evidence), *_at_equal_alarms(rows))),
    ]
    first = rows[0]  # alpha and midpoint, by mean similarity
    assert first.stability is not None
    told = describe_stability(first.stability)
    title = f"{PLANES[first.plane]}, by {CRITERIA[first.criterion]}: {told[0]}"
    blocks += [
        Sentences((title, *told[1:])),
        Chart("stability", stability_map(first.stability, theme=THEME), told[0]),
    ]
    return Section("stability", STABILITY_TITLE, words.STABILITY, tuple(blocks))


def _at_equal_alarms(rows: Sequence[SurveyRow]) -> tuple[str, ...]:
    """Who is better at thresholds that are fair to both."""
    maps = [one.stability for one in rows if one.stability is not None]
    return tuple(filter(None, (describe_equal_alarms(one) for one in maps)))


def _chance_of_each(rows: Sequence[SurveyRow], evidence: pd.DataFrame) -> tuple[str, ...]:
    """For each criterion, whether its difference as analysed is more than chance."""
    found = {one.criterion: one.stability for one in rows if one.stability is not None}
    told = {one: describe_chance(a_map, evidence) for one, a_map in found.items()}
    return tuple(
        f"By {CRITERIA[one]}: {said[0].lower()}{said[1:]}" for one, said in told.items() if said
    )


def frames_section(photos: Sequence[Photo], troubles: Sequence[str]) -> Section:
    """The evidence frames; what holds for all of them is said once."""
    blocks: list[Block] = []
    if troubles:
        blocks.append(Sentences(("Some pictures cannot be shown.", *troubles)))
    if photos and all(one.why_blank for one in photos):
        blocks.append(Sentences((words.NO_PICTURES,)))
        photos = [replace(one, why_blank="") for one in photos]
    blocks.append(
        Photos(tuple(photos)) if photos
        else Sentences(("Neither system misses a pedestrian or is low anywhere: nothing to show.",))
    )  # fmt: skip
    return Section("frames", "Evidence frames", words.EVIDENCE, tuple(blocks))
