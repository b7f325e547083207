"""What there is to say of alerts."""

from __future__ import annotations

from typing import Literal

import numpy as np

from nvcore.alerts.facts import (
    AlertedInTime,
    AlertsOf,
    InTimeByKind,
    MoreDoubt,
    OfKind,
    Oracle,
    Sampled,
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
from nvcore.time_left.steps import time_left_in


def alert_facts(result: Result) -> tuple[Fact, ...]:
    """The alerts of both systems, and what is not known of them; none: alerts are not judged."""
    view = alerts_in(result)
    if not view.is_asked:
        return ()
    n_wanted = sum(len(view.rows_of_kind(system, AlertKind.WANTED)) for _, system in result.sides)
    facts: list[Fact] = [alerts_of(result, letter, system) for letter, system in result.sides]
    facts += [ViewUnknown(n_wanted)] if n_wanted and view.has_urgency else []
    if n_sampled := int(np.count_nonzero(result.dataset.frame_columns.sampling_step > 1)):
        facts.append(Sampled(n_sampled))
    if result.params.alert_oracle == "on":
        n_seen = int(time_left_in(result).is_urgent.sum()) - view.n_urgent
        has_effect = result.dataset.has_detectability
        facts.append(Oracle("on" if has_effect else "without effect", n_seen))
    return tuple(facts)


def alerts_of(result: Result, letter: str, system: SystemResult) -> AlertsOf:
    """The alerts of a system by kind, and how many urgent encounters they are in time for."""
    view, n = alerts_in(result), len(alerts_in(result).of(system))
    counts = view.count(system).items()
    kinds = tuple(OfKind(kind.value, int(of_kind)) for kind, of_kind in counts if of_kind > 0)
    in_time = AlertedInTime(int(view.in_time(system).sum()), view.n_urgent)
    origin: Literal["log", "policy"] = "log" if view.is_logged(system) else "policy"
    said_of = in_time if view.has_urgency else None
    return AlertsOf(origin if n else "none", letter, n, kinds, said_of)


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
