"""Measures that depend on what the driver sees, such as useful and redundant alerts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import (
    HIGHER,
    LOWER,
    AxisScale,
    Better,
    Condition,
    Inference,
    Measure,
    MeasureTable,
    Parts,
)
from nvcore.comparison.measures.values import per_recording
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.schema import integers_of
from nvcore.settings.stages import ENCOUNTERS, Stage
from nvcore.subjects.driver.comparison.in_time import is_in_time_alone, is_judged_in_time
from nvcore.subjects.driver.comparison.judging import split_unseen
from nvcore.subjects.driver.comparison.settings import DRIVER
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.time_left.settings import TIME_LEFT

KNOWN: Final = Condition(
    lambda result: result.dataset.each_alone or driver_in(result).has_any, "without detectability"
)
"""Condition: at least one near encounter has known detectability."""


def _is_detected(system: SystemResult) -> np.ndarray:
    is_detected: np.ndarray = system.encounters["is_detected"].to_numpy(dtype=bool)
    return is_detected


def _useful(result: Result, system: SystemResult) -> np.ndarray:
    useful: np.ndarray = driver_in(result).is_unseen & _is_detected(system)
    return useful


def _count(
    key: str,
    members: Callable[[Result, SystemResult], np.ndarray],
    label: str,
    better: Better,
    meaning: str,
    *,
    part: str = "",
    stages: tuple[Stage, ...] = (ENCOUNTERS, DRIVER),
    leads: bool = False,
    is_judged: Callable[[Result], np.ndarray] = lambda result: driver_in(result).is_known,
    empty_by_recording: str = "it is known of no encounter whether the driver sees it",
    inference: Inference | None = None,
) -> Measure:
    """Build a measure that counts encounters of a kind among those with known detectability."""

    def by_recording(result: Result, system: SystemResult) -> Any:
        is_member, recording = members(result, system), result.encounters.recording
        n_judged = per_recording(result, is_judged(result), recording)
        return integers_of(per_recording(result, is_member, recording), n_judged > 0)

    return Measure(
        key=key,
        label=label,
        part=part,
        form="d",
        better=better,
        stages=stages,
        is_worsened_by_alarms=False,
        leads=leads,
        of=lambda result, system: int(np.count_nonzero(members(result, system))),
        unit="encounters",
        meaning=meaning,
        by_recording=by_recording,
        tables=(MeasureTable.SCORECARD,),
        empty_by_recording=empty_by_recording,
        applies=lambda result: bool(is_judged(result).any()),
        only_if=KNOWN,
        inference=inference,
    )


_SHARE: Final = AxisScale(".0%", least=1.0, least_reach=1.0)

MEASURES: Final[tuple[Measure, ...]] = (
    _count(
        "useful_alerts",
        _useful,
        "useful alerts: detected, of {n_unseen:,} that the driver does not see",
        HIGHER,
        "Encounters that the system detects and the driver does not see unaided.",
        leads=True,
        inference=Inference(
            test="encounters",
            scale=_SHARE,
            label="share detected of {what} the driver does not see, within these recordings",
            form=".1%",
            split=lambda result: split_unseen(driver_in(result)),
            per="n_unseen",
            repeats="useful_alerts_by_unit",
            split_in_group="those that the driver does not see",
        ),
    ),
    Measure(
        key="useful_alerts_by_unit",
        label="share detected of {what} the driver does not see, by {units}",
        form=".1%",
        better=HIGHER,
        stages=(ENCOUNTERS, DRIVER),
        is_worsened_by_alarms=False,
        applies=KNOWN.holds,
        only_if=KNOWN,
        inference=Inference(
            test="units",
            scale=_SHARE,
            # 1 for each useful alert, in the first frame of its encounter
            parts=lambda result, system: Parts(
                result.encounters.first_row[_useful(result, system)], None
            ),
            per="n_unseen",
            noun="useful alerts (by the given detectability)",
        ),
    ),
    _count(
        "unprotected",
        lambda result, system: driver_in(result).is_unseen & ~_is_detected(system),
        "unprotected: seen by neither the driver nor the system",
        LOWER,
        "Encounters that the driver does not see unaided and the system does not detect.",
        part="unprotected: seen by neither driver nor system",
        leads=True,
    ),
    _count(
        "redundant_alerts",
        lambda result, system: driver_in(result).is_seen & _is_detected(system),
        "redundant alerts: detected, of {n_seen:,} that the driver sees",
        "",
        "Encounters that the system detects and the driver sees unaided, if not always while "
        "the car can still stop. Their number depends on {what} the driver sees, too.",
        part="redundant alerts: detected, seen by the driver anyway",
    ),
    _count(
        "in_time_alone",
        is_in_time_alone,
        "urgent, in time by it alone (not by driver or other system)",
        HIGHER,
        "Urgent encounters that the system confirmed in time, and neither the driver "
        "unaided nor the other system.",
        part="urgent, in time by it alone",
        stages=(TIME_LEFT, DRIVER),
        is_judged=is_judged_in_time,
        empty_by_recording="it is known of no urgent encounter whether the driver sees it",
    ),
)

COUNTS: Final = {
    "n_unseen": lambda result: driver_in(result).is_unseen,
    "n_seen": lambda result: driver_in(result).is_seen,
}
"""Populations of encounters that labels and shares refer to, bool, shape (n_encounters,)."""
