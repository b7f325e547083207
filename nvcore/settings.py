"""How a dataset is compared unless the caller says otherwise."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal, Self, get_args

from nvcore.codes import CodedInterval
from nvcore.errors import ParameterError
from nvcore.objects import PEDESTRIAN, Objects
from nvcore.params import Params
from nvcore.primary import Primary
from nvcore.protocols import PROTOCOLS, Protocol
from nvcore.published import PublishedPoint

OperatingPoint = Literal["as-set", "equal-alarms"]
POINTS: Final[tuple[OperatingPoint, ...]] = get_args(OperatingPoint)


def operating_point(name: str | None) -> OperatingPoint | None:
    """The operating point of that name.

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
MAX_FPS: Final = 10_000.0
"""Frame rates that are believed: from a picture every 17 minutes to the fastest cameras."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How a dataset is to be compared; usually an `nvcore.inputs.session.Session`.

    Attributes
    ----------
    x, y
        Names of the two systems to compare; None: the first that is not the other one.
    params
        Settings of the analysis. Thresholds given here override those of the systems.
    protocol
        Which pedestrians count in the detection measures.
    only_tags, only
        Compare only recordings that have all of these tags, and of these only those so named, by
        title or as in the data; (): all.
    objects
        What the boxes are of: which classes the readers keep unless told otherwise, and what the
        texts call them.
    published
        Operating points of others, drawn beside the curves.
    accept
        Codes of errors of the audit that are meant: they are warnings.
    codes
        Stretches of recordings with a code, which is a class of the encounters that they overlap.
    primary
        The measure by which the comparison is decided.
    operating_point
        Where X and Y are set to unequally many false alarms: whether their numbers are with one
        threshold moved, so that both have equally many, or as they are set. None: as set in files
        and for programs, equal in dashboard and report. Claims are about equal ones either way.
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
        """The same settings of data whose systems and recordings are called otherwise.

        Parameters
        ----------
        systems, recordings
            New names by the old ones; what is not named stays.
        of
            Names of the data's systems and recordings until now.
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
        """Names of X and Y: those given, else its own where the other is not called so."""
        own_x = None if self.x == y else self.x
        own_y = None if self.y == x else self.y
        return x or own_x, y or own_y

    @property
    def thresholds(self) -> tuple[float | None, ...]:
        """Score threshold of each system, in their order; empty: every detection counts."""
        return ()


def is_chosen(
    name: str, own: Collection[str], tags: Collection[str], names: Collection[str]
) -> bool:
    """Whether a recording with its own tags has all of the tags and, if there are any, a name."""
    return set(tags) <= set(own) and (not names or name in names)


def as_names(names: str | Iterable[str]) -> tuple[str, ...]:
    """Names that may be given as a single one."""
    return (names,) if isinstance(names, str) else tuple(names)


def new_names(names: Iterable[str], new: Mapping[str, str]) -> tuple[str, ...]:
    """The names, those that are called otherwise by their new ones."""
    return tuple(new.get(name, name) for name in names)
