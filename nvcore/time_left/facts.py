"""What time left has to say in every medium, as facts, and how they are said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from nvcore.sentences.facts import Fact
from nvcore.sentences.texts import Texts
from nvcore.wording import listed


@dataclass(frozen=True)
class Speed(Fact):
    """At which speed: ``assumed``, that of each recording (``own``), or assumed for ``some``.

    With a series of it that of each frame (``by frame``), or assumed in ``some frames``.
    """

    kind: Literal["assumed", "own", "some", "by frame", "some frames"]
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
class UnknownReason(Fact):
    """Why time to contact is unknown: frames are ``sampled``, tracks ``linked`` by us or ``short``.

    Where there are several reasons, of `n` encounters each.
    """

    kind: Literal["sampled", "linked", "short", "n sampled", "n linked", "n short"]
    n: int


@dataclass(frozen=True)
class Unknown(Fact):
    """Why: in brackets."""

    reasons: tuple[UnknownReason, ...]


@dataclass(frozen=True)
class NotUrgent(Fact):
    """Encounters that are not urgent, by why not."""

    kind: Literal["no chance", "outside", "not urgent", "unknown"]
    n: int
    unknown: Unknown | None = None


@dataclass(frozen=True)
class Others(Fact):
    """Encounters that are not urgent."""

    kinds: tuple[NotUrgent, ...]


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


@dataclass(frozen=True)
class NeededWarning(Fact):
    """When a warning must come for the car to stop; seconds, and m/s²."""

    speed_kmh: float
    needed_s: float
    reaction_s: float
    deceleration: float


@dataclass(frozen=True)
class FewUrgent(Fact):
    """That one or so many urgent encounters are few."""

    kind: Literal["one", "many"]
    n: int


@dataclass(frozen=True)
class Response(Fact):
    """What a system made of an urgent encounter.

    Attributes
    ----------
    kind
        It confirms it before the last chance (``in time``), in that very frame (``only then``),
        ``late`` or ``never``.
    margin_s
        From there to the last chance.
    """

    kind: Literal["in time", "only then", "late", "never"]
    letter: str
    margin_s: float
    impact_kmh: float

    @property
    def late_s(self) -> float:
        """From the last chance to there."""
        return -self.margin_s


@dataclass(frozen=True)
class WhyUnknown(Fact):
    """Why the time to contact of an encounter is unknown."""

    kind: Literal["sampled", "linked", "short"]


@dataclass(frozen=True)
class SpeedOfOne(Fact):
    """The speed of the car, ``assumed`` or the recording's ``own``.

    By a series of it that at the last chance, or the lowest and highest in the encounter's frames
    (``by frame``), assumed in ``some frames``.
    """

    kind: Literal["assumed", "own", "by frame", "some frames"]
    kmh: float
    highest_kmh: float = 0.0

    @property
    def span(self) -> str:
        """The lowest and the highest, one number where they are shown as the same."""
        return " to ".join(dict.fromkeys((f"{self.kmh:.1f}", f"{self.highest_kmh:.1f}")))


@dataclass(frozen=True)
class LastChance(Fact):
    """The last chance of an encounter, and what both systems made of it.

    Attributes
    ----------
    kind
        It is ``unknown``; the car is ``never nearer``; the encounter is ``not urgent``, without a
        chance (``no chance``), ``outside`` the corridor, or ``urgent``.
    least_s
        Least time to contact.
    frame, time_s
        Where the last chance is.
    """

    kind: Literal["unknown", "never nearer", "not urgent", "no chance", "outside", "urgent"]
    why: WhyUnknown | None = None
    speed: SpeedOfOne | None = None
    least_s: float = 0.0
    frame: int = 0
    time_s: float = 0.0
    responses: tuple[Response, ...] = ()


@dataclass(frozen=True)
class Ahead(Fact):
    """That a system is ahead in ``share_in_time`` or ``mean_impact_kmh``."""

    kind: Literal["share_in_time", "mean_impact_kmh"]
    letter: str


@dataclass(frozen=True)
class OverSpeed(Fact):
    """The measure over the speed of the car."""

    kind: Literal["share_in_time", "mean_impact_kmh"]


@dataclass(frozen=True)
class Equal(Fact):
    """At how many speeds X and Y are equal: as an exception (``but``), or in ``addition``."""

    kind: Literal["but", "addition"]
    n: int
    n_all: int


@dataclass(frozen=True)
class OrderOverSpeed(Fact):
    """Which system is ahead at which speed of the car.

    Attributes
    ----------
    kind
        None is at any (``same``), one is ``always``, the order turns ``once`` or ``often``.
    second
        Who is ahead above the first of `turns_kmh`.
    """

    kind: Literal["same", "always", "once", "often"]
    measure: OverSpeed
    ahead: Ahead | None = None
    second: str = ""
    turns_kmh: tuple[float, ...] = ()
    equal: Equal | None = None

    @property
    def n_turns(self) -> int:
        """How often it turns."""
        return len(self.turns_kmh)

    @property
    def turns_text(self) -> str:
        """At which speeds."""
        return listed([f"{speed_kmh:g}" for speed_kmh in self.turns_kmh])


_IMPACT: Final = "impact speed {impact_x:.1f} km/h with X and {impact_y:.1f} km/h with Y."
_HAPPENED: Final = "what happened in these recordings, and little of what happens in others."
_HIT: Final = "impact at {impact_kmh:.0f} km/h"
_WHEN: Final = "frame {frame} ({time_s:.2f} s)"
_ONLY: Final = "the only urgent encounter {speed} is confirmed in time by"

TEXTS: Final[Texts] = {
    Speed: {
        "assumed": "at {kmh:g} km/h (assumed)",
        "own": "at the speed of each recording",
        "some": "at the speed of each recording ({kmh:g} km/h assumed in {n_assumed!n:recording} "
        "without)",
        "by frame": "at the speed of the car in each frame",
        "some frames": "at the speed of the car in each frame ({kmh:g} km/h assumed in "
        "{n_assumed!n:recording}, where none is stated)",
    },
    Confirmed: {
        "many": "of {n} urgent encounters {speed}, X confirms {x} in time and Y {y}; mean "
        f"{_IMPACT}",
        "both": f"{_ONLY} X and Y; {_IMPACT}",
        "x": f"{_ONLY} X, not by Y; {_IMPACT}",
        "y": f"{_ONLY} Y, not by X; {_IMPACT}",
        "neither": f"{_ONLY} neither; {_IMPACT}",
    },
    UnknownReason: {
        "sampled": "not every frame is evaluated",
        "linked": "the truth has no track ids",
        "short": "too short, or cut by the picture's edge",
        "n sampled": "{n} as not every frame is evaluated",
        "n linked": "{n} as the truth has no track ids",
        "n short": "{n} as too short, or cut by the picture's edge",
    },
    Unknown: " ({reasons:, })",
    NotUrgent: {
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
    NeededWarning: "at {speed_kmh:g} km/h the car still stops before {a_one} if the warning comes "
    "more than {needed_s:.1f} s before contact: {reaction_s:g} s pass until the brakes act, then "
    "it brakes with {deceleration:g} m/s². The first frame with less time left is the last chance.",
    FewUrgent: {
        "one": f"the only urgent encounter says {_HAPPENED}",
        "many": f"{{n}} urgent encounters are few: they say {_HAPPENED}",
    },
    Response: {
        "in time": "{letter!u} confirms {him} {margin_s:.2f} s before it, in time",
        "only then": f"{{letter!u}} confirms {{him}} only then, late: {_HIT}",
        "late": f"{{letter!u}} confirms {{him}} {{fact.late_s:.2f}} s after it, late: {_HIT}",
        "never": f"{{letter!u}} never confirms {{him}}: {_HIT}",
    },
    WhyUnknown: {
        "sampled": "not every frame is evaluated",
        "linked": "the truth gives this {one} no track id",
        "short": "{he} is there for too few frames, or cut by the picture's edge",
    },
    SpeedOfOne: {
        "assumed": "{kmh:g} km/h (assumed)",
        "own": "{kmh:g} km/h",
        "by frame": "{fact.span} km/h",
        "some frames": "{fact.span} km/h (assumed in some frames)",
    },
    LastChance: {
        "unknown": "time left to stop is unknown: {why}.",
        "never nearer": "not urgent: the car never comes nearer, as far as the boxes tell.",
        "not urgent": "not urgent at {speed}: never less than {least_s:.1f} s to contact.",
        "no chance": f"no chance at {{speed}}: too near to stop when first known, in {_WHEN}.",
        "outside": f"outside the corridor when {{he}} becomes urgent at {{speed}}, in {_WHEN}.",
        "urgent": f"urgent at {{speed}}: the last chance to stop is {_WHEN}. {{responses:. }}.",
    },
    Ahead: {
        "share_in_time": "{letter!u} confirms the larger share in time",
        "mean_impact_kmh": "{letter!u} has the lower mean impact speed",
    },
    OverSpeed: {
        "share_in_time": "the share in time",
        "mean_impact_kmh": "the mean impact speed",
    },
    Equal: {
        "but": " but {n} of {n_all}, at which X and Y are equal",
        "addition": "; at {n} of {n_all} speeds X and Y are equal",
    },
    OrderOverSpeed: {
        "same": "{measure} of X and Y is the same at every speed.",
        "always": "{ahead} at every speed{equal}.",
        "once": "below {turns_kmh[0]:g} km/h {ahead}, from there on {second!u}{equal}.",
        "often": "{measure} turns {fact.n_turns} times: up to {turns_kmh[0]:g} km/h "
        "{ahead.letter!u} is ahead, and the order changes at {fact.turns_text} km/h{equal}.",
    },
}
