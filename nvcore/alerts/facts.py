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
class AlertsOf(Fact):
    """The alerts of a system.

    Attributes
    ----------
    kind
        By the ``policy``, or as its own ``log`` has them; ``none``: it gives none.
    in_time, n_urgent
        Urgent encounters alerted in time, of so many.
    """

    kind: Literal["policy", "log", "none"]
    letter: str
    n: int
    kinds: tuple[OfKind, ...]
    in_time: int
    n_urgent: int


@dataclass(frozen=True)
class ViewUnknown(Fact):
    """That so many alerts are redundant or needed, as it is not known whether the driver sees."""

    n: int


@dataclass(frozen=True)
class Oracle(Fact):
    """That alerts are held back by what no system knows: an oracle; or that it has no effect."""

    kind: Literal["on", "without effect"]


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
    """What contributes more doubt to the difference in time of a kind of alert.

    Attributes
    ----------
    kind
        The ``drivers``, who react differently, or the ``recordings``; ``few``: too few of these to
        know.
    low, high
        Ends of the interval of X - Y in which both vary; of ``few`` that of the drivers.
    drivers, recordings
        Half the width of the interval of each alone. All in percentage points.
    """

    kind: Literal["drivers", "recordings", "few"]
    name: str
    difference: float
    low: float
    high: float
    drivers: float
    recordings: float


_TIME: Final = "; in time for {in_time} of {n_urgent!n:urgent encounter}."

TEXTS: Final[Texts] = {
    OfKind: "{n} {name}",
    AlertsOf: {
        "policy": f"{{letter!u}} gives {{n!n:alert}} ({{kinds:, }}){_TIME}",
        "log": f"{{letter!u}} gave {{n!n:alert}} by its own log ({{kinds:, }}){_TIME}",
        "none": f"{{letter!u}} gives no alert{_TIME}",
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
        kind: f"with {{name}} alerts X - Y is {{difference:+.0f}} percentage points (95 %: "
        f"{{low:+.0f}} to {{high:+.0f}}{of}). {why}"
        for kind, of, why in (
            (
                "drivers",
                "",
                "How drivers differ contributes more doubt (±{drivers:.0f}) than which recordings "
                "these are (±{recordings:.0f}): more recordings help less.",
            ),
            (
                "recordings",
                "",
                "Which recordings these are contributes more doubt (±{recordings:.0f}) than how "
                "drivers differ (±{drivers:.0f}): more recordings help.",
            ),
            (
                "few",
                ", other drivers alone",
                "The recordings are too few to know what others would give.",
            ),
        )
    },
    Oracle: {
        "on": "alerts about {many} {whom} the driver has seen are held back, as a perfect driver "
        "monitor would: an oracle, which no system has.",
        "without effect": "the oracle has no effect, as it is not known whether the driver sees "
        "{a_one}.",
    },
}
