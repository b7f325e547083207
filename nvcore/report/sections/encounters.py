"""Sections on encounters: who detects them, severity of the failures, encounters of one system."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd

import nvcore
from nvcore.common.wording import UNDEFINED, capitalised, count_text, number
from nvcore.common.wording.footnotes import Footnotes
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import MeasureTable
from nvcore.dataset.schema import CATEGORY_TEXT, CATEGORY_WORDS, MISS_CLASS_TEXT, Category
from nvcore.evidence.subgroups import class_groups
from nvcore.evidence.subgroups.table import judge_groups
from nvcore.metrics.encounter_classes import (
    CHILD,
    CROSSING,
    GROUP,
    IN_ROAD,
    EncounterClasses,
    classes_of,
    shown_class,
)
from nvcore.notes import Note
from nvcore.report.section import (
    MAX_ROWS,
    Block,
    Chart,
    Columns,
    Fold,
    Paragraphs,
    Row,
    Section,
    Table,
    about,
    listing,
    of_both,
    spaced,
    table,
)
from nvcore.report.words import difference_cell, fusion_gains, interval_cell, lead, misses
from nvcore.settings.codes import NO_CODE
from nvcore.tables.encounters.miss_classes import class_counts, fusion_table
from nvcore.tables.encounters.severity import weighed_encounters
from nvcore.tables.encounters.weightings import compare_weightings
from nvcore.tables.moments import encounter_moments
from nvcore.tables.result import encounters_table
from nvcore.tables.scorecard import score_rows

SHARE: Final = "encounters_detected_by_unit"
NO_INTERVAL: Final = (UNDEFINED, "")
ORIGINS: Final = {
    CROSSING: "Was on both sides of the picture's middle.",
    IN_ROAD: "At most 3.5 m beside the camera's axis in half of the frames, by height.",
    GROUP: "Another {one} alongside in half of the frames.",
    CHILD: "Small for {a_one} at that distance, which is known or follows from the horizon.",
    NO_CODE: "Overlaps no stretch with a code.",
}
"""Rules for classes that come from boxes alone, and for encounters without a code."""
N_HEAVIEST: Final = 10
"""Number of listed encounters with the largest severity."""


def encounters_section(result: Result) -> Section:
    """Return the section on who detects which pedestrians, how others are missed, and fusion."""
    encounters = weighed_encounters(result)
    counts, names = result.venn.counts(), result.names
    look: dict[str, Any] = {"theme": result.scheme("light"), "objects": result.objects}
    venn = Chart(
        "venn",
        lambda: nvcore.figures.venn_figure(result.venn, names, encounters=encounters, **look),
        f"Encounters: {', '.join(f'{CATEGORY_WORDS[kind]} {counts[kind]}' for kind in Category)}",
    )
    classes = Chart(
        "classes",
        lambda: nvcore.figures.miss_classes_plot(encounters_table(result), names, **look),
        "How many encounters each system fails in which way",
    )
    missed, classes_table = _miss_classes(result), by_class(result)
    fusion = fusion_table(result)
    blocks: tuple[Block, ...] = (
        _categories(result),
        venn,
        _heaviest(result, encounters),
        *_weightings(result, encounters),
        *([Fold("By class of {one}", (classes_table,))] if classes_table else []),
        Paragraphs((*misses(result), lead(result))),
        Fold(missed.title, (classes, missed)),
        Paragraphs(fusion_gains(fusion)),
        Fold("X and Y as one system; boxes by who matches them", (_fusion(fusion), _boxes(result))),
    )
    introduction = about("sections.encounters", result)
    return Section("encounters", "Who detects {what}", introduction, blocks)


def _categories(result: Result) -> Table:
    """Return a table of the number and severity of encounters by Venn category."""
    counts = result.venn.counts()
    severities = [result.severity_of(system) for _, system in result.sides]
    undefined = {Category.DISTANT: None}  # distant encounters have no weight
    rows = [
        (
            CATEGORY_WORDS[kind],
            counts[kind],
            *(number({**of, **undefined}[kind], ".2f") for of in severities),
            result.objects.say(CATEGORY_TEXT[kind]),
        )
        for kind in Category
    ]
    head = ("Category", "Encounters", "Severity X (s)", "Severity Y (s)", "Meaning")
    return table("Encounters by who detects them", head, rows, right=(1, 2, 3))


def _miss_classes(result: Result) -> Table:
    kinds = zip(score_rows(result, MeasureTable.MISS_CLASSES), MISS_CLASS_TEXT, strict=True)
    rows = [
        (
            row.label,
            number(row.x, "d"),
            number(row.y, "d"),
            result.objects.say(MISS_CLASS_TEXT[kind]),
        )
        for row, kind in kinds
    ]
    return table("How they were missed", ("Class", "X", "Y", "Meaning"), rows, right=(1, 2))


def _heaviest(result: Result, encounters: pd.DataFrame) -> Table:
    """Return a table of the encounters whose failures have the largest severity."""
    time_s = result.dataset.frames["time_s"].to_numpy()
    columns: Columns = {
        "Recording": "recording",
        "{One}": "track",
        "Detected by": lambda row: CATEGORY_WORDS[Category(row["category"])],
        "Costs most at (s)": (lambda row: time_s[row["shown_row"]], ".2f"),
        **of_both("Severity {} (s)", "severity_s_{}", ".2f"),
        **of_both("Peak cost {}", "peak_cost_{}", ".2f"),
        **of_both("Failure of {}", "miss_class_{}"),
    }
    heaviest = encounters[encounters["severity_s"] > 0].head(N_HEAVIEST)
    title = "The encounters whose failures weigh most"
    return listing(title, heaviest, columns, notes=[Note("sections.heaviest")])


def _weightings(result: Result, encounters: pd.DataFrame) -> tuple[Fold, ...]:
    """Return how height, horizon and distance weight the encounter with the severest failure.

    Empty if no encounter is missed.
    """
    heaviest = encounters[encounters["severity_s"] > 0].head(1)
    if heaviest.empty:
        return ()
    encounter = int(heaviest.index[0])
    weightings = compare_weightings(result, encounter)

    def kind(row: Row) -> str:
        return f"{row['kind']} (in use)" if row["kind"] == weightings.in_use else str(row["kind"])

    columns: Columns = {
        "Nearness by": kind,
        "Frames that count": ("n_relevant", ".0f"),
        **of_both("{} misses", "missed_{}", ".0f"),
        **of_both("Severity {} (s)", "severity_s_{}", ".2f"),
    }
    title = "The heaviest encounter, weighted by height, horizon and distance"
    chart = Chart(
        "weightings",
        lambda: nvcore.figures.weightings_plot(
            result, encounter, weightings, theme=result.scheme("light")
        ),
        "The heaviest encounter's weight over time, by each",
    )
    rows = weightings.table.rename_axis("kind").reset_index()
    unknown = [Note("sections.weightings")] if rows.isna().to_numpy().any() else []
    return (Fold(title, (chart, listing(title, rows, columns, notes=unknown))),)


def by_class(result: Result) -> Table | None:
    """Return a table of detected encounters by class, or None if no encounter has a class."""
    counts = class_counts(result).reset_index()
    if counts.empty:
        return None
    groups = class_groups(result, result.is_near)
    judged = {of: by[SHARE] for of, by in judge_groups(result, groups, (SHARE,)).items()}
    footnotes = Footnotes()
    intervals = {name: interval_cell(row, footnotes) for name, row in judged.items()}

    def apart(row: Row) -> str:
        of = judged.get(row["class"])
        return UNDEFINED if of is None else difference_cell(of)

    columns: Columns = {
        "Class": lambda row: shown_class(row["class"]),
        **{capitalised(CATEGORY_WORDS[kind]): (kind.value, "d") for kind in Category},
        "Detected X − Y": (apart, ""),
        "95 % interval": (lambda row: intervals.get(row["class"], NO_INTERVAL)[0], ""),
        **of_both("Severity {} (s)", "severity_s_{}", ".2f"),
        "Shared misses": ("jaccard", ".2f"),
        "Phi": ("phi", ".2f"),
    }
    classes = classes_of(result.dataset)
    return replace(
        listing(
            "By class of {one}",
            counts,
            columns,
            notes=[*footnotes.lines(), Note("sections.by_class")],
        ),
        marks=tuple(intervals.get(name, NO_INTERVAL)[1] for name in counts["class"]),
        hints=tuple(_origin_of(classes, name) for name in counts["class"]),
    )


def _origin_of(classes: EncounterClasses, name: str) -> str:
    """Return where a class comes from."""
    ways = ["Named by the truth."] if name in classes.named else []
    if name in classes.coded and name != NO_CODE:
        ways.append("Overlaps a stretch with this code.")
    return " ".join(ways) or ORIGINS.get(name, "")


def _boxes(result: Result) -> Table:
    """Return a table of the number of truth boxes that both, one or neither system matches."""
    boxes = result.boxes
    head = ("Matched by both", "Only by X", "Only by Y", "By neither")
    rows = [[f"{n:,}" for n in (boxes.both, boxes.x_only, boxes.y_only, boxes.neither)]]
    x, y = (system.matches.n_absorbed for _, system in result.sides)
    note = Note("sections.absorbed", x=x, y=y)
    return table("Boxes of {many} by who matches them", head, rows, right=range(4), notes=[note])


def _fusion(fusion: pd.DataFrame) -> Table:
    """Return a table of the results of each system alone and of both fused to one."""
    names = {"x": "X alone", "y": "Y alone", "x_or_y": "X or Y", "x_and_y": "X and Y"}
    columns: Columns = {
        "System": lambda row: names[row["system"]],
        "Encounters detected": ("encounters_detected", "d"),
        "False-alert episodes": ("false_alert_episodes", "d"),
        "Mean similarity": ("mean_similarity", ".4f"),
    }
    notes = [Note("encounters.fusion"), Note("encounters.fusion_rule")]
    return listing("X and Y as one system", fusion, columns, notes=notes)


def only_one_section(result: Result) -> Section:
    """Return the section on encounters that only one system detects, severest failure first."""
    rows = _detected_by_one(result)
    columns: Columns = {
        "Detected by": lambda row: CATEGORY_WORDS[Category(row["category"])],
        "Recording": "recording",
        "{One}": "track",
        "Missed from (s)": ("missed_from_s", ".2f"),
        "Severity (s)": ("severity_s", ".2f"),
        "Peak cost": ("peak_cost", ".2f"),
        "Relevant frames": ("n_relevant", "d"),
        "Height (px)": ("peak_height", ".0f"),
        **of_both("Coverage {}", "coverage_{}", ".0%"),
        "The other's failure": spaced("miss_class"),
    }
    rest = len(rows) - MAX_ROWS
    notes = [Note("sections.left_out", which="heaviest", n=MAX_ROWS, rest=rest)] if rest > 0 else []
    title = f"{count_text(len(rows), 'encounter')} that only one system detects"
    fold = Fold(
        title, (listing(title, rows[:MAX_ROWS], columns, notes=notes),), "in encounters.csv"
    )
    introduction = about("sections.only_one", result)
    return Section("only-one", "Encounters that only one detects", introduction, (fold,))


def _detected_by_one(result: Result) -> pd.DataFrame:
    """Return encounters that only one system detects, with the failure of the other."""
    table = encounters_table(result).reset_index(drop=True)
    is_x_only, is_y_only = (table["category"] == f"{letter}_only" for letter in "xy")
    of_other = {
        name: np.where(is_x_only, table[f"{name}_y"], table[f"{name}_x"])
        for name in ("severity_s", "peak_cost", "miss_class")
    }
    moments = encounter_moments(result)
    missed = np.where(is_x_only, moments["missed_row_y"], moments["missed_row_x"]).astype(int)
    time_s = result.dataset.frames["time_s"].to_numpy()
    from_s = np.where(missed >= 0, time_s[missed], np.nan) if len(time_s) else np.nan
    table = table.assign(**of_other, missed_from_s=from_s)[is_x_only | is_y_only]
    return table.sort_values("severity_s", ascending=False, kind="stable")
