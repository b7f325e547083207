"""Messages about alerts: facts, their templates, and which facts hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from nvcore.alerts.episodes import AlertKind
from nvcore.alerts.in_time import InTime
from nvcore.alerts.settings import ALERTS
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.driver.comparison.doubts import doubt_of_seen
from nvcore.measures.entry import Measure
from nvcore.scoring import SystemResult
from nvcore.sentences import phrase
from nvcore.sentences.facts import Fact
from nvcore.sentences.texts import Texts
from nvcore.time_left.steps import time_left_in


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
class Doubt(Fact):
    """What is not known of alerts, or rests on what no system knows.

    Attributes
    ----------
    kind
        ``view``: whether the driver sees those whom `n` wanted alerts are about; ``sampled``: what
        happens between the evaluated frames of `n` recordings; ``oracle``: alerts are held back,
        and `n` urgent encounters left out, as the driver sees them; ``no oracle``: no effect.
    """

    kind: Literal["view", "sampled", "oracle", "no oracle"]
    n: int


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
    Doubt: {
        "view": "of {n!n:wanted alert} it is not known whether the driver had seen the {one}: "
        "redundant and needed ones are one kind there.",
        "sampled": "of {n!n:recording} not every frame is evaluated: alerts between these frames "
        "are unknown, and so is how long an alert lasts.",
        "oracle": "alerts about {many} {whom} the driver has seen are held back, as a perfect "
        "driver monitor would: an oracle, which no system has. The driver sees {n!n:urgent "
        "encounter} in time without an alert: left out of what counts as in time or not.",
        "no oracle": "the oracle has no effect, as it is not known whether the driver sees "
        "{a_one}.",
    },
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
}


def alert_facts(result: Result) -> tuple[Fact, ...]:
    """The alerts of both systems, and what is not known of them; none: alerts are not judged."""
    view = alerts_in(result)
    if not view.is_asked:
        return ()
    n_wanted = sum(len(view.rows_of_kind(system, AlertKind.WANTED)) for _, system in result.sides)
    facts: list[Fact] = [alerts_of(result, letter, system) for letter, system in result.sides]
    facts += [Doubt("view", n_wanted)] if n_wanted and view.has_urgency else []
    if n_sampled := int(np.count_nonzero(result.dataset.frame_columns.sampling_step > 1)):
        facts.append(Doubt("sampled", n_sampled))
    if result.params.alert_oracle == "on":
        n_seen = int(time_left_in(result).is_urgent.sum()) - view.n_urgent
        facts.append(Doubt("oracle" if result.dataset.has_detectability else "no oracle", n_seen))
    return tuple(facts)


def alerts_of(result: Result, letter: str, system: SystemResult) -> AlertsOf:
    """The alerts of a system by kind, and how many urgent encounters they are in time for."""
    view, n = alerts_in(result), len(alerts_in(result).of(system))
    counts = view.count(system).items()
    kinds = tuple(OfKind(kind.value, int(of_kind)) for kind, of_kind in counts if of_kind > 0)
    n_in_time = int(view.in_time(system).sum())
    in_time = AlertedInTime(n_in_time, view.n_urgent) if view.has_urgency else None
    origin: Literal["log", "policy"] = "log" if view.is_logged(system) else "policy"
    return AlertsOf(origin if n else "none", letter, n, kinds, in_time)


def in_time_by_kind(result: Result) -> tuple[InTimeByKind, ...]:
    """How often drivers react in time, by kind of alert; empty: nobody is urgent."""
    judged = alerts_in(result).in_time_for_drivers
    if judged.chances.empty:
        return ()
    shares = judged.table[judged.table["measure"] == "share"]
    means = shares.pivot_table("mean", "kind", "side", sort=False)
    kinds = tuple(ShareOfKind(str(kind), row["x"], row["y"]) for kind, row in means.iterrows())
    after_s = result.params.foot_s + result.params.brakes_s
    whole: Literal["bare", "whole"] = "whole" if after_s else "bare"
    return (InTimeByKind(whole, after_s, len(judged.chances), kinds),)


def more_doubt(judged: InTime, name: str) -> MoreDoubt:
    """How much doubt of a kind of alert's difference in time is of drivers, and of units."""
    table = judged.table[judged.table["measure"] == "share"]
    row = (table["kind"] == name) & (table["side"] == "difference")
    of = 100 * table[row].set_index(["kind", "measure", "side"]).iloc[0]
    drivers, units = ((of[f"{by}_high"] - of[f"{by}_low"]) / 2 for by in ("draws", "units"))
    kind: Literal["enough", "few"] = "few" if np.isnan(units) else "enough"
    low, high = ("draws_low", "draws_high") if kind == "few" else ("low", "high")
    return MoreDoubt(kind, name, of["mean"], of[low], of[high], drivers, units, judged.what_varies)


def doubt_of(result: Result, measure: Measure) -> str:
    """Why no claim can rest on a measure of alerts that an oracle holds back; empty: none does."""
    is_gated = ALERTS in measure.stages and result.params.alert_oracle == "on"
    why = doubt_of_seen(result) if is_gated and alerts_in(result).is_asked else None
    return phrase(why, result.objects) if why else ""
