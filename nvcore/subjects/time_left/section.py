"""Report section on time left: encounters confirmed in time, and the effect of the speed."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

import pandas as pd

from nvcore.common.wording.footnotes import Footnotes
from nvcore.comparison.compare import Result
from nvcore.notes import Note
from nvcore.report.section import (
    Block,
    Chart,
    Columns,
    Fold,
    Paragraphs,
    Section,
    SectionOf,
    Table,
    about,
    listing,
    of_both,
    spaced,
    table,
)
from nvcore.subjects.time_left.by_class import CLASS_HEAD, time_left_by_class
from nvcore.subjects.time_left.encounters import urgent_encounters
from nvcore.subjects.time_left.notes import confirmed, few_urgent, needed, orders, urgent
from nvcore.subjects.time_left.steps import time_left_in

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from nvcore.subjects.time_left.figures import OverSpeed

MOST_LISTED: Final = 20
"""Maximum number of urgent encounters in the list, as in the figure."""
OVER_SPEED: Final[dict[OverSpeed, str]] = {
    "share_in_time": "Share in time over speed",
    "mean_impact_kmh": "Mean impact speed over speed",
}


def _section(result: Result) -> Section:
    """Return the report section on urgent encounters up to contact and on the effect of speed."""
    curve, encounters = time_left_in(result).over_speed, urgent_encounters(result)
    notes = (
        *confirmed(result),
        urgent(result) or Note("time_left.nobody_met"),
        *few_urgent(result),
        *([needed(result.params)] if time_left_in(result).has_assumed_speed.any() else []),
        *orders(curve),
    )
    blocks: list[Block] = [Paragraphs(notes)]
    if not encounters.empty:
        in_words = "For each urgent encounter the last chance and when X and Y confirm"
        listed, classes = _listing(result, encounters), by_class(result)
        blocks += [
            Chart("approach", partial(_approach, result, encounters), in_words),
            Fold(listed.title, (listed,), "in encounters.csv"),
            *([Fold("By class of {one}", (classes,))] if classes else []),
        ]
    if curve["urgent"].any():
        charts = tuple(
            Chart(
                f"over-speed-{measure}",
                partial(_over_speed, result, curve, measure),
                f"{title} of the car, X and Y",
            )
            for measure, title in OVER_SPEED.items()
        )
        blocks.append(Fold("Share in time and impact speed over the speed of the car", charts))
    introduction = about("time_left.section", result)
    return Section("time-left", "Time left", introduction, tuple(blocks))


def _approach(result: Result, encounters: pd.DataFrame) -> go.Figure:
    from nvcore.subjects.time_left.figures import approach_plot

    return approach_plot(result, encounters, theme=result.scheme("light"))


def _over_speed(result: Result, curve: pd.DataFrame, measure: OverSpeed) -> go.Figure:
    from nvcore.subjects.time_left.figures import over_speed_plot

    speed_kmh, theme = time_left_in(result).assumed_speed_kmh, result.scheme("light")
    return over_speed_plot(curve, result.names, speed_kmh=speed_kmh, theme=theme, measure=measure)


def by_class(result: Result) -> Table | None:
    """Return a table of time left by class, or None if no urgent encounter has a class."""
    footnotes = Footnotes()
    rows = [(row.label, *row.cells(footnotes)) for row in time_left_by_class(result)]
    if not rows:
        return None
    return replace(
        table(
            "By class of {one}",
            ("Class", *CLASS_HEAD),
            [(label, *cells) for label, cells, _ in rows],
            right=range(1, 1 + len(CLASS_HEAD)),
            notes=[*footnotes.lines(), Note("time_left.by_class")],
        ),
        marks=tuple(marks for *_, marks in rows),
    )


def _listing(result: Result, urgent: pd.DataFrame) -> Table:
    """Return a table of the urgent encounters with the fastest impacts."""
    time_s = result.dataset.frames["time_s"].to_numpy()
    columns: Columns = {
        "Recording": "recording",
        "{One}": "track",
        "Last chance at (s)": (lambda row: time_s[row["urgent_row"]], ".2f"),
        **{f"{letter.upper()} confirms": spaced(f"time_left_{letter}") for letter in "xy"},
        **of_both("Margin {} (s)", "margin_s_{}", "+.2f"),
        **of_both("Impact {} (km/h)", "impact_kmh_{}", ".0f"),
    }
    rest = len(urgent) - MOST_LISTED
    left_out = Note("sections.left_out", which="fastest", n=MOST_LISTED, rest=rest)
    title = "Urgent encounters, the fastest impact first"
    rows = urgent.head(MOST_LISTED)
    return listing(title, rows, columns, notes=[left_out] if rest > 0 else [])


SECTIONS: Final = (
    SectionOf("time-left", _section, applies=lambda result: result.dataset.objects.is_on_road),
)
