"""Sections over settings: curves over all thresholds, and where the verdict turns."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Final

import pandas as pd

from nvcore.comparison import Result
from nvcore.detection.curve_summary import summarise_curve
from nvcore.detection.curves import DetectionCurve, detection_curve
from nvcore.detection.filtered_truth import filter_truth
from nvcore.detection.miss_rate import explain_few
from nvcore.errors import InputError
from nvcore.figures.detection import CurveKind, curve_plot, legend_text
from nvcore.figures.stability import stability_map
from nvcore.progress import Progress, no_progress
from nvcore.protocols import Protocol
from nvcore.report.html import words
from nvcore.report.html.blocks import IN_THE_FILE, Block, Chart, Fold, Section, Sentences, table
from nvcore.report.html.result_sections import MEASURES_HEAD, PART
from nvcore.report.words import score_cells
from nvcore.stability.notes import (
    CRITERIA,
    PLANES,
    describe_chance,
    describe_equal_alarms,
    describe_stability,
)
from nvcore.stability.survey import SurveyRow, survey_stability, survey_table
from nvcore.tables.scorecard import curve_rows
from nvcore.wording import capitalised, count_text

CURVES: Final[dict[CurveKind, tuple[str, str]]] = {
    "miss_rate": ("Miss rate against false positives per image", "lower is better"),
    "precision_recall": ("Precision against recall", "higher is better"),
}
STABILITY_TITLE: Final = "Does the verdict depend on the settings"
AT_ONCE: Final = 20_000
"""Most frames for which the stability maps are computed by default."""


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
    summaries = [*map(summarise_curve, curves, thresholds)]
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
