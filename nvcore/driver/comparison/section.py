"""Section about the driver: whom he sees by himself, and who warns him of the others."""

from __future__ import annotations

from typing import Final

from nvcore.comparison import Result
from nvcore.driver.comparison.encounters import driver_venn_table, saved_encounters
from nvcore.driver.comparison.kinds import DriverRegion
from nvcore.driver.comparison.notes import driver_notes
from nvcore.driver.comparison.steps import driver_in
from nvcore.notes import say
from nvcore.params import Params
from nvcore.report.html.blocks import Intro, Section, SectionOf, Sentences, Table, table
from nvcore.wording import number


def driver_section(result: Result) -> Section:
    """The eight regions of driver, X and Y, and the urgent encounters that one alone saves."""
    sentences = tuple(say(note, result.objects) for note in driver_notes(result))
    blocks: list[Sentences | Table] = [Sentences(sentences), _regions(result)]
    saved = _saved(result)
    if saved.rows:
        blocks.append(saved)
    return Section("driver", "The driver", _introduction(result.params), tuple(blocks))


def _introduction(params: Params) -> Intro:
    return Intro(
        what="{What} the driver sees unaided, and which system warns of the others.",
        how="Detectability is the share of drivers who would see the {one} of a frame by "
        f"themselves. The driver sees an encounter if it is at least {params.driver_threshold:g} "
        "in a frame up to the first in which the {one} counts; that frame confirms. A useful "
        "alert is an encounter that a system detects and the driver does not see, a redundant one "
        "the driver sees anyway, an unprotected one neither sees. Encounters in which "
        "detectability is unknown until then are counted apart. In time is the driver who sees the "
        "{one}, early or late, before the car can no longer stop.",
        best="Many useful alerts, no encounter unprotected.",
        limits="It rests on the detectability that was given: an estimate speaks of people like "
        "those from whose answers it was learnt, who looked for {a_one}. Where "
        "this driver looked is not known, nor whether a warning would have been heeded.",
    )


def _regions(result: Result) -> Table:
    rows = [
        (
            row["who"],
            f"{row['encounters']:,}",
            *(f"{row[f'severity_{letter}']:.2f}" for letter in "xy"),
            row["meaning"],
        )
        for row in driver_venn_table(result).to_dict("records")
        if row["encounters"] or row["region"] != DriverRegion.UNKNOWN
    ]
    head = ("Seen by", "Encounters", "Severity for X (s)", "Severity for Y (s)", "Meaning")
    return table("Encounters by who sees them", head, rows, right=(1, 2, 3))


def _saved(result: Result) -> Table:
    """The urgent encounters that one system alone confirms in time."""
    rows = [
        (
            row["recording"],
            row["track"],
            row["system"].upper(),
            row["urgent_frame"],
            number(row["detectability"], ".2f"),
            *(number(row[f"impact_kmh_{letter}"], ".0f") for letter in "xy"),
        )
        for row in saved_encounters(result).to_dict("records")
    ]
    head = (
        *("Recording", result.objects.say("{One}"), "Alone in time", "Last chance (frame)"),
        *("Detectability", "Impact X (km/h)", "Impact Y (km/h)"),
    )
    title = "Urgent encounters in time by one system alone, by neither driver nor the other"
    return table(title, head, rows, right=(3, 4, 5, 6))


SECTIONS: Final = (
    SectionOf("driver", driver_section, applies=lambda result: driver_in(result).has_any),
)
"""Sections of the HTML report."""
