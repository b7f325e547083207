"""Kinds of encounters by the time that is left."""

from __future__ import annotations

from enum import StrEnum


class Urgency(StrEnum):
    """Whether an encounter leaves time to brake; the first that holds, in this order."""

    UNKNOWN = "unknown"
    NOT_URGENT = "not_urgent"
    OUTSIDE = "outside"
    NO_CHANCE = "no_chance"
    URGENT = "urgent"


class TimeLeft(StrEnum):
    """Whether a system confirmed an urgent pedestrian while the car could still stop."""

    IN_TIME = "in_time"
    LATE = "late"
    NEVER = "never"
