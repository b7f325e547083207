"""The pipeline step that judges alerts, and the view of its results."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final, cast

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Condition
from nvcore.comparison.scoring import ScoringStep, SystemInputs, SystemResult
from nvcore.metrics.matching import Matches, match_system
from nvcore.metrics.proximity import Weights
from nvcore.settings.params import Params
from nvcore.subjects.alerts.episodes import (
    NO_ALERTS,
    RESTS_ON_DRIVER,
    UNWANTED,
    AlertKind,
    Reported,
    Scene,
    alerts_by_log,
    alerts_by_policy,
    inputs_of,
    policy_of,
)
from nvcore.subjects.alerts.settings import ALERTS
from nvcore.subjects.driver.comparison.in_time import is_driver_in_time
from nvcore.subjects.time_left.steps import time_left_in

if TYPE_CHECKING:
    from nvcore.subjects.alerts.in_time import InTime
    from nvcore.subjects.alerts.speeding import Speeding

MOST_POINTS: Final = 40
"""Most thresholds of a trade-off curve."""


def _find_alerts(
    at: SystemInputs,
    matches: Matches,
    weights: Weights,
    k_truth: Weights,
    urgency: pd.DataFrame,
    seen: pd.DataFrame,
) -> pd.DataFrame:
    if at.params.alerts == "off":
        return NO_ALERTS
    number, corridor = at.dataset.systems.index(at.name), float(at.params.corridor)
    scene = Scene(at.dataset, at.encounters, k_truth.k, urgency, seen, corridor)
    log = inputs_of(at.dataset).logs.get(number)
    if at.params.alerts == "log" and log is not None:
        whole = match_system(at.dataset, at.name, None, at.params)
        return alerts_by_log(scene, Reported(at.detections, weights.k, whole), log)
    policy = policy_of(at.params, at.dataset, number)
    reported = Reported(at.detections, weights.k, matches)
    return alerts_by_policy(scene, reported, policy, threshold=_in_use(at.threshold, policy))


def _in_use(threshold: float | None, policy: Params) -> float:
    """Return the higher of the comparison's score threshold and the policy's."""
    return max(-np.inf if value is None else value for value in (threshold, policy.alert_score))


STEPS: Final = (
    ScoringStep(
        "alerts",
        _find_alerts,
        (ALERTS,),
        ("matches", "weights", "k_truth", "urgency", "detectable"),
    ),
)


@dataclass(frozen=True, eq=False)
class AlertsView:
    """View of the alerts in a comparison, as returned by ``result.of("alerts")``."""

    result: Result

    @property
    def is_asked(self) -> bool:
        """Whether alerts are judged."""
        return bool(self.result.params.alerts != "off")

    def of(self, system: SystemResult) -> pd.DataFrame:
        """Return the alerts of a system, with the columns of `episodes.NO_ALERTS`."""
        return cast("pd.DataFrame", system.made["alerts"])

    def has_log(self, system: SystemResult) -> bool:
        """Whether a system has its own log of alerts."""
        number = self.result.dataset.systems.index(system.name)
        return number in inputs_of(self.result.dataset).logs

    def is_logged(self, system: SystemResult) -> bool:
        """Whether a system's alerts come from its own log."""
        return bool(self.result.params.alerts == "log" and self.has_log(system))

    def rows_of_kind(self, system: SystemResult, *kinds: AlertKind) -> np.ndarray:
        """Return the first frame row of each alert of these kinds, int64."""
        alerts = self.of(system)
        rows: np.ndarray = alerts["first_row"].to_numpy()[alerts["kind"].isin(kinds).to_numpy()]
        return rows

    @cached_property
    def knows_driver(self) -> bool:
        """Whether detectability is known for at least one encounter."""
        return bool((self.result.made["detectable"]["known_row"] >= 0).any())

    def count(self, system: SystemResult) -> dict[AlertKind, float]:
        """Count alerts of each kind, NaN for redundant and needed ones unless `knows_driver`."""
        return self._count(self.of(system))

    def _count(self, alerts: pd.DataFrame) -> dict[AlertKind, float]:
        counts = alerts["kind"].value_counts()
        undefined = () if self.knows_driver else RESTS_ON_DRIVER
        return {
            kind: np.nan if kind in undefined else int(counts.get(kind.value, 0))
            for kind in AlertKind
        }

    def first_alert(self, system: SystemResult) -> np.ndarray:
        """Return the frame row of each encounter's first alert, or -1 without one, int64, (n,)."""
        name = f"first alerts of {system.name}"
        return self.result.keep(name, lambda: self._first_alert(self.of(system)))

    def _first_alert(self, alerts: pd.DataFrame) -> np.ndarray:
        row = np.full(len(self.result.encounters), -1)
        first = alerts[alerts["encounter"] >= 0].drop_duplicates("encounter")
        row[first["encounter"]] = first["first_row"]
        return row

    def in_time(self, system: SystemResult) -> np.ndarray:
        """Return which of the encounters in `is_to_alert` are alerted in time, bool, shape (n,)."""
        return self._is_in_time(self.first_alert(system))

    def _is_in_time(self, row: np.ndarray) -> np.ndarray:
        last_chance = time_left_in(self.result).urgency["urgent_row"].to_numpy()
        in_time: np.ndarray = self.is_to_alert & (row >= 0) & (row < last_chance)
        return in_time

    @cached_property
    def is_to_alert(self) -> np.ndarray:
        """Urgent encounters in which a system should alert the driver, bool, shape (n_encounters,).

        The oracle suppresses alerts about pedestrians whom the driver sees. With it on, encounters
        that the driver sees in time are left out.
        """
        is_seen = is_driver_in_time(self.result) & (self.result.params.alert_oracle == "on")
        is_to_alert: np.ndarray = time_left_in(self.result).is_urgent & ~is_seen
        return is_to_alert

    def lead_s(self, system: SystemResult) -> np.ndarray:
        """Return the time from each urgent encounter's first alert to its last chance, seconds.

        More is better, 0 or less is too late; NaN unless urgent and alerted; float64, shape
        (n_encounters,). The last chance has the reaction time in it already.
        """
        time_left, frames = time_left_in(self.result), self.result.dataset.frame_columns
        row = self.first_alert(system)
        is_alerted = time_left.is_urgent & (row >= 0)
        first, last = row[is_alerted], time_left.urgency["urgent_row"].to_numpy()[is_alerted]
        lead_s = np.full(len(row), np.nan)
        rate = frames.fps[frames.recording[first]]
        lead_s[is_alerted] = (frames.frame[last] - frames.frame[first]) / rate
        return lead_s

    @cached_property
    def in_time_for_drivers(self) -> InTime:
        """Shares of urgent encounters in which drivers react in time (`in_time`)."""
        # imported here to avoid a cycle: it needs `nvcore.evidence`, which needs the measures,
        # which need this module
        from nvcore.subjects.alerts.in_time import REACTIONS, Reaction, judge_in_time

        params, reactions = self.result.params, dict(REACTIONS)
        if params.own_reaction_s is not None:
            own = Reaction(params.own_reaction_s, params.own_reaction_sd_s)
            reactions = {"own": own, **reactions}
        return judge_in_time(
            self.result,
            [self.first_alert(system) for _, system in self.result.sides],
            reactions=reactions,
            movement_s=params.foot_s,
            brakes_s=params.brakes_s,
        )

    @cached_property
    def speeding(self) -> Speeding | None:
        """Alerts of excessive speed, or None without speed signs or without a known speed."""
        from nvcore.subjects.alerts.speeding import has_limits, judge_speeding  # here: as above

        return judge_speeding(self.result) if has_limits(self.result.dataset) else None

    @cached_property
    def table(self) -> pd.DataFrame:
        """Alerts of X, then of Y, as in ``alerts.csv`` (docs/alerts.md)."""
        return pd.concat([*self._tables()], ignore_index=True)

    def _tables(self) -> Iterator[pd.DataFrame]:
        result = self.result
        frames, recordings = result.dataset.frame_columns, result.dataset.recordings["name"]
        time_s = result.dataset.frames["time_s"].to_numpy()
        for letter, system in result.sides:
            alerts, lead_s = self.of(system), self.lead_s(system)
            first, last = alerts["first_row"].to_numpy(), alerts["last_row"].to_numpy()
            encounter = alerts["encounter"].to_numpy()
            is_met = encounter >= 0
            is_first = is_met & ~alerts["encounter"].duplicated().to_numpy()
            told = alerts["encounter"][alerts["kind"].isin([AlertKind.NEEDED, AlertKind.WANTED])]
            whose, lead = np.full(len(alerts), None), np.full(len(alerts), np.nan)
            whose[is_met] = result.encounters.track[encounter[is_met]]
            lead[is_first] = lead_s[encounter[is_first]]
            yield pd.DataFrame(
                {
                    "system": letter,
                    "recording": recordings.to_numpy()[alerts["recording"]],
                    "start_frame": frames.frame[first],
                    "end_frame": frames.frame[last],
                    "start_s": time_s[first],
                    "duration_s": time_s[last] + frames.step_s[last] - time_s[first],
                    "track": alerts["track"].where(alerts["track"] >= 0).astype("Int64"),
                    "kind": alerts["kind"],
                    "encounter": pd.array(whose, dtype="Int64"),
                    "is_repeat": alerts.index.isin(told.index[told.duplicated()]),
                    "lead_s": lead,
                    "log_kind": alerts["log_kind"],
                }
            )

    @cached_property
    def curve(self) -> pd.DataFrame:
        """Encounters alerted in time and unwanted alerts at each score threshold.

        The rest of the policy is unchanged. Thresholds go down to the lowest score that the system
        reports, whatever the threshold of the comparison.

        Returns
        -------
        Rows of X, then of Y, each with the threshold ascending: system (``x`` or ``y``), of
        (``policy``; ``in use``: at the current threshold; ``log``: from the log), threshold (-inf:
        every box; NaN for a log), alerts of each `AlertKind` (its name; NaN as in `count`),
        unwanted and unwanted_per_hour (fewer is better), in_time (urgent encounters alerted in
        time, more is better), share_in_time (NaN: none is urgent), alerted (encounters that count).
        """
        rows = [
            {"system": letter, **self._point(alerts), "of": of, "threshold": threshold}
            for letter, system in self.result.sides
            for of, threshold, alerts in self._points(system)
        ]
        first = ("system", "of", "threshold")
        return pd.DataFrame(
            rows, columns=[*first, *(name for name in rows[0] if name not in first)]
        )

    def _points(self, system: SystemResult) -> Iterator[tuple[str, float, pd.DataFrame]]:
        result, params = self.result, self.result.params
        dataset, made = result.dataset, result.made
        truth = made["urgency"], made["detectable"], float(params.corridor)
        scene = Scene(dataset, result.encounters, result.k_truth.k, *truth)
        matches = match_system(dataset, system.name, None, params)
        reported = Reported(dataset.system(system.name), system.weights.k, matches)
        policy = policy_of(params, dataset, dataset.systems.index(system.name))
        # a loop over thresholds, because linked boxes and pauses differ at each
        for threshold in thresholds_of(reported.boxes.score):
            yield (
                "policy",
                threshold,
                alerts_by_policy(scene, reported, policy, threshold=threshold),
            )
        in_use = _in_use(system.threshold, policy)
        yield "in use", in_use, alerts_by_policy(scene, reported, policy, threshold=in_use)
        if self.is_logged(system):
            yield "log", np.nan, self.of(system)

    def _point(self, alerts: pd.DataFrame) -> dict[str, float]:
        counts, row = self._count(alerts), self._first_alert(alerts)
        hours, n_urgent = self.result.duration_s / 3600, self.n_urgent
        n_unwanted = int(alerts["kind"].isin(UNWANTED).sum())
        in_time = int(np.count_nonzero(self._is_in_time(row)))
        return {
            **{kind.value: n for kind, n in counts.items()},
            "unwanted": n_unwanted,
            "unwanted_per_hour": n_unwanted / hours if hours else np.nan,
            "in_time": in_time,
            "share_in_time": in_time / n_urgent if n_urgent else np.nan,
            "alerted": int(np.count_nonzero(self.result.is_near & (row >= 0))),
        }

    @property
    def n_urgent(self) -> int:
        """Number of encounters in `is_to_alert`."""
        return int(np.count_nonzero(self.is_to_alert))

    @property
    def has_urgency(self) -> bool:
        """Whether objects can be urgent because a car could hit them. Speed signs cannot."""
        return self.result.dataset.objects.is_on_road


def thresholds_of(score: np.ndarray) -> list[float]:
    """Return at most `MOST_POINTS` thresholds for a curve: -inf, then scores that occur."""
    known = np.unique(score[~np.isnan(score)])[1:]  # at the least of all every box is there
    if len(known) > MOST_POINTS - 1:
        known = known[np.linspace(0, len(known) - 1, MOST_POINTS - 1).round().astype(int)]
    return [-np.inf, *known.tolist()]


def alerts_in(result: Result) -> AlertsView:
    """Return the view of the alerts in a comparison, like ``result.of("alerts")``."""
    return cast("AlertsView", result.of("alerts"))


ASKED: Final = Condition(lambda result: alerts_in(result).is_asked, "where `alerts` is off")
"""Condition: alerts are judged."""
OF_URGENCY: Final = Condition(
    lambda result: ASKED.holds(result) and alerts_in(result).has_urgency,
    "where `alerts` is off, and of objects that are not on the road",
)
"""Condition: alerts are judged, and can come in time."""
