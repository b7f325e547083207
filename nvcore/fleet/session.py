"""What a session says of recordings of a fleet.

[[recording]]
recorded_at = "2026-03-01T18:20:00+01:00"    without a zone: UTC
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class FleetEntry:
    """When a ``[[recording]]`` was recorded, by ISO 8601; None: not stated."""

    recorded_at: str | None = None
