"""What there is to say of the driver, as facts: kinds and numbers; `texts.py` says them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nvcore.sentences.facts import Fact


@dataclass(frozen=True)
class Why(Fact):
    """Why nothing is claimed.

    Attributes
    ----------
    kind
        The estimator is ``useless``, or has learnt from ``simulated`` subjects alone; too many
        encounters (`n` of `n_known`) are decided outside its ``range``; all `n` encounters are
        ``open``, or all that count as ``unseen``: within a standard deviation of the threshold.
    """

    kind: Literal["useless", "simulated", "range", "open", "unseen"]
    n: int = 0
    n_known: int = 0
    threshold: float = 0.0

    @property
    def where(self) -> Only:
        """In which encounters."""
        return Only("only" if self.n == 1 else "all", self.n)


@dataclass(frozen=True)
class Only(Fact):
    """All encounters of a kind, or the only one."""

    kind: Literal["only", "all"]
    n: int


@dataclass(frozen=True)
class NoClaim(Fact):
    """That nothing is claimed of whom the driver sees (``seen``), or of what is ``weighted``."""

    kind: Literal["seen", "weighted"]
    why: Why


@dataclass(frozen=True)
class NothingKnown(Fact):
    """That of no encounter it is known whether the driver sees it, though it is of some frames."""


@dataclass(frozen=True)
class Caution(Fact):
    """Why estimates are to be doubted."""

    text: str


@dataclass(frozen=True)
class Word(Fact):
    """On whose word it rests what the driver sees: the ``truth``'s, ``estimates``, or ``both``."""

    kind: Literal["truth", "estimates", "both"]
    caution: Caution | None = None
    n_estimated: int = 0
    n_stated: int = 0


@dataclass(frozen=True)
class Alerts(Fact):
    """Whom the driver sees unaided, and how many of the others each system detects.

    Attributes
    ----------
    kind
        ``unseen``: there are others. Else the driver sees ``all``, so that alerts are
        ``redundant``, if none is in doubt.
    useful_x, useful_y
        Detected by a system among those not seen.
    x, y, neither
        By X alone, by Y alone, by neither.
    """

    kind: Literal["unseen", "all", "redundant"]
    by: Word
    n_seen: int
    n_known: int
    n_unseen: int = 0
    useful_x: int = 0
    useful_y: int = 0
    x: int = 0
    y: int = 0
    neither: int = 0


@dataclass(frozen=True)
class Seldom(Fact):
    """How many of those seen are seen in less than a share of their frames."""

    n: int
    n_seen: int
    share: float


@dataclass(frozen=True)
class Counts(Fact):
    """Where each encounter is counted.

    Attributes
    ----------
    kind
        Whether some are ``unknown`` to be seen, some ``distant``.
    """

    n: int
    n_seen: int
    n_unseen: int
    n_unknown: int
    n_distant: int

    @property
    def kind(self) -> str:
        """Which of them there are."""
        names = ("unknown", self.n_unknown), ("distant", self.n_distant)
        return " ".join(name for name, n in names if n) or "all"


@dataclass(frozen=True)
class Known(Fact):
    """Of how many encounters it is known whether the driver sees them, and of how many it is open.

    Attributes
    ----------
    kind
        Of ``near`` or ``urgent`` ones; with ``open`` ones.
    """

    n_known: int
    n: int
    is_of_urgent: bool
    n_open: int
    by: Word

    @property
    def kind(self) -> str:
        """Of which encounters, and whether some are open."""
        return f"{'urgent' if self.is_of_urgent else 'near'}{' open' if self.n_open else ''}"


@dataclass(frozen=True)
class InTime(Fact):
    """Who is in time for the urgent encounters."""

    n: int
    driver: int
    both: int
    x: int
    y: int
    neither: int


@dataclass(frozen=True)
class SeenTooLate(Fact):
    """How many encounters the driver sees too late to stop."""

    n: int


@dataclass(frozen=True)
class DetectabilitySource(Fact):
    """Where detectability comes from, and what is called seen.

    Attributes
    ----------
    made_by
        How it was estimated, and why that is to be doubted.
    """

    kind: Literal["truth", "estimates", "both"]
    threshold: float
    made_by: tuple[str, ...] = ()
    n_estimated: int = 0
    n_stated: int = 0

    @property
    def how(self) -> str:
        """How it was estimated, in a row."""
        return ", ".join(self.made_by)


@dataclass(frozen=True)
class KnownExtent(Fact):
    """Of how many boxes it is known, where not of nearly all; of how many encounters it is not."""

    n_known: int
    n_boxes: int
    is_small: bool
    n_unknown: int

    @property
    def kind(self) -> str:
        """What there is to say."""
        if not self.is_small:
            return "encounters"
        return "both" if self.n_unknown else "boxes"

    @property
    def left_out(self) -> NotCounted:
        """The encounters."""
        return NotCounted("one" if self.n_unknown == 1 else "many", self.n_unknown)


@dataclass(frozen=True)
class NotCounted(Fact):
    """Encounters that are not counted."""

    kind: Literal["one", "many"]
    n: int


@dataclass(frozen=True)
class Outside(Fact):
    """Values outside the range of the training, and how many encounters they decide."""

    n: int
    n_known: int
    n_deciding: int
    n_encounters: int
    names: tuple[str, ...]

    @property
    def features(self) -> OutsideOf | None:
        """By which features."""
        return OutsideOf(self.names) if self.names else None

    @property
    def decided(self) -> str:
        """How many they decide, as a word."""
        return str(self.n_deciding or "none")


@dataclass(frozen=True)
class OutsideOf(Fact):
    """Features whose values are outside the range of the training."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class Open(Fact):
    """How many encounters may as well be on the other side of the threshold.

    Attributes
    ----------
    is_least
        Whether it is not known of others.
    n_open_unseen, n_unseen
        Of those not seen.
    """

    n: int
    n_known: int
    is_least: bool
    n_open_unseen: int
    n_unseen: int
    threshold: float

    @property
    def kind(self) -> str:
        """Whether it is not known of others, and whether some are not seen."""
        return f"{'least ' if self.is_least else ''}{'unseen' if self.n_open_unseen else 'seen'}"


@dataclass(frozen=True)
class LightUnknown(Fact):
    """Share of the estimates of which it is not known when the light last changed."""

    share: float


@dataclass(frozen=True)
class Adapted(Fact):
    """How many encounters are decided by estimates for adapted eyes."""

    n: int
    n_known: int


@dataclass(frozen=True)
class Weighting(Fact):
    """That misses weigh by what the driver does not see.

    Attributes
    ----------
    kind
        ``none``: it has no effect; ``all`` have a value, or ``one`` box or ``many`` have none.
    """

    kind: Literal["none", "all", "one", "many"]
    n: int = 0


@dataclass(frozen=True)
class WeightedClaims(Fact):
    """That measures of which something is claimed are weighted so."""


@dataclass(frozen=True)
class Estimated(Fact):
    """That what the driver sees is estimated, and why that is to be doubted."""

    caution: str


@dataclass(frozen=True)
class Region(Fact):
    """Encounters of a region of the driver's Venn diagram."""

    name: str
    n: int


@dataclass(frozen=True)
class SeenBy(Fact):
    """Encounters by who sees them."""

    regions: tuple[Region, ...]
