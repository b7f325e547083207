"""Kinds of encounters by the time left."""

from __future__ import annotations

from enum import StrEnum


class Urgency(StrEnum):
    """Urgency of an encounter: the first of these, in this order, that applies."""

    UNKNOWN = "unknown"
    NOT_URGENT = "not_urgent"
    OUTSIDE = "outside"
    NO_CHANCE = "no_chance"
    URGENT = "urgent"


class TimeLeft(StrEnum):
    """Outcome of an urgent encounter: confirmed while the car could still stop, later, or never."""

    IN_TIME = "in_time"
    LATE = "late"
    NEVER = "never"
