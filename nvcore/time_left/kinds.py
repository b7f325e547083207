"""Kinds of encounters by the time that is left, with one sentence each."""

from __future__ import annotations

from enum import StrEnum
from typing import Final


class Urgency(StrEnum):
    """Whether an encounter leaves time to brake; the first that holds, in this order."""

    UNKNOWN = "unknown"
    NOT_URGENT = "not_urgent"
    OUTSIDE = "outside"
    NO_CHANCE = "no_chance"
    URGENT = "urgent"


URGENCY_TEXT: Final[dict[Urgency, str]] = {
    Urgency.UNKNOWN: "In no frame is the time to contact known.",
    Urgency.NOT_URGENT: "The car could still have stopped in every frame.",
    Urgency.OUTSIDE: "Too far to the side when the car could no longer have stopped.",
    Urgency.NO_CHANCE: "Too near to stop from the first frame in which that is known.",
    Urgency.URGENT: "The driver had to be told before a moment that is known.",
}


class TimeLeft(StrEnum):
    """Whether a system confirmed an urgent pedestrian while the car could still stop."""

    IN_TIME = "in_time"
    LATE = "late"
    NEVER = "never"


TIME_LEFT_TEXT: Final[dict[TimeLeft, str]] = {
    TimeLeft.IN_TIME: "Confirmed while the car could still stop.",
    TimeLeft.LATE: "Confirmed when the car could no longer stop.",
    TimeLeft.NEVER: "Never confirmed.",
}
