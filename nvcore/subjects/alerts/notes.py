"""Notes about alerts."""

from __future__ import annotations

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Measure
from nvcore.comparison.scoring import SystemResult
from nvcore.notes import Note, phrase
from nvcore.subjects.alerts.episodes import AlertKind
from nvcore.subjects.alerts.in_time import InTime
from nvcore.subjects.alerts.settings import ALERTS
from nvcore.subjects.alerts.steps import alerts_in
from nvcore.subjects.driver.comparison.notes import doubt_of_seen
from nvcore.subjects.time_left.steps import time_left_in


def alert_notes(result: Result) -> tuple[Note, ...]:
    """Return notes on both systems' alerts and on what is unknown, or none if alerts are off."""
    view = alerts_in(result)
    if not view.is_asked:
        return ()
    n_wanted = sum(len(view.rows_of_kind(system, AlertKind.WANTED)) for _, system in result.sides)
    notes = [alerts_of(result, letter, system) for letter, system in result.sides]
    notes += [Note("alerts.unknown_view", n=n_wanted)] if n_wanted and view.has_urgency else []
    if n_sampled := int(np.count_nonzero(result.dataset.frame_columns.sampling_step > 1)):
        notes.append(Note("alerts.sampled", n=n_sampled))
    if result.params.alert_oracle == "on":
        n_seen = int(time_left_in(result).is_urgent.sum()) - view.n_urgent
        is_known = result.dataset.has_detectability
        notes.append(Note("alerts.oracle", n=n_seen) if is_known else Note("alerts.no_oracle"))
    return tuple(notes)


def alerts_of(result: Result, letter: str, system: SystemResult) -> Note:
    """Return a system's number of alerts by kind, and of urgent encounters alerted in time."""
    view = alerts_in(result)
    counts = view.count(system).items()
    return Note(
        "alerts.of_system",
        system=letter,
        is_logged=view.is_logged(system),
        n=len(view.of(system)),
        kinds=[Note("alerts.of_kind", n=int(n), name=kind.value) for kind, n in counts if n > 0],
        n_in_time=int(view.in_time(system).sum()) if view.has_urgency else None,
        n_urgent=view.n_urgent,
    )


def in_time_by_kind(result: Result) -> tuple[Note, ...]:
    """Return the shares of urgent encounters with a reaction in time, by kind of alert.

    Empty if no encounter is urgent.
    """
    judged = alerts_in(result).in_time_for_drivers
    if judged.chances.empty:
        return ()
    shares = judged.table[judged.table["measure"] == "share"]
    means = shares.pivot_table("mean", "kind", "side", sort=False)
    kinds = [
        Note("alerts.share_of_kind", name=str(kind), x=row["x"], y=row["y"])
        for kind, row in means.iterrows()
    ]
    after_s = result.params.foot_s + result.params.brakes_s
    n_urgent = len(judged.chances)
    return (Note("alerts.in_time_by_kind", n_urgent=n_urgent, kinds=kinds, after_s=after_s),)


def doubt_of_kind(judged: InTime, name: str) -> Note:
    """Return the intervals of X - Y for a kind of alert: of the mean, and of another study."""
    table = judged.table[judged.table["measure"] == "share"]
    row = (table["kind"] == name) & (table["side"] == "difference")
    of = 100 * table[row].set_index(["kind", "measure", "side"]).iloc[0]
    is_of_mean = not np.isnan(of["units_low"])
    by = "units" if is_of_mean else "draws"
    return Note(
        "alerts.doubt_of_kind",
        name=name,
        difference=of["mean"],
        low=of[f"{by}_low"],
        high=of[f"{by}_high"],
        study_low=of["low"] if is_of_mean else None,
        study_high=of["high"] if is_of_mean else None,
        units=judged.what_varies,
    )


def doubt_of(result: Result, measure: Measure) -> str:
    """Return why the oracle prevents claims about a measure of alerts, or "" if it does not."""
    is_gated = ALERTS in measure.stages and result.params.alert_oracle == "on"
    why = doubt_of_seen(result) if is_gated and alerts_in(result).is_asked else None
    return phrase(why, result.objects) if why else ""
