"""Default settings for comparing a dataset."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal, Self, get_args

from nvcore.common.errors import ParameterError
from nvcore.settings.codes import CodedInterval
from nvcore.settings.objects import PEDESTRIAN, Objects
from nvcore.settings.params import Params
from nvcore.settings.primary import Primary
from nvcore.settings.protocols import PROTOCOLS, Protocol
from nvcore.settings.published import PublishedPoint

OperatingPoint = Literal["as-set", "equal-alarms", "delivered"]
POINTS: Final[tuple[OperatingPoint, ...]] = get_args(OperatingPoint)
DELIVERED: Final = "delivered"
"""The thresholds are those of delivered products. Claims are about them, as long as the better
system has not clearly more false alarms."""


def operating_point(name: str | None) -> OperatingPoint | None:
    """Return the operating point with this name, None for None.

    Raises
    ------
    ParameterError
        If there is none.
    """
    for known in POINTS:
        if name in (None, known):
            return None if name is None else known
    raise ParameterError(f"operating_point: expected {' or '.join(POINTS)}, got {name!r}")


MIN_FPS: Final = 0.001
"""Smallest plausible frame rate: a picture every 17 minutes."""
MAX_FPS: Final = 10_000.0
"""Largest plausible frame rate, of the fastest cameras."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings for comparing a dataset, usually an `nvcore.inputs.session.Session`.

    Attributes
    ----------
    x, y
        Names of the two systems to compare; None: the first that is not the other one.
    params
        Settings of the analysis. Thresholds given here override those of the systems.
    protocol
        Selection of the pedestrians that count in the detection measures.
    only_tags, only
        Compare only recordings that have all of these tags and one of these names (title or name in
        the data); (): all.
    objects
        Kind of objects in the boxes. It defines the classes that readers keep by default, and the
        words for them in texts.
    published
        Operating points of others, drawn beside the curves.
    accept
        Codes of audit errors that are intended, and so become warnings.
    codes
        Intervals of recordings with a code, which is a class of the encounters that they overlap.
    primary
        Measure that decides the comparison.
    operating_point
        Numbers to show if X and Y have unequal false alarms: as they are set, or with one threshold
        moved to equalise them. Claims are about equal false alarms either way. `DELIVERED`: numbers
        and claims are as set. None: as set in files and for programs, equal in dashboard and
        report.
    """

    x: str | None = None
    y: str | None = None
    params: Params = field(default_factory=Params)
    protocol: Protocol = PROTOCOLS["all"]
    only_tags: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    objects: Objects = PEDESTRIAN
    published: tuple[PublishedPoint, ...] = ()
    accept: tuple[str, ...] = ()
    codes: tuple[CodedInterval, ...] = ()
    primary: Primary = Primary()
    operating_point: OperatingPoint | None = None

    def renamed(
        self,
        systems: Mapping[str, str],
        recordings: Mapping[str, str],
        *,
        of: tuple[Sequence[str], Sequence[str]],
    ) -> Self:
        """Return the same settings with other names of systems and recordings.

        Parameters
        ----------
        systems, recordings
            New names by the old ones. Others stay.
        of
            Old names of the data's systems and recordings.
        """
        del of
        counting = new_names(self.protocol.recordings, recordings)
        return replace(
            self,
            x=None if self.x is None else systems.get(self.x, self.x),
            y=None if self.y is None else systems.get(self.y, self.y),
            protocol=replace(self.protocol, recordings=counting),
            only=new_names(self.only, recordings),
            codes=tuple(
                replace(of, recording=recordings.get(of.recording, of.recording))
                for of in self.codes
            ),
        )

    def names(self, x: str | None, y: str | None) -> tuple[str | None, str | None]:
        """Return the names of X and Y: those given, or its own unless taken by the other."""
        own_x = None if self.x == y else self.x
        own_y = None if self.y == x else self.y
        return x or own_x, y or own_y

    @property
    def thresholds(self) -> tuple[float | None, ...]:
        """Score threshold of each system in order, empty if every detection counts."""
        return ()


def is_chosen(
    name: str, own: Collection[str], tags: Collection[str], names: Collection[str]
) -> bool:
    """Whether a recording with its own tags has all of the tags and, if there are any, a name."""
    return set(tags) <= set(own) and (not names or name in names)


def as_names(names: str | Iterable[str]) -> tuple[str, ...]:
    """Return one or several names as a tuple."""
    return (names,) if isinstance(names, str) else tuple(names)


def new_names(names: Iterable[str], new: Mapping[str, str]) -> tuple[str, ...]:
    """Return the names with the renamed ones replaced."""
    return tuple(new.get(name, name) for name in names)
