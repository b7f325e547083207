"""Sections about encounters: who detects whom, what failures weigh, whom only one detects."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.figures.encounters import miss_classes_plot
from nvcore.figures.venn import WORDS, venn_figure
from nvcore.figures.weightings import weightings_plot
from nvcore.measures.entry import MeasureTable
from nvcore.notes import say as said
from nvcore.report.html import words
from nvcore.report.html.blocks import MAX_ROWS, Chart, Fold, Section, Sentences, Table, table
from nvcore.report.html.result_sections import names_of
from nvcore.report.words import (
    FUSION_RULE,
    fusion_gains,
    lead,
    misses,
)
from nvcore.schema import CATEGORY_TEXT, MISS_CLASS_TEXT, Category
from nvcore.tables.encounters.miss_classes import fusion_table
from nvcore.tables.encounters.severity import weighed_encounters
from nvcore.tables.encounters.weightings import compare_weightings
from nvcore.tables.moments import encounter_moments
from nvcore.tables.result import (
    encounters_table,
)
from nvcore.tables.scorecard import score_rows
from nvcore.wording import UNDEFINED, count_text, number

N_HEAVIEST = 10
"""How many of the encounters that weigh most are listed."""


def encounters_section(result: Result) -> Section:
    """Which system detects which pedestrians, and how the others are missed."""
    counts, say = result.venn.counts(), result.objects.say
    in_words = ", ".join(f"{WORDS[kind]} {counts[kind]}" for kind in Category)
    classes = [
        (row.label, number(row.x, "d"), number(row.y, "d"), say(MISS_CLASS_TEXT[kind]))
        for row, kind in zip(
            score_rows(result, MeasureTable.MISS_CLASSES), MISS_CLASS_TEXT, strict=True
        )
    ]
    names = names_of(result)
    classes_chart = Chart(
        "classes",
        miss_classes_plot(
            encounters_table(result),
            names,
            theme=result.scheme("light"),
            objects=result.objects,
        ),
        "How many encounters each system fails in which way",
    )
    missed = table("How they were missed", ("Class", "X", "Y", "Meaning"), classes, right=(1, 2))
    facts = (*misses(result), lead(result))
    sentences = tuple(said(fact, result.objects) for fact in facts)
    fusion = fusion_table(result)
    encounters = weighed_encounters(result)
    return Section(
        "encounters",
        "Who detects {what}",
        words.who(result.params),
        (
            table(
                "Encounters by who detects them",
                ("Category", "Encounters", "Severity X (s)", "Severity Y (s)", "Meaning"),
                [
                    (
                        WORDS[kind],
                        counts[kind],
                        *_severities(result, kind),
                        say(CATEGORY_TEXT[kind]),
                    )
                    for kind in Category
                ],
                right=(1, 2, 3),
            ),
            Chart(
                "venn",
                venn_figure(
                    result.venn,
                    names,
                    theme=result.scheme("light"),
                    encounters=encounters,
                    objects=result.objects,
                ),
                f"Encounters: {in_words}",
            ),
            _heaviest(result, encounters),
            *_weightings(result, encounters),
            Sentences(sentences),
            Fold(missed.title, (classes_chart, missed)),
            Sentences(tuple(said(gain, result.objects) for gain in fusion_gains(fusion))),
            Fold(
                "X and Y as one system; boxes by who matches them",
                (_fusion(fusion), _boxes(result)),
            ),
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
        *("Recording", result.objects.say("{One}"), "Detected by", "Costs most at (s)"),
        *("Severity X (s)", "Severity Y (s)", "Peak cost X", "Peak cost Y"),
        *("Failure of X", "Failure of Y"),
    )
    title = "The encounters whose failures weigh most"
    note = result.objects.say(
        "Sorted by the larger severity of the two; the time is that of its largest cost, of the "
        "frames in which the other system detects the {one}, if there are any."
    )
    return table(title, head, rows, right=range(3, 8), note=note)


def _weightings(result: Result, encounters: pd.DataFrame) -> tuple[Fold, ...]:
    """The heaviest encounter as height, horizon and distance weigh it; empty: nobody is missed."""
    heaviest = encounters[encounters["severity_s"] > 0].head(1)
    if heaviest.empty:
        return ()
    encounter = int(heaviest.index[0])
    weightings = compare_weightings(result, encounter)
    theme = result.scheme("light")
    figure = weightings_plot(result, encounter, weightings, theme=theme)
    rows = [
        (
            f"{kind} (in use)" if kind == weightings.in_use else kind,
            number(facts["n_relevant"], ".0f"),
            *(number(facts[f"missed_{letter}"], ".0f") for letter in "xy"),
            *(number(facts[f"severity_s_{letter}"], ".2f") for letter in "xy"),
        )
        for kind, facts in weightings.table.to_dict("index").items()
    ]
    head = (
        *("Nearness by", "Frames that count", "X misses", "Y misses"),
        *("Severity X (s)", "Severity Y (s)"),
    )
    noun = result.objects.singular
    note = f"{UNDEFINED}: the horizon, or this {noun}'s distance, is not known."
    title = "The heaviest encounter, weighted by height, horizon and distance"
    chart = Chart("weightings", figure, "The heaviest encounter's weight over time, by each")
    return (Fold(title, (chart, table(title, head, rows, right=range(1, 6), note=note))),)


def _boxes(result: Result) -> Table:
    """How many boxes of the truth each system matches."""
    boxes = result.boxes
    counts = (boxes.both, boxes.x_only, boxes.y_only, boxes.neither)
    head = ("Matched by both", "Only by X", "Only by Y", "By neither")
    n_absorbed = " and ".join(
        f"{system.matches.n_absorbed:,} detections of {letter.upper()}"
        for letter, system in result.sides
    )
    note = result.objects.say(
        "Near and distant {many}, frame by frame. {n_absorbed} lie on {people} or regions that the "
        "ground truth ignores and do not count.",
        n_absorbed=n_absorbed,
    )
    rows = [[f"{n:,}" for n in counts]]
    title = f"Boxes of {result.objects.plural} by who matches them"
    return table(title, head, rows, right=range(4), note=note)


def _fusion(fusion: pd.DataFrame) -> Table:
    """Both systems as one system, beside each of them."""
    names = {"x": "X alone", "y": "Y alone", "x_or_y": "X or Y", "x_and_y": "X and Y"}
    rows = [
        (
            names[row["system"]],
            f"{row['encounters_detected']:,}",
            f"{row['false_alert_episodes']:,}",
            number(row["mean_similarity"], ".4f"),
        )
        for row in fusion.to_dict("records")
    ]
    head = ("System", "Encounters detected", "False-alert episodes", "Mean similarity")
    note = (
        "What if both were one system: \u201cX or Y\u201d shows what either shows (a pair of boxes "
        f"that overlap once), \u201cX and Y\u201d only what both show. {FUSION_RULE}"
    )
    return table("X and Y as one system", head, rows, right=range(1, 4), note=note)


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
        result.objects.say("{One}"),
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
    fold = Fold(title, (listing,), "in encounters.csv")
    return Section("only-one", "Encounters that only one detects", words.ONLY_ONE, (fold,))
