"""Measures of time left: urgent pedestrians confirmed in time, and impact speeds of the others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import (
    HIGHER,
    LOWER,
    AxisScale,
    Better,
    Inference,
    Measure,
    MeasureTable,
    Parts,
)
from nvcore.comparison.measures.values import per_recording
from nvcore.comparison.scoring import SystemResult
from nvcore.metrics.venn import Venn, categorise, count_categories
from nvcore.subjects.time_left.kinds import TimeLeft
from nvcore.subjects.time_left.settings import TIME_LEFT
from nvcore.subjects.time_left.steps import (
    count_time_left,
    is_in_time,
    is_of_class,
    time_left_in,
    time_left_of,
)

_NOBODY: Final = "no encounter is urgent"


def time_left_by_recording(kind: TimeLeft) -> Callable[[Result, SystemResult], np.ndarray]:
    """Return a function that counts a class of urgent encounters by recording, (n_recordings,)."""

    def counts(result: Result, system: SystemResult) -> np.ndarray:
        return per_recording(result, is_of_class(system, kind), result.encounters.recording).astype(
            np.int64
        )

    return counts


def split_in_time(result: Result) -> Venn:
    """Count urgent encounters by the systems that confirmed them in time.

    All other encounters count as distant.
    """
    is_urgent = time_left_in(result).is_urgent
    x, y = (is_in_time(system) & is_urgent for _, system in result.sides)
    return count_categories(categorise(~is_urgent, x, y))


def in_time_parts(result: Result, system: SystemResult) -> Parts:
    """Return the urgent encounters that the system confirmed in time."""
    is_part = time_left_in(result).is_urgent & is_in_time(system)
    return Parts(result.encounters.first_row[is_part], None)


def impact_parts(result: Result, system: SystemResult) -> Parts:
    """Return the impact speed of each urgent encounter, km/h."""
    is_urgent = time_left_in(result).is_urgent
    impact_kmh = time_left_of(system)["impact_kmh"].to_numpy()
    return Parts(result.encounters.first_row[is_urgent], impact_kmh[is_urgent])


def impact_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    """Return the mean impact speed of each recording's urgent encounters, km/h, NaN without any."""
    is_urgent, recording = time_left_in(result).is_urgent, result.encounters.recording
    impact_kmh = np.where(is_urgent, time_left_of(system)["impact_kmh"], 0.0)
    with np.errstate(invalid="ignore"):
        mean: np.ndarray = per_recording(result, impact_kmh, recording) / per_recording(
            result, is_urgent, recording
        )
    return mean


def has_urgent(result: Result) -> bool:
    """Whether any encounter is urgent."""
    return bool(time_left_in(result).is_urgent.any())


def _median_margin_s(result: Result, system: SystemResult) -> float:
    margins_s = [time_left_of(side)["margin_s"].to_numpy() for _, side in result.sides]
    is_confirmed_by_both = ~np.isnan(margins_s).any(axis=0)
    margin_s = time_left_of(system)["margin_s"].to_numpy()[is_confirmed_by_both]
    return float(np.median(margin_s)) if len(margin_s) else np.nan


def _count(
    kind: TimeLeft, label: str, better: Better, meaning: str, inference: Inference | None = None
) -> Measure:
    """Create the measure of the number of urgent encounters of a class."""
    return Measure(
        key=kind.value,
        label=label,
        part="" if inference else label,
        form="d",
        better=better,
        stages=(TIME_LEFT,),
        is_worsened_by_alarms=False,
        leads=kind is TimeLeft.IN_TIME,
        of=lambda _, system: count_time_left(system, kind),
        unit="encounters",
        meaning=meaning,
        by_recording=time_left_by_recording(kind),
        tables=(MeasureTable.SCORECARD,),
        applies=has_urgent,
        inference=inference,
    )


MEASURES: Final[tuple[Measure, ...]] = (
    _count(
        TimeLeft.IN_TIME,
        "urgent encounters in time, of {n_urgent}",
        HIGHER,
        "Urgent encounters that the system confirmed while the car could still stop.",
        Inference(
            test="encounters",
            scale=AxisScale(".0%", least=1.0, least_reach=1.0),
            label="share of urgent encounters in time, within these recordings",
            form=".1%",
            split=split_in_time,
            per="n_urgent",
            needs_tracks=True,
            repeats="in_time_by_unit",
            split_in_group="the urgent ones, by who confirms them in time",
        ),
    ),
    Measure(
        key="in_time_by_unit",
        label="share of urgent encounters in time, by {units}",
        form=".1%",
        better=HIGHER,
        stages=(TIME_LEFT,),
        is_worsened_by_alarms=False,
        applies=has_urgent,
        inference=Inference(
            test="units",
            scale=AxisScale(".0%", least=1.0, least_reach=1.0),
            parts=in_time_parts,
            per="n_urgent",
            noun="urgent encounters in time",
            needs_tracks=True,
        ),
    ),
    _count(
        TimeLeft.LATE,
        "confirmed too late",
        LOWER,
        "Urgent encounters that it confirmed when the car could no longer stop.",
    ),
    _count(TimeLeft.NEVER, "never confirmed", LOWER, "Urgent encounters that it never confirmed."),
    Measure(
        key="mean_impact_kmh",
        label="mean impact speed (km/h)",
        form=".1f",
        better=LOWER,
        stages=(TIME_LEFT,),
        is_worsened_by_alarms=False,
        of=lambda _, system: float(time_left_of(system)["impact_kmh"].mean()),
        unit="km/h",
        meaning="Mean speed with which the car reaches the {many} of all urgent encounters: 0 "
        "if confirmed in time, its full speed if never.",
        empty=_NOBODY,
        by_recording=impact_by_recording,
        tables=(MeasureTable.SCORECARD,),
        applies=has_urgent,
        inference=Inference(
            test="units",
            scale=AxisScale(".1f", least=1.0, least_reach=1.0, unit="km/h"),
            parts=impact_parts,
            per="n_urgent",
            noun="mean impact speed",
            noun_unit=" km/h",
            needs_tracks=True,
        ),
    ),
    Measure(
        key="median_margin_s",
        label="median margin, where both confirm (s)",
        form=".2f",
        better="",  # the median says nothing of those confirmed too late
        stages=(TIME_LEFT,),
        is_worsened_by_alarms=False,
        of=_median_margin_s,
        unit="s",
        meaning="Median time from confirmation to the last chance, of the urgent encounters that "
        "both systems confirmed; negative: too late.",
        empty=f"{_NOBODY}, or both systems confirmed none of them",
        tables=(MeasureTable.SCORECARD,),
        applies=has_urgent,
    ),
)

COUNTS: Final = {"n_urgent": lambda result: time_left_in(result).is_urgent}
"""Encounters used as denominators of measures and in labels, bool, shape (n_encounters,)."""
