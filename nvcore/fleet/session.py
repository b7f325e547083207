"""What a session says of recordings of a fleet.

[[recording]]
recorded_at = "2026-03-01T18:20:00+01:00"    without a zone: UTC
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

from nvcore.errors import SessionError


@dataclass(frozen=True, kw_only=True)
class FleetEntry:
    """What a ``[[recording]]`` says of where it belongs in a fleet.

    Attributes
    ----------
    recorded_at
        When it was recorded, by ISO 8601; None: not stated.
    """

    recorded_at: str | None = None


def time_of(text: str | None) -> datetime | None:
    """The time that `FleetEntry.recorded_at` states.

    Raises
    ------
    SessionError
        If it is none.
    """
    if text is None:
        return None
    try:
        when = datetime.fromisoformat(text)
        return when.replace(tzinfo=UTC) if when.tzinfo is None else when.astimezone(UTC)
    except (ValueError, OverflowError) as error:
        raise SessionError(
            f"recorded_at: expected a time such as 2026-03-01T18:20:00+01:00, found {text[:40]!r}"
        ) from error
