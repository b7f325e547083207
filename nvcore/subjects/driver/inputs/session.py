"""Session tables about the driver: gaze, ambient light, detectability.

[[recording]]
light = "lux.csv"                 time_s,lux of a light meter
gaze = "gaze.csv"                 frame,x,y of where the driver looked

[driver]
detectability = "detectability.csv"  what nvcore driver estimate wrote
provenance = "detectability.json"    a record of how
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from nvcore.common.errors import SessionError
from nvcore.inputs.facts import check_paths, path_field

DETECTABILITY: Final = "detectability"
"""Subject of findings about a file of estimates, in addition to truth and systems."""


@dataclass(frozen=True, kw_only=True)
class DriverEntry:
    """Keys about the driver in a ``[[recording]]``. None is unknown.

    Attributes
    ----------
    light
        CSV of a light meter: time_s (0 at frame 0), lux.
    gaze
        CSV of gaze points: frame, x, y (px of the visible picture if there is one).
    """

    light: str | None = path_field(label="Light meter (CSV: time_s,lux)")
    gaze: str | None = path_field(label="Where the driver looked (CSV: frame,x,y)")


@dataclass(frozen=True)
class DriverTable:
    """The ``[driver]`` table of a session.

    Attributes
    ----------
    detectability
        CSV with the estimated detectability of each pedestrian, 0 to 1, in each frame
        (docs/driver-reference.md). None: unknown.
    provenance
        Record of the estimation (`nvcore.subjects.driver.inputs.record`). None: unknown.
    """

    detectability: str | None = path_field()
    provenance: str | None = path_field()

    def __post_init__(self) -> None:
        check_paths(self)
        for name in ("detectability", "provenance"):
            if getattr(self, name) == "":
                raise SessionError(f"{name}: expected a file, found nothing")


@dataclass(frozen=True, kw_only=True)
class DriverTables:
    """Session keys on what the driver sees unaided."""

    driver: DriverTable = field(default_factory=DriverTable)
