"""Additions of time left to a comparison: its steps, and a view of their results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, cast

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import Inputs, ScoringStep, SystemInputs, SystemResult
from nvcore.metrics.matching import Matches
from nvcore.subjects.time_left.judging import (
    Contact,
    Judgement,
    confirm,
    curve_over_speed,
    find_urgent,
    measure_contact,
)
from nvcore.subjects.time_left.kinds import TimeLeft, Urgency
from nvcore.subjects.time_left.settings import CONFIRMED, CONTACT, TIME_LEFT, URGENCY


def _measure_contact(at: Inputs) -> Contact:
    return measure_contact(
        at.truth,
        at.encounters,
        at.frames,
        ttc_window=at.params.ttc_window,
        is_on_road=at.dataset.objects.is_on_road,
    )


def _find_urgent(at: Inputs, contact: Contact) -> pd.DataFrame:
    return find_urgent(contact, at.truth, at.encounters, at.frames, at.params)


def _confirm(at: SystemInputs, contact: Contact, matches: Matches) -> pd.DataFrame:
    return confirm(contact, at.encounters, matches.is_matched, at.params)


def _judge(at: SystemInputs, urgency: pd.DataFrame, confirmed: pd.DataFrame) -> Judgement:
    return Judgement(urgency, confirmed, at.frames, at.params)


STEPS: Final = (
    ScoringStep("contact", _measure_contact, (CONTACT,), of="truth"),
    ScoringStep("urgency", _find_urgent, (URGENCY,), ("contact",), of="truth"),
    ScoringStep("confirmed", _confirm, (CONTACT, CONFIRMED), ("contact", "matches")),
    ScoringStep("time_left", _judge, (TIME_LEFT,), ("urgency", "confirmed")),
)


def only_urgent_of(made: Mapping[str, Any], is_member: np.ndarray) -> dict[str, Any]:
    """Return the step results with only these encounters urgent."""
    urgency = made["urgency"]
    kinds = np.where(is_member, urgency["urgency"], Urgency.NOT_URGENT.value)
    return {"urgency": urgency.assign(urgency=kinds)}


def confirmed_by(system: SystemResult) -> pd.DataFrame:
    """Return a system's confirmation of each pedestrian (`judging.confirm`)."""
    return cast("pd.DataFrame", system.made["confirmed"])


def time_left_of(system: SystemResult) -> pd.DataFrame:
    """Return a system's time left (`nvcore.subjects.time_left.judging.judge_time_left`)."""
    return cast("Judgement", system.made["time_left"]).time_left


def is_in_time(system: SystemResult) -> np.ndarray:
    """Return which urgent encounters the system confirmed in time, bool, (n_encounters,)."""
    return is_of_class(system, TimeLeft.IN_TIME)


def count_time_left(system: SystemResult, kind: TimeLeft) -> int:
    """Count the urgent encounters of a class."""
    return int(np.count_nonzero(is_of_class(system, kind)))


def is_of_class(system: SystemResult, kind: TimeLeft) -> np.ndarray:
    """Return which encounters are urgent ones of a class, bool, shape (n_encounters,)."""
    is_kind: np.ndarray = time_left_of(system)["time_left"].to_numpy() == kind.value
    return is_kind


@dataclass(frozen=True, eq=False)
class TimeLeftView:
    """Time left in a comparison."""

    result: Result

    @property
    def contact(self) -> Contact:
        """Time to contact of every truth box (`judging.measure_contact`)."""
        return cast("Contact", self.result.made["contact"])

    @property
    def urgency(self) -> pd.DataFrame:
        """Urgency of each encounter and its start (`judging.find_urgent`)."""
        return cast("pd.DataFrame", self.result.made["urgency"])

    @cached_property
    def is_urgent(self) -> np.ndarray:
        """Encounters in which the driver needed a timely warning, bool, shape (n_encounters,)."""
        urgent: np.ndarray = self.urgency["urgency"].to_numpy() == Urgency.URGENT.value
        return urgent

    def count_urgency(self) -> dict[Urgency, int]:
        """Count the encounters of each urgency."""
        return {kind: int((self.urgency["urgency"] == kind.value).sum()) for kind in Urgency}

    @property
    def has_assumed_speed(self) -> np.ndarray:
        """Recordings with frames without a stated speed, bool, shape (n_recordings,)."""
        frames = self.result.dataset.frame_columns
        of_unknown = frames.recording[np.isnan(frames.speed_kmh)]
        is_assumed: np.ndarray = np.bincount(of_unknown, minlength=len(frames.fps)) > 0
        return is_assumed

    @property
    def assumed_speed_kmh(self) -> float | None:
        """Speed assumed in all frames, or None if some recordings state their own."""
        is_assumed = np.isnan(self.result.dataset.frame_columns.speed_kmh).all()
        return float(self.result.params.speed_kmh) if is_assumed else None

    @cached_property
    def over_speed(self) -> pd.DataFrame:
        """Time left of both over the car's speed (`judging.curve_over_speed`)."""
        result = self.result
        return curve_over_speed(
            self.contact,
            result.dataset.truth,
            result.encounters,
            [confirmed_by(system) for _, system in result.sides],
            result.dataset.frame_columns,
            result.params,
        )


def time_left_in(result: Result) -> TimeLeftView:
    """Return the view of time left in a comparison, as ``result.of("time_left")`` does."""
    return cast("TimeLeftView", result.of("time_left"))
