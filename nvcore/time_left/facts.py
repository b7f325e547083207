"""What time left has to say in every medium, as facts, and how they are said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from nvcore.sentences.facts import Fact
from nvcore.sentences.texts import Texts


@dataclass(frozen=True)
class Speed(Fact):
    """At which speed: ``assumed``, that of each recording (``own``), or assumed for ``some``."""

    kind: Literal["assumed", "own", "some"]
    kmh: float
    n_assumed: int = 0


@dataclass(frozen=True)
class Confirmed(Fact):
    """How many urgent encounters each system confirms in time, and the mean impact speeds, km/h.

    Attributes
    ----------
    kind
        Of ``many``; of a single one ``both``, ``x``, ``y`` or ``neither``.
    """

    n: int
    x: int
    y: int
    impact_x: float
    impact_y: float
    speed: Speed

    @property
    def kind(self) -> str:
        """Of a single one, who does."""
        if self.n > 1:
            return "many"
        return {(1, 1): "both", (1, 0): "x", (0, 1): "y", (0, 0): "neither"}[self.x, self.y]


@dataclass(frozen=True)
class Reason(Fact):
    """Why time to contact is unknown: frames are ``sampled``, tracks ``linked`` by us or ``short``.

    Where there are several reasons, of `n` encounters each.
    """

    kind: Literal["sampled", "linked", "short", "n sampled", "n linked", "n short"]
    n: int


@dataclass(frozen=True)
class Unknown(Fact):
    """Why: in brackets."""

    reasons: tuple[Reason, ...]


@dataclass(frozen=True)
class Kind(Fact):
    """Encounters that are not urgent, by why not."""

    kind: Literal["no chance", "outside", "not urgent", "unknown"]
    n: int
    unknown: Unknown | None = None


@dataclass(frozen=True)
class Others(Fact):
    """Encounters that are not urgent."""

    kinds: tuple[Kind, ...]


@dataclass(frozen=True)
class Among(Fact):
    """How many all encounters are, those included that stay distant."""

    n: int
    n_distant: int


@dataclass(frozen=True)
class Urgent(Fact):
    """How many encounters leave a last chance to stop, and why others do not.

    Attributes
    ----------
    kind
        ``unknown`` of all; ``none``, ``one`` or ``many``.
    """

    kind: Literal["unknown", "none", "one", "many"]
    speed: Speed
    n: int = 0
    others: Others | None = None
    among: Among | None = None
    unknown: Unknown | None = None


@dataclass(frozen=True)
class NobodyMet(Fact):
    """That there is no encounter."""


_IMPACT: Final = "impact speed {impact_x:.1f} km/h with X and {impact_y:.1f} km/h with Y."
_ONLY: Final = "the only urgent encounter {speed} is confirmed in time by"

TEXTS: Final[Texts] = {
    Speed: {
        "assumed": "at {kmh:g} km/h (assumed)",
        "own": "at the speed of each recording",
        "some": "at the speed of each recording ({kmh:g} km/h assumed in {n_assumed!n:recording} "
        "without)",
    },
    Confirmed: {
        "many": "of {n} urgent encounters {speed}, X confirms {x} in time and Y {y}; mean "
        f"{_IMPACT}",
        "both": f"{_ONLY} X and Y; {_IMPACT}",
        "x": f"{_ONLY} X, not by Y; {_IMPACT}",
        "y": f"{_ONLY} Y, not by X; {_IMPACT}",
        "neither": f"{_ONLY} neither; {_IMPACT}",
    },
    Reason: {
        "sampled": "not every frame is evaluated",
        "linked": "the truth has no track ids",
        "short": "too short, or cut by the picture's edge",
        "n sampled": "{n} as not every frame is evaluated",
        "n linked": "{n} as the truth has no track ids",
        "n short": "{n} as too short, or cut by the picture's edge",
    },
    Unknown: " ({reasons:, })",
    Kind: {
        "no chance": "{n} without a chance (too near to stop when first known)",
        "outside": "{n} outside the corridor",
        "not urgent": "{n} not urgent",
        "unknown": "{n} unknown{unknown}",
    },
    Others: "; {kinds:, }",
    Among: " (of all {n!n:encounter}, {n_distant!n:distant one} among them)",
    Urgent: {
        "unknown": "time left to stop is unknown for all encounters{unknown}",
        "none": "{nobody} is urgent {speed}{others}{among}",
        "one": "1 encounter is urgent {speed}{others}{among}",
        "many": "{n:,} encounters are urgent {speed}{others}{among}",
    },
    NobodyMet: "no {one} is met",
}
