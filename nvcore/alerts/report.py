"""What alerts add to the verdict and to the terminal's report."""

from __future__ import annotations

from typing import Final

from nvcore.alerts.said import alert_facts, alerts_of
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.report.verdict import PointOf
from nvcore.sentences import phrase

POINTS: Final = (PointOf("Alerts", alert_facts, after="The driver"),)


def lines(result: Result) -> list[str]:
    """The alerts of both systems, for the terminal."""
    if not alerts_in(result).is_asked:
        return []
    return [
        f"alerts: {phrase(alerts_of(result, letter, system), result.objects)}"
        for letter, system in result.sides
    ]
