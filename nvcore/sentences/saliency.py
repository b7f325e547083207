"""How a system's saliency comes about: facts, and how they are said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from nvcore.sentences.facts import Fact
from nvcore.sentences.texts import Texts


@dataclass(frozen=True)
class Weight(Fact):
    """What an event weighs, or all of them, weighted distance summed over time, s."""

    kind: Literal["one", "all"]
    weight_s: float


@dataclass(frozen=True)
class End(Fact):
    """When an event ends: seconds before the end of its scope, or the share that has passed."""

    kind: Literal["seconds", "share"]
    at: float
    scope: Literal["encounter", "recording"]


@dataclass(frozen=True)
class Event(Fact):
    """The largest event: its weight times its recency is its saliency, s.

    Attributes
    ----------
    weight_s
        What recency multiplies: the duration, or else what `weight` says.
    """

    duration_s: float
    weight: Weight | None
    end: End
    recency: float
    weight_s: float
    saliency_s: float


@dataclass(frozen=True)
class Sum(Fact):
    """All events of a system; the saliency of a recording is their sum.

    Attributes
    ----------
    saliency_s
        Of all recordings together.
    """

    duration_s: float
    weight: Weight | None
    saliency_s: float


@dataclass(frozen=True)
class OnAverage(Fact):
    """Mean over recordings, s."""

    mean_s: float


@dataclass(frozen=True)
class Relevance(Fact):
    """In which share of the events' time the object missed is near enough to count (k >= 0.5)."""

    kind: Literal["all", "part"]
    share: float


@dataclass(frozen=True)
class SaliencyOf(Fact):
    """How the saliency of a system comes about.

    Attributes
    ----------
    kind
        There is no event (``none``); it is the ``sum`` of all events, the ``largest``, or that in
        the ``mean`` over recordings.
    """

    kind: Literal["none", "sum", "largest", "mean"]
    letter: str
    n: int = 0
    event: Event | Sum | None = None
    mean: OnAverage | None = None
    relevance: Relevance | None = None


TEXTS: Final[Texts] = {
    Weight: {
        "one": ", weighs {weight_s:.2f} s (weighted distance summed over time)",
        "all": ", which weigh {weight_s:.2f} s",
    },
    End: {
        "seconds": "ends {at:.1f} s before the end of the {scope}",
        "share": "ends when {at!p} of the {scope} has passed",
    },
    Event: "lasts {duration_s:.2f} s{weight} and {end}, which gives it the recency {recency:.2f}: "
    "{weight_s:.2f} s × {recency:.2f} = {saliency_s:.2f} s.",
    Sum: "{duration_s:.1f} s in all{weight}; weighted by recency and added they make "
    "{saliency_s:.2f} s",
    OnAverage: ", {mean_s:.2f} s a recording",
    Relevance: {
        "all": " The missed {many} count (k >= 0.5) throughout.",
        "part": " In {share!p} of the events' time the missed {one} counts (k >= 0.5); in the "
        "rest {he} is too far to count.",
    },
    SaliencyOf: {
        "none": "{letter!u} misses {nobody} by more than the tolerance: its saliency is 0.",
        "sum": "{letter!u}: {n!n:event}, {event}{mean}.{relevance}",
        "largest": "{letter!u}: the most salient of {n!n:event} {event}{relevance}",
        "mean": "{letter!u}: {n!n:event}. The largest of each recording makes "
        "{fact.mean.mean_s:.2f} s on average; the largest of all {event}{relevance}",
    },
}
