"""Section about time left: who is confirmed in time, and what the speed changes."""

from __future__ import annotations

from typing import Final

import pandas as pd

from nvcore.comparison import Result
from nvcore.notes import Note, say
from nvcore.params import Params
from nvcore.report.html.blocks import (
    Chart,
    Fold,
    Intro,
    Section,
    SectionOf,
    Sentences,
    Table,
    table,
)
from nvcore.report.html.result_sections import names_of
from nvcore.time_left.by_class import CLASS_HEAD, time_left_by_class
from nvcore.time_left.encounters import urgent_encounters
from nvcore.time_left.figures.approach import MOST_ROWS, approach_plot
from nvcore.time_left.figures.over_speed import LOOKS, OverSpeed, over_speed_plot
from nvcore.time_left.notes import confirmed, few_urgent, needed, orders, urgent
from nvcore.time_left.steps import time_left_in
from nvcore.wording import Footnotes, capitalised, number


def _section(result: Result) -> Section:
    """The urgent encounters up to contact, and both systems over the speed of the car."""
    curve, encounters = time_left_in(result).over_speed, urgent_encounters(result)
    of_urgent = urgent(result) or Note("time_left.nobody_met")
    notes = (
        *few_urgent(result),
        *([needed(result.params)] if time_left_in(result).has_assumed_speed.any() else []),
        *orders(curve),
    )
    sentences = (
        *(say(note, result.objects) for note in confirmed(result)),
        f"{say(of_urgent, result.objects)}.",
        *(say(note, result.objects) for note in notes),
    )
    blocks: list[Sentences | Chart | Table | Fold] = [Sentences(sentences)]
    if not encounters.empty:
        figure = approach_plot(result, encounters, theme=result.scheme("light"))
        in_words = "For each urgent encounter the last chance and when X and Y confirm"
        listing = _listing(result, encounters)
        blocks += [
            Chart("approach", figure, in_words),
            Fold(listing.title, (listing,), "in encounters.csv"),
            *_by_class(result),
        ]
    if curve["urgent"].any():
        charts = tuple(_over_speed(result, curve, measure) for measure in LOOKS)
        blocks.append(Fold("Share in time and impact speed over the speed of the car", charts))
    return Section("time-left", "Time left", _introduction(result.params), tuple(blocks))


def _introduction(params: Params) -> Intro:
    return Intro(
        what="Whether braking could still have helped when a system had found the {one}. An "
        "encounter is urgent if the car comes so near that a warning given then could no longer "
        "stop it; the last chance is the first such frame.",
        how="One over the height of {his} box (or {his} distance, where the truth states it) falls "
        "on a line that reaches zero at contact: that gives the time to contact in each frame. The "
        f"last chance is the first frame with less than {params.reaction_s:g} s and half the time "
        f"of braking with {params.deceleration:g} m/s² left. A system has confirmed the {{one}} "
        f"once {params.confirm_n:g} of {{his}} last {params.confirm_m:g} frames are matched: in "
        "time if before the last chance; late, and then the car reaches {him} with the impact "
        "speed; or never, at full speed. The margin is the time from confirmation to the last "
        "chance.",
        best="All in time, an impact speed of 0.",
        limits="In time means that a warning could have come early enough, not that the driver "
        "would have heeded it. {Many} are taken to go on as they do, the car to drive on at "
        "its speed, which is assumed where the recordings do not state it. Whether a difference is "
        "more than chance: see Is the difference real.",
    )


def _by_class(result: Result) -> tuple[Fold, ...]:
    """A row for each class of urgent encounters; empty: they have none."""
    rows, notes = [], Footnotes()
    for row in time_left_by_class(result):
        cells, marks = row.cells(notes)
        rows.append((f"{row.label} {marks}".rstrip(), *cells))
    if not rows:
        return ()
    title = result.objects.say("By class of {one}")
    texts = (f"{mark}: {capitalised(note)}." for note, mark in notes.marks.items())
    note = " ".join((*texts, say(Note("time_left.by_class"), result.objects)))
    head = ("Class", *CLASS_HEAD)
    return (Fold(title, (table(title, head, rows, right=range(1, len(head)), note=note),)),)


def _over_speed(result: Result, curve: pd.DataFrame, measure: OverSpeed) -> Chart:
    figure = over_speed_plot(
        curve,
        names_of(result),
        speed_kmh=time_left_in(result).assumed_speed_kmh,
        theme=result.scheme("light"),
        measure=measure,
    )
    return Chart(f"over-speed-{measure}", figure, f"{LOOKS[measure].title} of the car, X and Y")


def _listing(result: Result, urgent: pd.DataFrame) -> Table:
    """The urgent encounters with the fastest impacts, as many as the figure has."""
    time_s = result.dataset.frames["time_s"].to_numpy()
    rows = [
        (
            row["recording"],
            row["track"],
            f"{time_s[row['urgent_row']]:.2f}",
            *(str(row[f"time_left_{letter}"]).replace("_", " ") for letter in "xy"),
            *(number(row[f"margin_s_{letter}"], "+.2f") for letter in "xy"),
            *(number(row[f"impact_kmh_{letter}"], ".0f") for letter in "xy"),
        )
        for row in urgent.head(MOST_ROWS).to_dict("records")
    ]
    head = (
        *(
            "Recording",
            result.objects.say("{One}"),
            "Last chance at (s)",
            "X confirms",
            "Y confirms",
        ),
        *("Margin X (s)", "Margin Y (s)", "Impact X (km/h)", "Impact Y (km/h)"),
    )
    left_out = len(urgent) - len(rows)
    note = f"The fastest {len(rows):,} are shown, {left_out:,} are left out." if left_out else ""
    title = "Urgent encounters, the fastest impact first"
    return table(title, head, rows, right=(2, 5, 6, 7, 8), note=note)


SECTIONS: Final = (
    SectionOf("time-left", _section, applies=lambda result: result.dataset.objects.is_on_road),
)
"""Sections of the HTML report."""
