"""Sections with the results: scorecard, encounters, similarity, saliency, false alerts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.figures.encounters import miss_classes_plot
from nvcore.figures.loss_strip import loss_strip_plot
from nvcore.figures.paired import recordings_plot
from nvcore.figures.venn import WORDS, venn_figure
from nvcore.measures import MeasureTable
from nvcore.report.html import words
from nvcore.report.html.blocks import MAX_ROWS, Chart, Section, Sentences, Table, table
from nvcore.report.html.charts import THEME
from nvcore.report.html.input_sections import span_in_use
from nvcore.report.words import (
    describe_fusion,
    describe_lead,
    describe_misses,
    describe_saliency,
    score_cells,
    scorecard_cells,
)
from nvcore.schema import CATEGORY_TEXT, MISS_CLASS_TEXT, Category
from nvcore.tables.loss_strip import loss_strip
from nvcore.tables.miss_classes import fusion_table
from nvcore.tables.moments import encounter_moments
from nvcore.tables.result import (
    encounters_table,
    recordings_table,
    worst_events,
    worst_intervals,
)
from nvcore.tables.scorecard import score_rows
from nvcore.tables.severity import weighed_encounters
from nvcore.tables.windows import windows_table
from nvcore.wording import UNDEFINED, count_text, difference, number

MEASURES_HEAD = ("Measure", "X", "Y", "X - Y", "Better")
PART = "– "
"""Before the label of a measure that is a part of the one above."""
N_HEAVIEST = 10
"""How many of the encounters that weigh most are listed."""
N_WORST = 3
"""How many intervals, events and episodes of each system are listed."""


def names_of(result: Result) -> tuple[str, str]:
    """Names of X and Y."""
    return result.x.name, result.y.name


def scorecard_section(result: Result) -> Section:
    """All measures side by side."""
    rows = scorecard_cells(result, indent=PART)
    return Section(
        "scorecard",
        "Scorecard",
        words.scorecard(result.params),
        (table("Measures of X and Y", MEASURES_HEAD, rows, right=(1, 2, 3)),),
    )


def encounters_section(result: Result) -> Section:
    """Which system detects which pedestrians, and how the others are missed."""
    counts = result.venn.counts()
    in_words = ", ".join(f"{WORDS[kind]} {counts[kind]}" for kind in Category)
    classes = [
        (row.label, number(row.x, "d"), number(row.y, "d"), MISS_CLASS_TEXT[kind])
        for row, kind in zip(
            score_rows(result, MeasureTable.MISS_CLASSES), MISS_CLASS_TEXT, strict=True
        )
    ]
    sentences = (*describe_misses(result), describe_lead(result))
    fusion = fusion_table(result)
    names = names_of(result)
    encounters = weighed_encounters(result)
    return Section(
        "encounters",
        "Who detects whom",
        words.who(result.params),
        (
            table(
                "Encounters by who detects them",
                ("Category", "Encounters", "Severity X (s)", "Severity Y (s)", "Meaning"),
                [
                    (WORDS[kind], counts[kind], *_severities(result, kind), CATEGORY_TEXT[kind])
                    for kind in Category
                ],
                right=(1, 2, 3),
            ),
            Chart(
                "venn",
                venn_figure(result.venn, names, theme=THEME, encounters=encounters),
                f"Encounters: {in_words}",
            ),
            _heaviest(result, encounters),
            Sentences(sentences),
            Chart(
                "classes",
                miss_classes_plot(encounters_table(result), names, theme=THEME),
                "How many encounters each system fails in which way",
            ),
            table("How they were missed", ("Class", "X", "Y", "Meaning"), classes, right=(1, 2)),
            _boxes(result),
            Sentences(describe_fusion(fusion)),
            _fusion(fusion),
        ),
    )


def _severities(result: Result, kind: Category) -> tuple[str, str]:
    """What X's and Y's failures weigh in a category; distant encounters have no weight."""
    if kind is Category.DISTANT:
        return UNDEFINED, UNDEFINED
    x_s, y_s = (result.severity_of(system)[kind] for _, system in result.sides)
    return f"{x_s:.2f}", f"{y_s:.2f}"


def _heaviest(result: Result, encounters: pd.DataFrame) -> Table:
    """The encounters whose failures weigh most."""
    time_s = result.dataset.frames["time_s"].to_numpy()
    heaviest = encounters[encounters["severity_s"] > 0].head(N_HEAVIEST)
    rows = [
        (
            row["recording"],
            row["track"],
            WORDS[Category(row["category"])],
            f"{time_s[row['shown_row']]:.2f}",
            *(f"{row[f'severity_s_{letter}']:.2f}" for letter in "xy"),
            *(f"{row[f'peak_cost_{letter}']:.2f}" for letter in "xy"),
            *(str(row[f"miss_class_{letter}"]).replace("_", " ") for letter in "xy"),
        )
        for row in heaviest.to_dict("records")
    ]
    head = (
        *("Recording", "Pedestrian", "Detected by", "Costs most at (s)"),
        *("Severity X (s)", "Severity Y (s)", "Peak cost X", "Peak cost Y"),
        *("Failure of X", "Failure of Y"),
    )
    title = "The encounters whose failures weigh most"
    note = "Sorted by the larger severity of the two; the time is that of its largest cost."
    return table(title, head, rows, right=range(3, 8), note=note)


def _boxes(result: Result) -> Table:
    """How many boxes of the truth each system matches."""
    boxes = result.boxes
    counts = (boxes.both, boxes.x_only, boxes.y_only, boxes.neither)
    head = ("Matched by both", "Only by X", "Only by Y", "By neither")
    n_absorbed = " and ".join(
        f"{system.matches.n_absorbed:,} detections of {letter.upper()}"
        for letter, system in result.sides
    )
    note = (
        f"Near and distant pedestrians, frame by frame. {n_absorbed} lie on people or regions that "
        "the ground truth ignores and do not count."
    )
    rows = [[f"{n:,}" for n in counts]]
    return table("Boxes of pedestrians by who matches them", head, rows, right=range(4), note=note)


def _fusion(fusion: pd.DataFrame) -> Table:
    """Both systems as one system, beside each of them."""
    names = {"x": "X alone", "y": "Y alone", "x_or_y": "X or Y", "x_and_y": "X and Y"}
    rows = [
        (
            names[row["system"]],
            f"{row['encounters_detected']:,}",
            f"{row['false_alert_episodes']:,}",
            number(row["episodes_per_hour"], ".1f"),
            number(row["mean_similarity"], ".4f"),
        )
        for row in fusion.to_dict("records")
    ]
    head = ("System", "Encounters detected", "False-alert episodes", "Per hour", "Mean similarity")
    note = (
        "What if both were one system: \u201cX or Y\u201d shows what either shows (a pair of boxes "
        "that overlap once), \u201cX and Y\u201d only what both show."
    )
    return table("X and Y as one system", head, rows, right=range(1, 5), note=note)


def similarity_section(result: Result) -> Section:
    """Mean similarity by recording, and the worst intervals."""
    recordings = recordings_table(result)
    recordings_shown, note = _most_different(recordings)
    rows = [
        (
            row["recording"],
            f"{row['n_frames']:,}",
            *(number(row[f"mean_similarity_{letter}"], ".4f") for letter in "xy"),
            difference(row["mean_similarity_x"], row["mean_similarity_y"], ".4f"),
            *(number(row[f"share_low_{letter}"], ".1%") for letter in "xy"),
        )
        for row in recordings_shown.to_dict("records")
    ]
    low = f"below {result.params.low:g}"
    head = ("Recording", "Frames", "Mean X", "Mean Y", "X - Y", f"{low}, X", f"{low}, Y")
    return Section(
        "similarity",
        "Similarity",
        words.similarity(
            result.params, span_in_use(result, "midpoint"), span_in_use(result, "spread")
        ),
        (
            Chart(
                "recordings",
                recordings_plot(recordings, names_of(result), theme=THEME),
                "Mean similarity of X and Y in every recording",
            ),
            Chart(
                "loss-strip",
                loss_strip_plot(result, loss_strip(result), theme=THEME),
                "What the worse system loses over the time of every recording",
            ),
            table("Similarity by recording", head, rows, right=range(1, 7), note=note),
            _windows(result),
            _intervals(result),
        ),
    )


def _most_different(recordings: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """The recordings to list, in their order, and a note on those left out."""
    if len(recordings) <= MAX_ROWS:
        return recordings, ""
    apart = (recordings["mean_similarity_x"] - recordings["mean_similarity_y"]).abs()
    largest = apart.sort_values(ascending=False, kind="stable").index[:MAX_ROWS].sort_values()
    note = (
        f"The {MAX_ROWS} recordings in which the systems differ most are shown, "
        f"{len(recordings) - MAX_ROWS:,} are left out."
    )
    return recordings.loc[largest], note


def _windows(result: Result) -> Table:
    """Lost similarity and the worst window of every recording."""
    columns = ("lost_s_per_min", "window_similarity", "window_lost_s", "window_time_s")
    forms = (".2f", ".4f", ".3f", ".2f")
    rows = [
        (
            row["recording"],
            *(
                number(row[f"{name}_{letter}"], form)
                for letter in "xy"
                for name, form in zip(columns, forms, strict=True)
            ),
        )
        for row in windows_table(result).to_dict("records")
    ]
    labels = ("lost (s per minute)", "worst window", "lost in it (s)", "its middle (s)")
    head = ("Recording", *(f"{letter}: {label}" for letter in "XY" for label in labels))
    note = (
        "Lost: the sum of (1 - similarity) * time step. The worst window is the "
        f"{result.params.window:g} s with the lowest mean similarity, which is given."
    )
    title = "Lost similarity and the worst window, most lost first"
    return table(title, head, rows, right=range(1, len(head)), note=note)


def _intervals(result: Result) -> Table:
    worst = pd.concat([worst_intervals(result, letter, n=N_WORST) for letter in "xy"])
    rows = [
        (
            row["system"].upper(),
            row["recording"],
            f"{row['first_frame']} to {row['last_frame']}",
            f"{row['start_s']:.2f}",
            f"{row['duration_s']:.2f}",
            f"{row['depth_s']:.3f}",
            f"{row['min_similarity']:.3f}",
        )
        for row in worst.to_dict("records")
    ]
    head = ("System", "Recording", "Frames", "Start (s)", "Duration (s)", "Depth (s)", "Lowest")
    return table("The worst low intervals", head, rows, right=range(3, 7))


def saliency_section(result: Result) -> Section:
    """How saliency is computed, and the largest events."""
    worst = pd.concat([worst_events(result, letter, n=N_WORST) for letter in "xy"])
    rows = [
        (
            row["system"].upper(),
            row["recording"],
            row["track"],
            f"{row['start_s']:.2f}",
            f"{row['duration_s']:.2f}",
            f"{row['tau']:.3f}",
            f"{row['recency']:.3f}",
            f"{row['saliency_s']:.3f}",
        )
        for row in worst.to_dict("records")
    ]
    head = (
        "System",
        "Recording",
        "Pedestrian",
        "Start (s)",
        "Duration (s)",
        "Passed at its end",
        "Recency",
        "Saliency (s)",
    )
    return Section(
        "saliency",
        "Saliency",
        words.saliency(result.params),
        (
            Sentences(describe_saliency(result)),
            table("The most salient events", head, rows, right=range(3, 8)),
        ),
    )


def false_alerts_section(result: Result) -> Section:
    """False alarms and episodes of both systems."""
    rows = score_cells(score_rows(result, MeasureTable.FALSE_ALERTS), indent=PART)
    head = ("System", "Recording", "Frames", "Start (s)", "Duration (s)", "Boxes")
    return Section(
        "false-alerts",
        "False alerts",
        words.FALSE_ALERTS,
        (
            table("False alarms and episodes", MEASURES_HEAD, rows, right=(1, 2, 3)),
            table("The longest episodes", head, _episodes(result), right=range(3, 6)),
        ),
    )


def _episodes(result: Result) -> list[tuple[Any, ...]]:
    frames, name = result.dataset.frames, result.dataset.recordings["name"]
    rows = []
    for letter, system in result.sides:
        longest = system.episodes.sort_values("duration_s", ascending=False, kind="stable")
        for episode in longest.head(N_WORST).to_dict("records"):
            first, last = (
                int(frames["frame"].iloc[episode[key]]) for key in ("first_row", "last_row")
            )
            start = f"{frames['time_s'].iloc[episode['first_row']]:.2f}"
            rows.append(
                (
                    letter.upper(),
                    name.iloc[episode["recording"]],
                    f"{first} to {last}",
                    start,
                    f"{episode['duration_s']:.2f}",
                    episode["n_boxes"],
                )
            )
    return rows


def only_one_section(result: Result) -> Section:
    """Encounters that only one system detects, row by row, the worst first."""
    encounters = encounters_table(result)
    moments = encounter_moments(result)
    time_s = result.dataset.frames["time_s"].to_numpy()
    category = encounters["category"].to_numpy()
    exclusive = np.flatnonzero(np.isin(category, [Category.X_ONLY.value, Category.Y_ONLY.value]))
    is_x_only = category[exclusive] == Category.X_ONLY.value
    x_s, y_s = (encounters[f"severity_s_{letter}"].to_numpy()[exclusive] for letter in "xy")
    severity_s = np.where(is_x_only, y_s, x_s)
    order = np.argsort(-severity_s, kind="stable")
    rows: list[tuple[Any, ...]] = []
    for index in order[:MAX_ROWS].tolist():
        encounter = encounters.iloc[exclusive[index]]
        letter, other = ("x", "y") if is_x_only[index] else ("y", "x")
        row = int(moments[f"missed_row_{other}"].iloc[exclusive[index]])
        rows.append(
            (
                f"only {letter.upper()}",
                encounter["recording"],
                encounter["track"],
                f"{time_s[row]:.2f}" if row >= 0 else UNDEFINED,
                f"{severity_s[index]:.2f}",
                f"{encounter[f'peak_cost_{other}']:.2f}",
                encounter["n_relevant"],
                f"{encounter['peak_height']:.0f}",
                number(encounter["coverage_x"], ".0%"),
                number(encounter["coverage_y"], ".0%"),
                str(encounter[f"miss_class_{other}"]).replace("_", " "),
            )
        )
    head = (
        "Detected by",
        "Recording",
        "Pedestrian",
        "Missed from (s)",
        "Severity (s)",
        "Peak cost",
        "Relevant frames",
        "Height (px)",
        "Coverage X",
        "Coverage Y",
        "The other's failure",
    )
    title = f"{count_text(len(exclusive), 'encounter')} that only one system detects"
    left_out = len(exclusive) - len(rows)
    note = f"The heaviest {len(rows):,} are shown, {left_out:,} are left out." if left_out else ""
    listing = table(title, head, rows, right=range(3, 10), note=note)
    return Section("only-one", "Encounters that only one detects", words.ONLY_ONE, (listing,))
