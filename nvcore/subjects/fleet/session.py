"""Keys of a session about recordings of a fleet.

[[recording]]
recorded_at = "2026-03-01T18:20:00+01:00"    without a zone: UTC
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class FleetEntry:
    """Time at which a ``[[recording]]`` was recorded, by ISO 8601, or None."""

    recorded_at: str | None = None
