"""What alerts have to say in every medium, as facts, and how they are said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from nvcore.sentences.facts import Fact
from nvcore.sentences.texts import Texts


@dataclass(frozen=True)
class OfKind(Fact):
    """Alerts of a kind."""

    name: str
    n: int


@dataclass(frozen=True)
class AlertedInTime(Fact):
    """Urgent encounters alerted in time, of so many."""

    n: int
    n_urgent: int


@dataclass(frozen=True)
class AlertsOf(Fact):
    """The alerts of a system.

    Attributes
    ----------
    kind
        By the ``policy``, or as its own ``log`` has them; ``none``: it gives none.
    in_time
        How many it is in time for; None for objects that are never urgent.
    """

    kind: Literal["policy", "log", "none"]
    letter: str
    n: int
    kinds: tuple[OfKind, ...]
    in_time: AlertedInTime | None


@dataclass(frozen=True)
class ViewUnknown(Fact):
    """That so many alerts are redundant or needed, as it is not known whether the driver sees."""

    n: int


@dataclass(frozen=True)
class Oracle(Fact):
    """That alerts are held back by what no system knows: an oracle; or that it has no effect.

    `n_seen` urgent encounters are left out, as the driver sees them in time without an alert.
    """

    kind: Literal["on", "without effect"]
    n_seen: int


@dataclass(frozen=True)
class ShareOfKind(Fact):
    """The shares of urgent encounters in which a kind of alert is in time, with X and with Y."""

    name: str
    x: float
    y: float


@dataclass(frozen=True)
class InTimeByKind(Fact):
    """How often drivers react in time, by kind of alert; `after_s` for the foot and the brakes.

    Without these (``bare``) it is optimistic.
    """

    kind: Literal["bare", "whole"]
    after_s: float
    n_urgent: int
    kinds: tuple[ShareOfKind, ...]


@dataclass(frozen=True)
class MoreDoubt(Fact):
    """How much doubt of a kind of alert's difference is of the drivers, how much of the units.

    Attributes
    ----------
    kind
        Whether the units are ``enough`` to know, or too ``few``.
    low, high
        Ends of the interval of X - Y in which both vary; of ``few`` that of the drivers.
    drivers, of_units
        Half the width of the interval of each alone. All in percentage points.
    units
        What they are, such as ``recordings``.
    """

    kind: Literal["enough", "few"]
    name: str
    difference: float
    low: float
    high: float
    drivers: float
    of_units: float
    units: str


@dataclass(frozen=True)
class Sampled(Fact):
    """That not every frame of some recordings is evaluated, so that alerts are of single ones."""

    n: int


_DIFFERENCE: Final = (
    "with {name} alerts X - Y is {difference:+.0f} percentage points (95 %: {low:+.0f} to "
    "{high:+.0f}"
)

TEXTS: Final[Texts] = {
    OfKind: "{n} {name}",
    AlertedInTime: "; in time for {n} of {n_urgent!n:urgent encounter}",
    AlertsOf: {
        "policy": "{letter!u} gives {n!n:alert} ({kinds:, }){in_time}.",
        "log": "{letter!u} gave {n!n:alert} by its own log ({kinds:, }){in_time}.",
        "none": "{letter!u} gives no alert{in_time}.",
    },
    ViewUnknown: "of {n!n:wanted alert} it is not known whether the driver had seen the {one}: "
    "redundant and needed ones are one kind there.",
    ShareOfKind: "{name} {x:.0%} and {y:.0%}",
    InTimeByKind: {
        kind: f"of {{n_urgent!n:urgent encounter}}, drivers brake in time with X and with Y in: "
        f"{{kinds:, }}. Reaction times are those of a tap with the hand{after}."
        for kind, after in (
            ("bare", ", and no time is added for foot and brakes: optimistic"),
            ("whole", "; {after_s:g} s are added for foot and brakes"),
        )
    },
    MoreDoubt: {
        "enough": f"{_DIFFERENCE}): ±{{drivers:.0f}} as drivers differ, ±{{of_units:.0f}} as "
        "{units} do.",
        "few": f"{_DIFFERENCE}, other drivers alone). The {{units}} with urgent encounters are too "
        "few to know what others would give.",
    },
    Sampled: "of {n!n:recording} not every frame is evaluated: alerts between these frames are "
    "unknown, and so is how long an alert lasts.",
    Oracle: {
        "on": "alerts about {many} {whom} the driver has seen are held back, as a perfect driver "
        "monitor would: an oracle, which no system has. The driver sees {n_seen!n:urgent encounter}"
        " in time without an alert: left out of what counts as in time or not.",
        "without effect": "the oracle has no effect, as it is not known whether the driver sees "
        "{a_one}.",
    },
}
