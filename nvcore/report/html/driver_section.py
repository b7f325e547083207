"""Section about the driver: whom he sees by himself, and who warns him of the others."""

from __future__ import annotations

from nvcore.comparison import Result
from nvcore.driver.comparison.kinds import DriverRegion
from nvcore.report.html import words
from nvcore.report.html.blocks import Section, Sentences, Table, table
from nvcore.report.verdict.driver import describe_driver
from nvcore.tables.encounters.driver import driver_venn_table, saved_encounters
from nvcore.wording import number


def driver_section(result: Result) -> Section:
    """The eight regions of driver, X and Y, and the urgent encounters that one alone saves."""
    blocks: list[Sentences | Table] = [Sentences(describe_driver(result)), _regions(result)]
    saved = _saved(result)
    if saved.rows:
        blocks.append(saved)
    return Section("driver", "The driver", words.driver(result.params), tuple(blocks))


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
