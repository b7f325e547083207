"""Sections on how sure differences are: tests, subgroups, plans, curves, stability, frames."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.arguments.plan import PlanArguments
from nvcore.common.errors import InputError
from nvcore.common.progress import Progress, no_progress, part_of
from nvcore.common.wording import (
    UNDEFINED,
    capitalised,
    difference,
    duration_text,
    number,
    one_line,
    percent,
)
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.of_encounters import DETECTED
from nvcore.comparison.measures.table import doubt_of, evidence_form, measure_of, repeated_by
from nvcore.evidence.measures import evidence_of
from nvcore.evidence.operating_points import are_unequal
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.planning.notes import QUESTION
from nvcore.evidence.planning.pilot import MIN_PILOT, PLAN_KEYS
from nvcore.evidence.planning.plan import Plan, plan_recordings
from nvcore.evidence.planning.thresholds import vary_thresholds
from nvcore.evidence.stability.notes import (
    CRITERIA,
    PLANES,
    describe_chance,
    describe_equal_alarms,
    describe_stability,
)
from nvcore.evidence.stability.survey import SurveyRow, survey_stability, survey_table
from nvcore.evidence.subgroups import ALL
from nvcore.evidence.units import WHOLE, find_units
from nvcore.figures import CurveKind, curve_plot, stability_map, subgroup_forest
from nvcore.figures.dots import forest_in_words
from nvcore.metrics.detection.curve_summary import CurveSummary, summarise_curve
from nvcore.metrics.detection.curves import DetectionCurve, detection_curve
from nvcore.metrics.detection.filtered_truth import filter_truth
from nvcore.metrics.detection.miss_rate import explain_few
from nvcore.notes import Note
from nvcore.report.decisive_moments import APART_S, MOST
from nvcore.report.section import (
    IN_THE_FILE,
    Block,
    Chart,
    Columns,
    Fold,
    Paragraphs,
    Photo,
    Photos,
    Row,
    Section,
    Table,
    Text,
    Topics,
    about,
    listing,
    table,
)
from nvcore.report.sections.results import (
    MEASURES_HEAD,
    PART,
    basis_text,
    evidence_columns,
    measure_columns,
)
from nvcore.report.verdict import Verdict
from nvcore.report.words import score_cells
from nvcore.settings.protocols import Protocol
from nvcore.tables.scorecard import curve_rows

IN_SUBGROUPS: Final = "in subgroups.csv"
CURVES: Final[dict[CurveKind, tuple[str, str]]] = {
    "miss_rate": ("Miss rate against false positives per image", "lower is better"),
    "precision_recall": ("Precision against recall", "higher is better"),
}
AT_ONCE: Final = 20_000
"""Maximum number of frames for which the stability maps are computed by default."""


def verdict_section(result: Result, conclusion: Verdict) -> Section:
    """Return the section on what the headline is based on. The headline is on the first page."""
    introduction = about("sections.verdict", result)
    blocks = (Topics(conclusion.topics),)
    return Section("verdict", "What the verdict rests on", introduction, blocks)


def plan_measures(
    result: Result, evidence: pd.DataFrame, protocol: Protocol, *, progress: Progress
) -> dict[str, Plan]:
    """Plan a study for each measure without a significant difference, by key.

    {} if the recordings are too few for a pilot.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result.
    protocol
        Selection of the pedestrians for the log-average miss rate.
    """
    if not _has_pilot(evidence):
        return {}
    not_shown = [
        (name, key, row)
        for name, key in PLAN_KEYS.items()
        if (row := evidence_of(evidence, key)) is not None
        and not repeated_by(key)
        and not doubt_of(result, measure_of(key))
        and not row.p_corrected <= SIGNIFICANT
    ]
    n, units = len(not_shown), find_units(result)
    thresholds = vary_thresholds(result, units) if not_shown else {}
    return {
        key: plan_recordings(
            result,
            PlanArguments(name),
            protocol=protocol,
            units=units,
            evidence=row,
            thresholds=thresholds,
            progress=part_of(progress, index / n, (index + 1) / n),
        )
        for index, (name, key, row) in enumerate(not_shown)
    }


def _has_pilot(evidence: pd.DataFrame) -> bool:
    return bool(evidence["unit"].isin(WHOLE).any())


def plan_section(result: Result, evidence: pd.DataFrame, plans: Mapping[str, Plan]) -> Section:
    """Return the section on the plans of `plan_measures`, or on why there are none."""
    blocks: tuple[Block, ...]
    if not _has_pilot(evidence):
        blocks = (Paragraphs((Note("sections.no_pilot", n=MIN_PILOT),)),)
    elif not plans:
        blocks = (Paragraphs((Note("sections.nothing_to_plan", p=SIGNIFICANT),)),)
    else:
        share = percent(PlanArguments.power)
        title = f"Recordings that would show a difference as found, in {share} of studies"
        measures = defaultdict(list)
        for plan in plans.values():
            measures[plan.sizes[0].reason].append(plan.evidence.label)
        reasons = [
            f"{capitalised('; '.join(labels))}: {reason}."
            for reason, labels in measures.items()
            if reason
        ]
        advice = [Note("plan.optimistic"), Note("plan.fresh")]
        advice += [Note("plan.unequal")] if are_unequal(result) else []
        rows = [_plan_row(plan) for plan in plans.values()]
        head, cells = tuple(rows[0]), [tuple(row.values()) for row in rows]
        planned = table(title, head, cells, right=range(1, len(head)), notes=reasons)
        blocks = (planned, Paragraphs(tuple(advice)))
    return Section("plan", QUESTION.rstrip("?"), about("sections.plan", result), blocks)


def _plan_row(plan: Plan) -> dict[str, str]:
    row, (size,) = plan.evidence, plan.sizes
    form = evidence_form(row.figure)
    is_found = size.n_recordings is not None
    span = f"{size.least_recordings:,} to {size.most_recordings:,}" if is_found else UNDEFINED
    return {
        "Measure": row.label,
        "X − Y": difference(row.difference, 0, form),
        "Excluded: below": difference(row.low, 0, form),
        "Excluded: above": difference(row.high, 0, form),
        "Recordings": number(size.n_recordings, "d"),
        "Range": span,
        "Encounters": number(size.n_encounters if is_found else None, "d"),
        "Time": duration_text(size.duration_s) if is_found else UNDEFINED,
    }


def subgroups_section(result: Result, subgroups: pd.DataFrame) -> Section:
    """Return the section on all measures for groups of encounters, with who detects more."""
    is_detected = subgroups["figure"] == DETECTED
    is_shown = subgroups[["low", "p"]].notna().any(axis=1) | (subgroups["factor"] == ALL)
    n_left_out = int((np.isfinite(subgroups["x"]) & ~is_shown).sum())
    rows, shown = subgroups[is_detected], subgroups[is_detected & is_shown]
    columns: Columns = {
        **_GROUP,
        "Encounters": ("n", "d"),
        "Both": ("both", "d"),
        "Only X": ("x_only", "d"),
        "Only Y": ("y_only", "d"),
        "Neither": ("neither", "d"),
        **evidence_columns("p (Holm)"),
    }
    detected = listing("Encounters detected by subgroup", shown, columns, notes=_group_notes(shown))
    others = tuple(
        _by_subgroup(of_measure)
        for _, of_measure in subgroups[~is_detected & is_shown].groupby("figure", sort=False)
        if len(of_measure) > 1
    )
    forest = partial(subgroup_forest, rows, theme=result.scheme("light"))
    nothing = forest_in_words(rows)
    left_out = [Paragraphs((Note("sections.too_little", n=n_left_out),))] if n_left_out else []
    blocks: tuple[Block, ...] = (
        Paragraphs((nothing,))
        if nothing
        else Chart("forest", forest, "Difference in the share detected by group"),
        Fold("All measures by subgroup", (detected, *others), IN_SUBGROUPS),
        *left_out,
    )
    return Section("subgroups", "Subgroups", about("sections.subgroups", result), blocks)


def _group(row: Row) -> str:
    return row["group"] if row["factor"] != ALL else ""


_GROUP: Final[Columns] = {"Factor": "factor", "Group": _group}


def _by_subgroup(rows: pd.DataFrame) -> Table:
    """Return a table of one measure for all encounters and for each group."""
    title = f"{capitalised(rows['label'].iloc[0])}, by subgroup"
    columns = {**_GROUP, "From": basis_text, **measure_columns("p (Holm)")}
    return listing(title, rows, columns, notes=_group_notes(rows))


def _group_notes(rows: pd.DataFrame) -> list[str]:
    """Return each distinct note once, preceded by the groups that have it."""
    groups: dict[str, list[str]] = {}
    for row in rows.to_dict("records"):
        for note in filter(None, row["note"].split("; ")):
            groups.setdefault(note, []).append(f"{row['factor']} {_group(row)}".strip())
    return [
        one_line(f"{'All' if len(of) == len(rows) else ', '.join(of)}: {note}.")
        for note, of in groups.items()
    ]


def detection_section(result: Result, protocol: Protocol) -> Section:
    """Return the section on the detection curves of X and Y under a protocol, with measures."""
    introduction, title = about("sections.detection", result), "Detection curves"
    try:
        curves = [
            detection_curve(result.dataset, name, result.params, protocol) for name in result.names
        ]
    except InputError as error:
        why_not = Paragraphs((Note("sections.no_curves", error=str(error)),))
        return Section("detection", title, introduction, (why_not,))
    thresholds = [system.threshold for _, system in result.sides]
    summaries = [*map(summarise_curve, curves, thresholds)]
    truth = filter_truth(result.dataset, protocol)
    filters = f" Filters: {'; '.join(protocol.filters)}." if protocol.filters else ""
    texts: list[Text] = [
        f"Protocol {protocol.title}: {result.objects.say(protocol.text)}{filters}",
        Note(
            "sections.counted",
            n=truth.n_truth,
            images=truth.n_images,
            left_out=truth.left_out or "none is ignored",
        ),
    ]
    for letter, of in zip("xy", summaries, strict=True):
        if of.why_undefined is not None:
            texts.append(Note("sections.no_averages", system=letter, why=of.why_undefined))
    for letter, of in zip("xy", summaries, strict=True):
        if of.notes:
            texts.append(Note("sections.references", system=letter, notes=of.notes))
    few = explain_few(curves[0].n_truth, result.objects)
    texts += [f"{capitalised(few)}."] if few else []
    rows = score_cells(curve_rows(*summaries), indent=PART)
    miss_rate, precision_recall = (
        _curve(result, curves, thresholds, kind, summaries) for kind in CURVES
    )
    blocks: tuple[Block, ...] = (
        Paragraphs(tuple(texts)),
        table("Detection measures", MEASURES_HEAD, rows, right=(1, 2, 3)),
        miss_rate,
        Fold(CURVES["precision_recall"][0], (precision_recall,)),
    )
    return Section("detection", title, introduction, blocks)


def _curve(
    result: Result,
    curves: Sequence[DetectionCurve],
    thresholds: Sequence[float | None],
    kind: CurveKind,
    summaries: Sequence[CurveSummary],
) -> Chart:
    title, best = CURVES[kind]
    draw = partial(
        curve_plot,
        curves,
        thresholds,
        kind,
        theme=result.scheme("light"),
        summaries=summaries,
        hint=best,
        published=result.dataset.settings.published,
        objects=result.objects,
    )
    return Chart(f"curve-{kind.replace('_', '-')}", draw, f"{title} of X and Y; {best}")


def stability_section(
    result: Result,
    evidence: pd.DataFrame,
    *,
    is_wanted: bool | None,
    progress: Progress = no_progress,
) -> Section:
    """Return the section on the verdict's stability: a table of all maps, one drawn as a figure.

    If the maps are not computed, the section says why.

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
    title, introduction = (
        "Does the verdict depend on the settings",
        about("sections.stability", result),
    )
    if is_wanted is False or (is_wanted is None and n_frames > AT_ONCE):
        why_not = Paragraphs((Note("sections.not_computed", n=n_frames),))
        return Section("stability", title, introduction, (why_not,))
    with ThreadPoolExecutor() as pool:
        rows = survey_stability(result, executor=pool, progress=progress)
    order = sorted(range(len(rows)), key=lambda number: _holds(rows[number]))  # unstable first
    columns: Columns = {
        "Settings": "settings",
        "Better by": "by",
        "As analysed": "verdict",
        "Holds in (of the plausible range)": "share",
        "Nearest setting that overturns it": "nearest",
    }
    survey = listing(
        "Verdict and settings",
        survey_table(rows).iloc[order],
        columns,
        printed=len(rows) - sum(map(_holds, rows)),
        rest=f"the verdict holds throughout the plausible range, {IN_THE_FILE}",
    )
    first = rows[0]  # alpha and midpoint, by mean similarity
    assert first.stability is not None
    in_short, *sentences = describe_stability(first.stability)
    plane = f"{PLANES[first.plane]}, by {CRITERIA[first.criterion]}: {in_short}"
    drawn = partial(stability_map, first.stability, theme=result.scheme("light"))
    in_words = (*_chance_of_each(rows, evidence), *_at_equal_alarms(rows))
    blocks: tuple[Block, ...] = (
        survey,
        Fold("Is that more than chance, and at equal false alarms", (Paragraphs(in_words),)),
        Chart("stability", drawn, in_short),
        Fold("This map in words", (Paragraphs((plane, *sentences)),)),
    )
    return Section("stability", title, introduction, blocks)


def _holds(row: SurveyRow) -> bool:
    """Return whether the verdict holds throughout the plausible range of the settings."""
    stability = row.stability
    if stability is None or stability.verdict == "undefined":
        return False
    return not row.is_dependent or stability.share_held == 1


def _at_equal_alarms(rows: Sequence[SurveyRow]) -> tuple[str, ...]:
    """Describe which system is better at thresholds with equal false alarms, for each map."""
    maps = [stability.stability for stability in rows if stability.stability is not None]
    return tuple(filter(None, (describe_equal_alarms(stability) for stability in maps)))


def _chance_of_each(rows: Sequence[SurveyRow], evidence: pd.DataFrame) -> tuple[str, ...]:
    """Describe for each criterion whether the difference as analysed is significant."""
    maps = {row.criterion: row.stability for row in rows if row.stability is not None}
    texts = {criterion: describe_chance(a_map, evidence) for criterion, a_map in maps.items()}
    return tuple(
        f"By {CRITERIA[criterion]}: {text[0].lower()}{text[1:]}"
        for criterion, text in texts.items()
        if text
    )


def frames_section(result: Result, photos: Sequence[Photo], troubles: Sequence[str]) -> Section:
    """Return the section of evidence frames. If all are blank, the reason is given only once."""
    blocks: list[Block] = []
    if troubles:
        blocks.append(Paragraphs(("Some pictures cannot be shown.", *troubles)))
    if photos and all(photo.why_blank for photo in photos):
        blocks.append(Paragraphs((Note("sections.no_pictures"),)))
        photos = [replace(photo, why_blank="") for photo in photos]
    nothing = Paragraphs((Note("sections.no_frames"),))
    blocks.append(Photos(tuple(photos)) if photos else nothing)
    introduction = about("sections.frames", result, apart_s=APART_S, most=MOST)
    return Section("frames", "Evidence frames", introduction, tuple(blocks))
