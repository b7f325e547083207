"""Sections of what the figures are worth: chance, subgroups, curves, stability, frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.analysis import Result
from nvcore.curve_summary import SUMMARY_ROWS, summarise_curve
from nvcore.curves import DetectionCurve, detection_curve
from nvcore.errors import InputError, one_line
from nvcore.figures.detection import CurveKind, curve_plot
from nvcore.figures.forest import subgroup_forest
from nvcore.figures.stability import stability_map
from nvcore.figures.style import count_text, heading
from nvcore.html_report import words
from nvcore.html_report.blocks import Block, Chart, Photo, Photos, Section, Sentences, table
from nvcore.html_report.charts import THEME, interval_plot
from nvcore.html_report.result_sections import FIGURES_HEAD
from nvcore.protocols import Protocol, filter_truth
from nvcore.scorecard import UNDEFINED, difference, number
from nvcore.stability import map_stability
from nvcore.stability_words import describe_stability
from nvcore.tables import sides
from nvcore.verdict import verdict

FORMS: Final = {
    "encounters_detected": ".1%",
    "encounters_detected_by_unit": ".1%",
    "mean_similarity": ".4f",
    "share_low": ".1%",
    "saliency": ".2f",
    "false_alert_episodes_per_hour": ".1f",
    "log_average_miss_rate": ".1%",
}
SHARES: Final = frozenset(name for name, form in FORMS.items() if form.endswith("%"))
CURVES: Final[dict[CurveKind, tuple[str, str]]] = {
    "miss_rate": ("Miss rate against false positives per image", "lower is better"),
    "precision_recall": ("Precision against recall", "higher is better"),
}
AT_ONCE: Final = 20_000
"""Frames up to which the stability map is made without being asked for."""


def verdict_section(result: Result, findings: Sequence[Any], evidence: pd.DataFrame) -> Section:
    """What the comparison supports."""
    told = verdict(result, tuple(findings), evidence=evidence)
    return Section("verdict", "Verdict", words.VERDICT, (Sentences(told, is_strong=True),))


def significance_section(evidence: pd.DataFrame) -> Section:
    """Every difference with interval, p-value and how they were made."""
    rows, ways = [], []
    for one in evidence.to_dict("records"):
        form = FORMS.get(one["figure"], ".4g")
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
            Chart("intervals", interval_plot(evidence, SHARES),
                  "Differences with their 95 % intervals"),
            table("Differences and tests", head, rows, right=range(1, 7)),
            table("How they were made", ("Figure", "From", "Method", "Note"), ways),
        ),
    )  # fmt: skip


def subgroups_section(subgroups: pd.DataFrame) -> Section:
    """Who detects more in which part of the encounters."""
    rows = []
    for one in subgroups.to_dict("records"):
        span = UNDEFINED
        if np.isfinite(one["low"]):
            span = f"{difference(one['low'], 0, '.1%')} to {difference(one['high'], 0, '.1%')}"
        rows.append((
            one["factor"], one["group"] if one["factor"] != "all" else "", one["n"], one["both"],
            one["x_only"], one["y_only"], one["neither"],
            difference(one["x"], one["y"], ".1%"), span, number(one["p"], ".2g"),
            number(one["p_holm"], ".2g"),
        ))  # fmt: skip
    head = ("Factor", "Group", "Encounters", "Both", "Only X", "Only Y", "Neither", "X - Y",
            "95 % interval", "p", "p (Holm)")  # fmt: skip
    notes = [
        f"{one['factor']} {one['group']}: {one['note']}."
        for one in subgroups.to_dict("records")
        if one["note"]
    ]
    return Section(
        "subgroups", "Subgroups", words.SUBGROUPS,
        (
            Chart("forest", subgroup_forest(subgroups, theme=THEME),
                  "Difference in the share detected by group"),
            table("Encounters detected by subgroup", head, rows, right=range(2, 11),
                  note=one_line(" ".join(notes))),
        ),
    )  # fmt: skip


def detection_section(result: Result, protocol: Protocol) -> Section:
    """Curves of both systems under a protocol, and their figures."""
    try:
        curves = [
            detection_curve(result.dataset, system.name, result.params, protocol)
            for _, system in sides(result)
        ]
    except InputError as error:
        why_not = Sentences((f"There are no curves: {error}.",))
        return Section("detection", "Detection curves", words.DETECTION, (why_not,))
    thresholds = [system.threshold for _, system in sides(result)]
    summaries = [
        summarise_curve(curve, threshold)
        for curve, threshold in zip(curves, thresholds, strict=True)
    ]
    rows = [
        (label, number(x, form), number(y, form), difference(x, y, form), better)
        for name, label, better, form in SUMMARY_ROWS
        for x, y in [[getattr(one, name) for one in summaries]]
    ]
    why = [
        f"{letter}: averages and areas are undefined: {one.why_undefined}."
        for letter, one in zip("XY", summaries, strict=True)
        if one.why_undefined is not None
    ]
    filters = "; ".join(protocol.filters)
    told = f"Protocol {protocol.name}: {protocol.text} {f'Filters: {filters}.' if filters else ''}"
    blocks: list[Block] = [Sentences((told.strip(), _left_out(result, protocol), *why))]
    legends = {
        "miss_rate": [
            f"LAMR {number(one.log_average_miss_rate, '.1%')}" for one in summaries
        ],
        "precision_recall": [
            f"AP {number(one.average_precision_coco, '.3f')}" for one in summaries
        ],
    }  # fmt: skip
    blocks += [_curve(curves, thresholds, kind, legends[kind]) for kind in CURVES]
    blocks.append(table("Detection figures", FIGURES_HEAD, rows, right=(1, 2, 3)))
    return Section("detection", "Detection curves", words.DETECTION, tuple(blocks))


def _left_out(result: Result, protocol: Protocol) -> str:
    """How many pedestrians count, and why the others do not."""
    truth = filter_truth(result.dataset, protocol)
    out = [f"{name} {n:,}" for name, n in truth.n_left_out.items() if n]
    counted = f"{count_text(truth.n_truth, 'pedestrian')} in {count_text(truth.n_images, 'image')}"
    return f"Counted: {counted}; ignored: {', '.join(out) or 'none'}."


def _curve(
    curves: Sequence[DetectionCurve], thresholds: Sequence[float | None], kind: CurveKind,
    legend: Sequence[str],
) -> Chart:  # fmt: skip
    title, best = CURVES[kind]
    figure = curve_plot(curves, thresholds, kind, theme=THEME, summaries=legend)
    if figure.layout.title.text:
        # the page's own subtitle invites to click
        extent = (
            f"{count_text(curves[0].n_truth, 'pedestrian')} in "
            f"{count_text(curves[0].n_images, 'image')}; {best}; large marks: thresholds in use"
        )
        figure.update_layout(title_text=heading(title, extent, theme=THEME))
    return Chart(f"curve-{kind.replace('_', '-')}", figure, f"{title} of X and Y; {best}")


def stability_section(result: Result, *, wanted: bool | None) -> Section:
    """The map of the verdict over alpha and midpoint, or why there is none.

    Parameters
    ----------
    wanted
        None: if there are at most `AT_ONCE` frames.
    """
    n_frames = len(result.dataset.frames)
    blocks: tuple[Block, ...]
    if wanted is False or (wanted is None and n_frames > AT_ONCE):
        blocks = (Sentences((f"Not computed for these {n_frames:,} frames: not asked for.",)),)
    else:
        try:
            found = map_stability(result, "alpha-midpoint", "similarity")
        except InputError as error:
            blocks = (Sentences((f"There is no such map: {error}",)),)
        else:
            told = describe_stability(found)
            figure = stability_map(found, theme=THEME)
            blocks = (Sentences(told), Chart("stability", figure, told[0]))
    return Section("stability", "Does the verdict depend on the settings", words.STABILITY, blocks)


def frames_section(photos: Sequence[Photo], troubles: Sequence[str]) -> Section:
    """The evidence frames."""
    blocks: list[Block] = []
    if troubles:
        blocks.append(Sentences(("Some pictures cannot be shown.", *troubles)))
    blocks.append(
        Photos(tuple(photos)) if photos
        else Sentences(("Neither system misses a pedestrian or is low anywhere: nothing to show.",))
    )  # fmt: skip
    return Section("frames", "Evidence frames", words.EVIDENCE, tuple(blocks))
