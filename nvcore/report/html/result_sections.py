"""Sections of what was found: scorecard, encounters, similarity, saliency, false alerts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from nvcore.comparison import Result, SystemResult
from nvcore.figures.encounters import miss_classes_plot
from nvcore.figures.paired import recordings_plot
from nvcore.figures.venn import WORDS, venn_figure
from nvcore.measures import MeasureTable
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.report.html import words
from nvcore.report.html.blocks import MAX_ROWS, Chart, Section, Sentences, Table, table
from nvcore.report.html.charts import THEME
from nvcore.report.html.input_sections import span_in_use
from nvcore.report.words import describe_fusion, describe_lead, describe_misses, describe_saliency
from nvcore.schema import CATEGORY_TEXT, MISS_CLASS_TEXT, Category
from nvcore.tables.miss_classes import fusion_table
from nvcore.tables.moments import encounter_moments
from nvcore.tables.result import (
    encounters_table,
    recordings_table,
    worst_events,
    worst_intervals,
)
from nvcore.tables.scorecard import ScoreRow, score_rows
from nvcore.wording import UNDEFINED, count_text, difference, number

MEASURES_HEAD = ("Figure", "X", "Y", "X - Y", "Better")
N_WORST = 3
"""Intervals, events and episodes of each system that are listed."""


def names_of(result: Result) -> tuple[str, str]:
    """Names of X and Y."""
    return result.x.name, result.y.name


def scorecard_section(result: Result) -> Section:
    """All measures side by side."""
    rows = [score_row(row) for row in score_rows(result)]
    rows.append((f"how the {result.venn.n_near} encounters went:", "", "", "", ""))
    rows += [score_row(row) for row in score_rows(result, MeasureTable.MISS_CLASSES)]
    return Section(
        "scorecard", "Scorecard", words.scorecard(result.params),
        (table("Figures of X and Y", MEASURES_HEAD, rows, right=(1, 2, 3)),),
    )  # fmt: skip


def score_row(row: ScoreRow) -> tuple[str, ...]:
    """Cells of a measure, as `MEASURES_HEAD` names them."""
    label = ("– " if row.level else "") + row.label
    shown = (number(row.x, row.form), number(row.y, row.form), difference(row.x, row.y, row.form))
    return (label, *shown, row.better)


def encounters_section(result: Result) -> Section:
    """Who detects whom, and how those missed are missed."""
    counts = result.venn.counts()
    in_words = ", ".join(f"{WORDS[kind]} {counts[kind]}" for kind in Category)
    classes = [
        (row.label, number(row.x, "d"), number(row.y, "d"), MISS_CLASS_TEXT[kind])
        for row, kind in zip(
            score_rows(result, MeasureTable.MISS_CLASSES), MISS_CLASS_TEXT, strict=True
        )
    ]
    said = (*describe_misses(result), describe_lead(result))
    fusion = fusion_table(result)
    names = names_of(result)
    return Section(
        "encounters", "Who detects whom", words.who(result.params),
        (
            table("Encounters by who detects them", ("Category", "Encounters", "Meaning"),
                  [(WORDS[kind], counts[kind], CATEGORY_TEXT[kind]) for kind in Category],
                  right=(1,)),
            Chart("venn", venn_figure(result.venn, names, theme=THEME), f"Encounters: {in_words}"),
            Sentences(said),
            Chart("classes", miss_classes_plot(encounters_table(result), names, theme=THEME),
                  "How many encounters each system fails in which way"),
            table("How they were missed", ("Class", "X", "Y", "Meaning"), classes, right=(1, 2)),
            _boxes(result),
            Sentences(describe_fusion(fusion)),
            _fusion(fusion),
        ),
    )  # fmt: skip


def _boxes(result: Result) -> Table:
    """Which system matches how many boxes of the truth."""
    boxes = result.boxes
    counts = (boxes.both, boxes.x_only, boxes.y_only, boxes.neither)
    head = ("Matched by both", "Only by X", "Only by Y", "By neither")
    ignored = " and ".join(
        f"{system.matches.n_absorbed:,} detections of {letter.upper()}"
        for letter, system in result.sides
    )
    note = (
        f"Near and distant pedestrians, frame by frame. {ignored} lie on people or regions that "
        "the ground truth ignores and do not count."
    )
    rows = [[f"{n:,}" for n in counts]]
    return table("Boxes of pedestrians by who matches them", head, rows, right=range(4), note=note)


def _fusion(fusion: pd.DataFrame) -> Table:
    """Both systems as one, beside each of them."""
    names = {"x": "X alone", "y": "Y alone", "x_or_y": "X or Y", "x_and_y": "X and Y"}
    rows = [
        (
            names[one["system"]], f"{one['encounters_detected']:,}",
            f"{one['false_alert_episodes']:,}", number(one["episodes_per_hour"], ".1f"),
            number(one["mean_similarity"], ".4f"),
        )
        for one in fusion.to_dict("records")
    ]  # fmt: skip
    head = ("System", "Encounters detected", "False-alert episodes", "Per hour",
            "Mean similarity")  # fmt: skip
    note = (
        "What if both were one system: \u201cX or Y\u201d shows what either shows (a pair of boxes "
        "that overlap once), \u201cX and Y\u201d only what both show."
    )
    return table("X and Y as one system", head, rows, right=range(1, 5), note=note)


def similarity_section(result: Result) -> Section:
    """Mean similarity by recording, and the worst intervals."""
    recordings = recordings_table(result)
    listed, note = _most_different(recordings)
    rows = [
        (
            one["recording"], f"{one['n_frames']:,}",
            *(number(one[f"mean_similarity_{letter}"], ".4f") for letter in "xy"),
            difference(one["mean_similarity_x"], one["mean_similarity_y"], ".4f"),
            *(number(one[f"share_low_{letter}"], ".1%") for letter in "xy"),
        )
        for one in listed.to_dict("records")
    ]  # fmt: skip
    low = f"below {result.params.low:g}"
    head = ("Recording", "Frames", "Mean X", "Mean Y", "X - Y", f"{low}, X", f"{low}, Y")
    return Section(
        "similarity", "Similarity", words.similarity(
            result.params, span_in_use(result, "midpoint"), span_in_use(result, "spread")
        ),
        (
            Chart("recordings", recordings_plot(recordings, names_of(result), theme=THEME),
                  "Mean similarity of X and Y in every recording"),
            table("Similarity by recording", head, rows, right=range(1, 7), note=note),
            _intervals(result),
        ),
    )  # fmt: skip


def _most_different(recordings: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """The recordings that are listed, in their order, and what is left out."""
    if len(recordings) <= MAX_ROWS:
        return recordings, ""
    apart = (recordings["mean_similarity_x"] - recordings["mean_similarity_y"]).abs()
    chosen = apart.sort_values(ascending=False, kind="stable").index[:MAX_ROWS].sort_values()
    note = (
        f"The {MAX_ROWS} recordings in which the systems differ most are shown, "
        f"{len(recordings) - MAX_ROWS:,} are left out."
    )
    return recordings.loc[chosen], note


def _intervals(result: Result) -> Table:
    worst = pd.concat([worst_intervals(result, letter, n=N_WORST) for letter in "xy"])
    rows = [
        (
            one["system"].upper(), one["recording"], f"{one['first_frame']} to {one['last_frame']}",
            f"{one['start_s']:.2f}", f"{one['duration_s']:.2f}", f"{one['severity_s']:.3f}",
            f"{one['min_similarity']:.3f}",
        )
        for one in worst.to_dict("records")
    ]  # fmt: skip
    head = ("System", "Recording", "Frames", "Start (s)", "Duration (s)", "Severity (s)", "Lowest")
    return table("The worst low intervals", head, rows, right=range(3, 7))


def saliency_section(result: Result) -> Section:
    """How saliency comes about, and the largest events."""
    worst = pd.concat([worst_events(result, letter, n=N_WORST) for letter in "xy"])
    rows = [
        (
            one["system"].upper(), one["recording"], one["track"], f"{one['start_s']:.2f}",
            f"{one['duration_s']:.2f}", f"{one['tau']:.3f}", f"{one['recency']:.3f}",
            f"{one['saliency_s']:.3f}",
        )
        for one in worst.to_dict("records")
    ]  # fmt: skip
    head = ("System", "Recording", "Pedestrian", "Start (s)", "Duration (s)", "Passed at its end",
            "Recency", "Saliency (s)")  # fmt: skip
    return Section(
        "saliency", "Saliency", words.saliency(result.params),
        (
            Sentences(describe_saliency(result)),
            table("The most salient events", head, rows, right=range(3, 8)),
        ),
    )  # fmt: skip


def false_alerts_section(result: Result) -> Section:
    """False alarms and episodes of both systems."""
    rows = [score_row(row) for row in score_rows(result, MeasureTable.FALSE_ALERTS)]
    head = ("System", "Recording", "Frames", "Start (s)", "Duration (s)", "Boxes")
    return Section(
        "false-alerts", "False alerts", words.FALSE_ALERTS,
        (
            table("False alarms and episodes", MEASURES_HEAD, rows, right=(1, 2, 3)),
            table("The longest episodes", head, _episodes(result), right=range(3, 6)),
        ),
    )  # fmt: skip


def _episodes(result: Result) -> list[tuple[Any, ...]]:
    frames, name = result.dataset.frames, result.dataset.recordings["name"]
    rows = []
    for letter, system in result.sides:
        longest = system.episodes.sort_values("duration_s", ascending=False, kind="stable")
        for one in longest.head(N_WORST).to_dict("records"):
            first, last = (int(frames["frame"].iloc[one[key]]) for key in ("first_row", "last_row"))
            start = f"{frames['time_s'].iloc[one['first_row']]:.2f}"
            rows.append((letter.upper(), name.iloc[one["recording"]], f"{first} to {last}", start,
                         f"{one['duration_s']:.2f}", one["n_boxes"]))  # fmt: skip
    return rows


def only_one_section(result: Result) -> Section:
    """Encounters that only one system detects, row by row, the gravest first."""
    encounters = encounters_table(result)
    moments = encounter_moments(result)
    weights = {letter: _missed_weighted_s(result, system) for letter, system in result.sides}
    time_s = result.dataset.frames["time_s"].to_numpy()
    category = encounters["category"].to_numpy()
    chosen = np.flatnonzero(np.isin(category, [Category.X_ONLY.value, Category.Y_ONLY.value]))
    is_x_only = category[chosen] == Category.X_ONLY.value
    missed_s = np.where(is_x_only, weights["y"][chosen], weights["x"][chosen])
    order = np.argsort(-missed_s, kind="stable")
    rows: list[tuple[Any, ...]] = []
    for place in order[:MAX_ROWS].tolist():
        one = encounters.iloc[chosen[place]]
        letter, other = ("x", "y") if is_x_only[place] else ("y", "x")
        row = int(moments[f"missed_row_{other}"].iloc[chosen[place]])
        rows.append((
            f"only {letter.upper()}", one["recording"], one["track"],
            f"{time_s[row]:.2f}" if row >= 0 else UNDEFINED, f"{missed_s[place]:.2f}",
            one["n_relevant"], f"{one['peak_height']:.0f}",
            number(one["coverage_x"], ".0%"), number(one["coverage_y"], ".0%"),
            str(one[f"miss_class_{other}"]).replace("_", " "),
        ))  # fmt: skip
    head = ("Detected by", "Recording", "Pedestrian", "Missed from (s)", "Weighted missed time (s)",
            "Relevant frames", "Height (px)", "Coverage X", "Coverage Y",
            "The other's failure")  # fmt: skip
    title = f"{count_text(len(chosen), 'encounter')} that only one system detects"
    left_out = len(chosen) - len(rows)
    note = f"The gravest {len(rows):,} are shown, {left_out:,} are left out." if left_out else ""
    shown = table(title, head, rows, right=range(3, 9), note=note)
    return Section("only-one", "Encounters that only one detects", words.ONLY_ONE, (shown,))


def _missed_weighted_s(result: Result, system: SystemResult) -> np.ndarray:
    """Time in which a system misses each encounter, times weight of nearness, s; shape (n,)."""
    encounters, frames = result.encounters, result.dataset.frame_columns
    rows, at = encounters.order, encounters.frame_index
    of = np.repeat(np.arange(len(encounters)), np.diff(encounters.offsets))
    step_s = frames.gap[at] / frames.fps[frames.recording[at]]
    is_missed = ~system.matches.is_matched[rows] & (result.k_truth.k[rows] >= RELEVANT_K)
    weights = np.where(is_missed, result.k_truth.k[rows] * step_s, 0.0)
    return np.bincount(of, weights=weights, minlength=len(encounters))
