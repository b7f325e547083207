"""Sections on measures: scorecard, similarity, saliency, false alerts, classes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np
import pandas as pd

import nvcore
from nvcore.common.wording import ARROWS, UNDEFINED, difference, interval_text, number
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import MeasureTable
from nvcore.comparison.measures.table import as_shown, evidence_form
from nvcore.evidence.bootstrap import INTERVAL_RULE
from nvcore.metrics.kernels import ABSORB_SHARE
from nvcore.metrics.linking import LINK_GAP, LINK_IOU
from nvcore.notes import Note
from nvcore.report.remarks import remarks_on
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
    Text,
    about,
    listing,
    of_both,
    table,
)
from nvcore.report.sections.inputs import span_in_use
from nvcore.report.words import (
    classes_read,
    effect_text,
    saliencies,
    saliency_caveat,
    score_cells,
    scorecard_cells,
)
from nvcore.settings.params import MIDPOINT_SHARE, SPREAD_SHARE
from nvcore.tables.classes import classes_table, names_classes
from nvcore.tables.influence import leads
from nvcore.tables.loss_strip import loss_strip
from nvcore.tables.result import recordings_table, worst_events, worst_intervals
from nvcore.tables.scorecard import score_rows
from nvcore.tables.windows import windows_table, worst_windows_note

if TYPE_CHECKING:
    import plotly.graph_objects as go

MEASURES_HEAD: Final = ("Measure", "X", "Y", "X − Y", "Better")
PART: Final = "– "
"""Prefix of the label of a measure that is a part of the one above."""
N_WORST: Final = 3
"""Number of intervals, events and episodes of each system that are listed."""


def scorecard_section(result: Result) -> Section:
    """Return the section with a table of all measures of X and Y."""
    rows = scorecard_cells(result, indent=PART, mark=" *" if result.is_short else "")
    remarks = remarks_on(result)
    measures = table(
        "Measures of X and Y",
        MEASURES_HEAD,
        rows,
        right=(1, 2, 3),
        notes=[Note("sections.means_little")] if result.is_short else [],
        printed=len(rows),
    )
    blocks: tuple[Block, ...] = (measures,)
    blocks = (Paragraphs(tuple(remarks)), *blocks) if remarks else blocks
    return Section("scorecard", "Scorecard", about("sections.scorecard", result), blocks)


def similarity_section(result: Result) -> Section:
    """Return the section on similarity: by recording, lost over time, and the worst intervals."""
    recordings = recordings_table(result)
    theme = result.scheme("light")
    by_recording = _by_recording(result, recordings)
    introduction = about(
        "sections.similarity",
        result,
        midpoint=span_in_use(result, "midpoint"),
        spread=span_in_use(result, "spread"),
        midpoint_share=MIDPOINT_SHARE,
        spread_share=SPREAD_SHARE,
    )
    blocks: tuple[Block, ...] = (
        Chart(
            "recordings",
            lambda: nvcore.figures.recordings_plot(recordings, result.names, theme=theme),
            "Mean similarity of X and Y in every recording",
        ),
        Chart(
            "loss-strip",
            lambda: nvcore.figures.loss_strip_plot(result, loss_strip(result), theme=theme),
            "What the worse system loses over the time of every recording",
        ),
        Fold(by_recording.title, (by_recording,), "in recordings.csv"),
        Paragraphs(leads(result)),
        _windows(result),
        _intervals(result),
    )
    return Section("similarity", "Similarity", introduction, blocks)


def _by_recording(result: Result, recordings: pd.DataFrame) -> Table:
    """Return a table of the recordings. Of many, only those in which X and Y differ most."""
    notes = []
    if len(recordings) > MAX_ROWS:
        apart = (recordings["mean_similarity_x"] - recordings["mean_similarity_y"]).abs()
        order = apart.sort_values(ascending=False, kind="stable").index
        note = Note("sections.most_different", n=MAX_ROWS, rest=len(recordings) - MAX_ROWS)
        recordings, notes = recordings.loc[order[:MAX_ROWS].sort_values()], [note]

    def apart_text(row: Row) -> str:
        return difference(row["mean_similarity_x"], row["mean_similarity_y"], ".4f")

    columns: Columns = {
        "Recording": "recording",
        "Frames": ("n_frames", "d"),
        **of_both("Mean {}", "mean_similarity_{}", ".4f"),
        "X − Y": (apart_text, ""),
        **of_both(f"below {result.params.low:g}, {{}}", "share_low_{}", ".1%"),
    }
    return listing("Similarity by recording", recordings, columns, notes=notes)


def _windows(result: Result) -> Fold:
    """Return a table of each recording's lost similarity and worst window."""
    windows = windows_table(result)
    columns: Columns = {
        f"{letter.upper()}: {label}": (f"{name}_{letter}", form)
        for letter in "xy"
        for label, name, form in (
            ("lost (s per minute)", "lost_s_per_min", ".2f"),
            ("worst window", "window_similarity", ".4f"),
            ("lost in it (s)", "window_lost_s", ".3f"),
            ("its middle (s)", "window_time_s", ".2f"),
        )
    }
    notes: list[Text] = [Note("sections.worst_windows", seconds=result.params.window)]
    notes += [worst_windows_note(windows)] if len(windows) else []
    title = "Lost similarity and the worst window, most lost first"
    return Fold(
        title, (listing(title, windows, {"Recording": "recording", **columns}, notes=notes),)
    )


def _intervals(result: Result) -> Table:
    worst = pd.concat([worst_intervals(result, letter, n=N_WORST) for letter in "xy"])
    columns: Columns = {
        **_PLACE,
        "Frames": _frames,
        **_SPAN,
        "Depth (s)": ("depth_s", ".3f"),
        "Lowest": ("min_similarity", ".3f"),
    }
    return listing("The worst low intervals", worst, columns)


def _system(row: Row) -> str:
    return str(row["system"]).upper()


def _frames(row: Row) -> str:
    return f"{row['first_frame']} to {row['last_frame']}"


_PLACE: Final[Columns] = {"System": _system, "Recording": "recording"}
_SPAN: Final[Columns] = {"Start (s)": ("start_s", ".2f"), "Duration (s)": ("duration_s", ".2f")}


def saliency_section(result: Result) -> Section:
    """Return the section on how saliency is computed, with the largest events."""
    worst = pd.concat([worst_events(result, letter, n=N_WORST) for letter in "xy"])
    columns: Columns = {
        **_PLACE,
        "{One}": "track",
        **_SPAN,
        "Passed at its end": ("tau", ".3f"),
        "Recency": ("recency", ".3f"),
        "Saliency (s)": ("saliency_s", ".3f"),
    }
    blocks: tuple[Block, ...] = (
        Paragraphs((*saliencies(result), *saliency_caveat(result.params))),
        Chart(
            "plane",
            lambda: nvcore.figures.plane_plot(result, theme=result.scheme("light")),
            "Mean similarity and saliency of X and Y in every recording",
        ),
        listing("The most salient events", worst, columns),
    )
    return Section("saliency", "Saliency", about("sections.saliency", result), blocks)


def false_alerts_section(result: Result) -> Section:
    """Return the section on both systems' false alarms and the episodes that they form."""
    introduction = about(
        "sections.false_alerts", result, link_iou=LINK_IOU, link_gap=LINK_GAP, absorbed=ABSORB_SHARE
    )
    rows = score_cells(score_rows(result, MeasureTable.FALSE_ALERTS), indent=PART)
    columns: Columns = {**_PLACE, "Frames": _frames, **_SPAN, "Boxes": ("n_boxes", "d")}
    blocks: tuple[Block, ...] = (
        table("False alarms and episodes", MEASURES_HEAD, rows, right=(1, 2, 3)),
        listing("The longest episodes", _longest_episodes(result), columns),
    )
    return Section("false-alerts", "False alerts", introduction, blocks)


def _longest_episodes(result: Result) -> pd.DataFrame:
    frames, name = result.dataset.frames, result.dataset.recordings["name"]
    longest = pd.concat(
        system.episodes.sort_values("duration_s", ascending=False, kind="stable")
        .head(N_WORST)
        .assign(system=letter)
        for letter, system in result.sides
    )
    return longest.assign(
        recording=name.iloc[longest["recording"]].to_numpy(),
        first_frame=frames["frame"].iloc[longest["first_row"]].to_numpy(),
        last_frame=frames["frame"].iloc[longest["last_row"]].to_numpy(),
        start_s=frames["time_s"].iloc[longest["first_row"]].to_numpy(),
    )


def classes_section(result: Result) -> Section:
    """Return the section with confusion matrices of true classes and those that X and Y report.

    For results with `has_classes` only.
    """
    counted = classes_table(result)
    blocks: list[Block] = []
    for letter, system in result.sides:
        blocks.append(Paragraphs((classes_read(result, counted, letter),)))
        rows = counted[counted["system"] == letter]
        if rows.empty or not names_classes(result, system):
            continue
        cells = rows[["truth_class", "read_class", "n"]].fillna({"read_class": "no class"})
        columns: Columns = {
            "Class in the truth": "truth_class",
            "Class read": "read_class",
            "Boxes": ("n", "d"),
        }
        blocks += [
            _classes(result, counted, letter),
            listing(f"Classes read by {letter.upper()}", cells, columns),
        ]
    return Section("classes", "Classes", about("sections.classes", result), tuple(blocks))


def _classes(result: Result, counted: pd.DataFrame, letter: str) -> Chart:
    name, theme = dict(result.sides)[letter].name, result.scheme("light")
    return Chart(
        f"classes-{letter}",
        lambda: nvcore.figures.classes_plot(counted, letter, name, theme=theme),
        f"How many boxes of each class {letter.upper()} read as which",
    )


def significance_section(result: Result, evidence: pd.DataFrame) -> Section:
    """Return the section on each difference with its interval, p-value and method."""
    evidence = as_shown(result, evidence)
    columns: Columns = {
        "Measure": lambda row: row["label"] + ARROWS[row["better"]],
        **measure_columns("p (corrected)"),
        "Effect": (effect_text, ""),
    }
    methods: Columns = {
        "Measure": "label",
        "From": basis_text,
        "Method": lambda row: row["method"] or UNDEFINED,
        "Note": lambda row: row["note"] or UNDEFINED,
    }
    title, note, n = "Differences and tests", Note("sections.effects"), len(evidence)

    def intervals() -> go.Figure:
        from nvcore.report.html.charts import interval_plot

        return interval_plot(evidence, result.scheme("light"))

    blocks: tuple[Block, ...] = (
        listing(title, evidence, columns, notes=[note], printed=n),
        Chart("intervals", intervals, "Differences with their 95 % intervals"),
        Fold("Methods", (listing("Methods", evidence, methods),), "in significance.csv"),
        *([Paragraphs((INTERVAL_RULE,))] if np.isfinite(evidence["low"]).any() else []),
    )
    introduction = about("sections.significance", result)
    return Section("significance", "Is the difference real", introduction, blocks)


def basis_text(row: Row) -> str:
    """Return the number and kind of units behind a row of evidence, such as "12 recordings"."""
    return f"{row['n']:,} {row['unit']}"


def measure_columns(corrected: str) -> Columns:
    """Return table columns for a measure's values, difference, interval and p-values.

    `corrected` is the heading of the corrected p-value.
    """

    def value(letter: str) -> Callable[[Row], str]:
        return lambda row: number(row[letter], evidence_form(row["figure"]))

    return {"X": (value("x"), ""), "Y": (value("y"), ""), **evidence_columns(corrected)}


def evidence_columns(corrected: str) -> Columns:
    """Return table columns for a measure's difference, interval and p-values."""

    def apart(row: Row) -> str:
        return difference(row["x"], row["y"], evidence_form(row["figure"]))

    def interval(row: Row) -> str:
        return interval_text(row["low"], row["high"], evidence_form(row["figure"]))

    return {
        "X − Y": (apart, ""),
        "95 % interval": (interval, ""),
        "p": ("p", ".2g"),
        corrected: ("p_corrected", ".2g"),
    }
