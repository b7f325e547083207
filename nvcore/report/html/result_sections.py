"""Sections with the results: scorecard, encounters, similarity, saliency, false alerts."""

from __future__ import annotations

from typing import Any

import pandas as pd

from nvcore.comparison import Result
from nvcore.figures.over_time.strip import loss_strip_plot
from nvcore.figures.paired import recordings_plot
from nvcore.figures.saliency import plane_plot
from nvcore.measures.entry import MeasureTable
from nvcore.notes import say
from nvcore.report.html import words
from nvcore.report.html.blocks import MAX_ROWS, Chart, Fold, Section, Sentences, Table, table
from nvcore.report.html.input_sections import span_in_use
from nvcore.report.terminal import SHORT_ROWS
from nvcore.report.words import (
    saliencies,
    score_cells,
    scorecard_cells,
)
from nvcore.subjects import contributed
from nvcore.tables.influence import lead_text, other_leads_text
from nvcore.tables.loss_strip import loss_strip
from nvcore.tables.result import (
    recordings_table,
    worst_events,
    worst_intervals,
)
from nvcore.tables.scorecard import score_rows
from nvcore.tables.windows import windows_table, worst_windows_text
from nvcore.wording import difference, number

MEASURES_HEAD = ("Measure", "X", "Y", "X − Y", "Better")
PART = "– "
"""Before the label of a measure that is a part of the one above."""
N_WORST = 3
"""How many intervals, events and episodes of each system are listed."""


def names_of(result: Result) -> tuple[str, str]:
    """Names of X and Y."""
    return result.x.name, result.y.name


def scorecard_section(result: Result) -> Section:
    """All measures side by side."""
    rows = scorecard_cells(result, indent=PART, mark=" *" if result.is_short else "")
    little = f"{SHORT_ROWS}." if result.is_short else ""
    measures = table(
        "Measures of X and Y", MEASURES_HEAD, rows, right=(1, 2, 3), note=little, printed=len(rows)
    )
    notes = tuple(
        say(fact, result.objects)
        for remarks in contributed("remarks")
        for fact in remarks.note(result)
    )
    remarked = [Sentences(notes)] if notes else []
    return Section("scorecard", "Scorecard", words.scorecard(result.params), (*remarked, measures))


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
    head = ("Recording", "Frames", "Mean X", "Mean Y", "X − Y", f"{low}, X", f"{low}, Y")
    by_recording = table("Similarity by recording", head, rows, right=range(1, 7), note=note)
    leads = tuple(filter(None, (lead_text(result), other_leads_text(result))))
    return Section(
        "similarity",
        "Similarity",
        words.similarity(
            result.params, span_in_use(result, "midpoint"), span_in_use(result, "spread")
        ),
        (
            Chart(
                "recordings",
                recordings_plot(recordings, names_of(result), theme=result.scheme("light")),
                "Mean similarity of X and Y in every recording",
            ),
            Chart(
                "loss-strip",
                loss_strip_plot(result, loss_strip(result), theme=result.scheme("light")),
                "What the worse system loses over the time of every recording",
            ),
            Fold(by_recording.title, (by_recording,), "in recordings.csv"),
            Sentences(leads),
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


def _windows(result: Result) -> Fold:
    """Lost similarity and the worst window of every recording."""
    columns = ("lost_s_per_min", "window_similarity", "window_lost_s", "window_time_s")
    forms = (".2f", ".4f", ".3f", ".2f")
    windows = windows_table(result)
    rows = [
        (
            row["recording"],
            *(
                number(row[f"{name}_{letter}"], form)
                for letter in "xy"
                for name, form in zip(columns, forms, strict=True)
            ),
        )
        for row in windows.to_dict("records")
    ]
    labels = ("lost (s per minute)", "worst window", "lost in it (s)", "its middle (s)")
    head = ("Recording", *(f"{letter}: {label}" for letter in "XY" for label in labels))
    note = (
        "Lost: the sum of (1 − similarity) × time step. The worst window is the "
        f"{result.params.window:g} s with the lowest mean similarity, which is given."
    )
    if len(windows):
        note += f" {worst_windows_text(windows)}"
    title = "Lost similarity and the worst window, most lost first"
    return Fold(title, (table(title, head, rows, right=range(1, len(head)), note=note),))


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
        result.objects.say("{One}"),
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
            Sentences(tuple(say(each, result.objects) for each in saliencies(result))),
            Chart(
                "plane",
                plane_plot(result, theme=result.scheme("light")),
                "Mean similarity and saliency of X and Y in every recording",
            ),
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
