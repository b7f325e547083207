"""What time left adds to the verdict and to the terminal's report."""

from __future__ import annotations

from typing import Final

from nvcore.comparison import Result
from nvcore.report.verdict import PointOf
from nvcore.sentences import phrase
from nvcore.time_left.said import confirmed, urgent

POINTS: Final = (PointOf("Time left", confirmed, after="Severity"),)


def lines(result: Result) -> list[str]:
    """Which encounters are urgent, for the terminal."""
    fact = urgent(result)
    return [f"time left: {phrase(fact, result.objects)}"] if fact else []
