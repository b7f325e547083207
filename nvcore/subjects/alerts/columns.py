"""Columns that alerts add to the CSV files of a report."""

from __future__ import annotations

from typing import Any, Final

from nvcore.comparison.compare import Result
from nvcore.subjects.alerts.steps import ASKED, alerts_in
from nvcore.tables.column import CellKind, Column, Columns, of_both
from nvcore.tables.result import frame_numbers


def _of_encounters(result: Result) -> dict[str, Any]:
    view, columns = alerts_in(result), {}
    for letter, system in result.sides:
        columns[f"alert_frame_{letter}"] = frame_numbers(result, view.first_alert(system))
        columns[f"alert_lead_s_{letter}"] = view.lead_s(system)
    return columns


COLUMNS: Final = (
    Columns(
        "encounters.csv",
        of_both(
            Column(
                "alert_frame",
                CellKind.INTEGER,
                "",
                "First frame of the first alert about the {one}.",
                empty="no alert is",
            ),
            Column(
                "alert_lead_s",
                CellKind.NUMBER,
                "s",
                "Time from there to `urgent_frame`; 0 or negative: too late.",
                "high",
                "`urgency` is not `urgent`, or no alert is about the {one}",
            ),
        ),
        _of_encounters,
        only_if=ASKED,
    ),
)
"""Columns of the CSV files."""
