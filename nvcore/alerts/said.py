"""What there is to say of alerts."""

from __future__ import annotations

from typing import Literal

import numpy as np

from nvcore.alerts.facts import (
    AlertsOf,
    InTimeByKind,
    MoreDoubt,
    OfKind,
    Oracle,
    ShareOfKind,
    ViewUnknown,
)
from nvcore.alerts.in_time import InTime
from nvcore.alerts.kinds import AlertKind
from nvcore.alerts.settings import ALERTS
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.driver.comparison.doubts import doubt_of_seen
from nvcore.measures.entry import Measure
from nvcore.scoring import SystemResult
from nvcore.sentences import phrase
from nvcore.sentences.facts import Fact


def alert_facts(result: Result) -> tuple[Fact, ...]:
    """The alerts of both systems, and what is not known of them; none: alerts are not judged."""
    if not alerts_in(result).is_asked:
        return ()
    of_systems = (alerts_of(result, letter, system) for letter, system in result.sides)
    return (*of_systems, *notes(result))


def alerts_of(result: Result, letter: str, system: SystemResult) -> AlertsOf:
    """The alerts of a system by kind, and how many urgent encounters they are in time for."""
    view = alerts_in(result)
    counts = view.count(system)
    kinds = tuple(OfKind(kind.value, n) for kind, n in counts.items() if n)
    in_time, n_urgent = int(view.in_time(system).sum()), view.n_urgent
    origin: Literal["log", "policy"] = "log" if view.is_logged(system) else "policy"
    return AlertsOf(
        origin if kinds else "none", letter, sum(counts.values()), kinds, in_time, n_urgent
    )


def notes(result: Result) -> tuple[Fact, ...]:
    """What is not known of the alerts, and whether an oracle holds some back."""
    view = alerts_in(result)
    n_wanted = sum(view.count(system)[AlertKind.WANTED] for _, system in result.sides)
    facts: list[Fact] = [ViewUnknown(n_wanted)] if n_wanted else []
    if result.params.alert_oracle == "on":
        facts.append(Oracle("on" if result.dataset.has_detectability else "without effect"))
    return tuple(facts)


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
    """What contributes more doubt to the difference in time of a kind of alert."""
    keys = judged.table[["kind", "measure", "side"]].agg(tuple, axis=1)
    columns = [
        "mean",
        "draws_low",
        "draws_high",
        "recordings_low",
        "recordings_high",
        "low",
        "high",
    ]
    row = 100 * judged.table.loc[keys == (name, "share", "difference"), columns].iloc[0]
    drivers, recordings = (
        (row[f"{of}_high"] - row[f"{of}_low"]) / 2 for of in ("draws", "recordings")
    )
    if np.isnan(recordings):
        ends = row["draws_low"], row["draws_high"]
        return MoreDoubt("few", name, row["mean"], *ends, drivers, recordings)
    kind: Literal["drivers", "recordings"] = "drivers" if drivers > recordings else "recordings"
    return MoreDoubt(kind, name, row["mean"], row["low"], row["high"], drivers, recordings)


def doubt_of(result: Result, measure: Measure) -> str:
    """Why no claim can rest on a measure of alerts that an oracle holds back; empty: none does."""
    is_gated = ALERTS in measure.stages and result.params.alert_oracle == "on"
    why = doubt_of_seen(result) if is_gated and alerts_in(result).is_asked else None
    return phrase(why, result.objects) if why else ""
