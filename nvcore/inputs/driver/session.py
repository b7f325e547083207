"""What a session says of the driver: what he could see, where he looked, how bright it was.

[[recording]]
visible = "urban_01_visible.mp4"  pictures of visible light: a video, a folder, an archive
visible_map = [1.5, 1.5, 8, -12]  x_visible = 1.5 x + 8, y_visible = 1.5 y - 12
light = "lux.csv"                 time_s,lux of a light meter
gaze = "gaze.csv"                 frame,x,y of where the driver looked

[driver]
detectability = "detectability.csv"  what nvcore driver estimate wrote
provenance = "detectability.json"    a record of how
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Final, TypeVar

from nvcore.errors import SessionError
from nvcore.inputs.facts import check_path

GREATEST_SCALE: Final = 100.0
"""Of `visible_map`: pixels of the visible picture in one of the recording."""
GREATEST_OFFSET_PX: Final = 100_000.0
"""Of `visible_map`."""


@dataclass(frozen=True, kw_only=True)
class DriverEntry:
    """What a ``[[recording]]`` says of the driver; None: nothing.

    Attributes
    ----------
    visible
        Pictures of visible light, beside the `pictures` of another camera: a video, a folder or an
        archive. `first_picture` counts for both.
    visible_map
        (sx, sy, dx, dy): a point (x, y) of the recording, px, lies at (sx x + dx, sy y + dy) of the
        visible picture. None: by the two sizes.
    light
        CSV of a light meter: time_s (0 at frame 0), lux.
    gaze
        CSV of where the driver looked: frame, x, y (px of the visible picture, where there is one).
    """

    visible: str | None = None
    visible_map: tuple[float, float, float, float] | None = None
    light: str | None = None
    gaze: str | None = None

    def check_driver(self) -> None:
        """Raise SessionError where a path or the map cannot be one."""
        for name in ("visible", "light", "gaze"):
            check_path(name, getattr(self, name))
        if self.visible_map is None:
            return
        scales, offsets = self.visible_map[:2], self.visible_map[2:]
        if not (
            all(0 < scale <= GREATEST_SCALE for scale in scales)
            and all(abs(offset) <= GREATEST_OFFSET_PX for offset in offsets)
        ):  # nan is within nothing
            numbers = ", ".join(f"{value:g}" for value in self.visible_map)
            raise SessionError(
                f"visible_map: expected two positive scales of at most {GREATEST_SCALE:g} and two "
                f"offsets of at most {GREATEST_OFFSET_PX:.0f} px, found [{numbers}]"
            )

    @property
    def light_by(self) -> str:
        """What tells the light: ``"meter"``, ``"picture"`` (of visible light), else empty."""
        return "meter" if self.light is not None else "picture" if self.visible is not None else ""

    def driver_paths(self) -> Iterator[str]:
        """The files that it names, as they are written."""
        yield from (path for path in (self.visible, self.light, self.gaze) if path is not None)


AnyEntry = TypeVar("AnyEntry", bound=DriverEntry)


def with_driver_paths(entry: AnyEntry, rename: Callable[[str], str]) -> AnyEntry:
    """The entry with each path of `DriverEntry` renamed."""
    paths = {name: getattr(entry, name) for name in ("visible", "light", "gaze")}
    renamed: dict[str, Any] = {
        name: rename(path) for name, path in paths.items() if path is not None
    }
    return replace(entry, **renamed) if renamed else entry


def without_driver_paths(entry: AnyEntry) -> AnyEntry:
    """The entry without the files of `DriverEntry`."""
    return replace(entry, visible=None, visible_map=None, light=None, gaze=None)


@dataclass(frozen=True)
class DriverTable:
    """The ``[driver]`` of a session.

    Attributes
    ----------
    detectability
        CSV of how likely the driver sees each pedestrian by himself, 0 to 1, in each frame
        (docs/driver.md); None: nothing is known.

    provenance
        A record of how it was estimated (`nvcore.dataset.estimates`); None: nothing is known.
    """

    detectability: str | None = None
    provenance: str | None = None

    def __post_init__(self) -> None:
        for name in ("detectability", "provenance"):
            check_path(name, getattr(self, name))
            if getattr(self, name) == "":
                raise SessionError(f"{name}: expected a file, found nothing")
