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
    Oracle: {
        "on": "alerts about {many} {whom} the driver has seen are held back, as a perfect driver "
        "monitor would: an oracle, which no system has.",
        "without effect": "the oracle has no effect, as it is not known whether the driver sees "
        "{a_one}.",
    },
}
