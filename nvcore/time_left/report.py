"""What time left adds to the verdict and to the terminal's report."""

from __future__ import annotations

from typing import Final

from nvcore.comparison import Result
from nvcore.report.verdict import PointOf
from nvcore.time_left.texts import describe_time_left, describe_urgency

POINTS: Final = (PointOf("Time left", describe_time_left, after="Severity"),)


def lines(result: Result) -> list[str]:
    """Which encounters are urgent, for the terminal."""
    urgency = describe_urgency(result)
    return [f"time left: {urgency[0].lower()}{urgency[1:-1]}"] if urgency else []
