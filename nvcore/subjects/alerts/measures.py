"""Measures of alerts: number of each kind, and encounters that are alerted in time."""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain
from typing import Any, Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import (
    HIGHER,
    HOUR_S,
    LOWER,
    NO_RATE,
    PER_HOUR,
    AxisScale,
    Better,
    Inference,
    Measure,
    MeasureTable,
    Parts,
)
from nvcore.comparison.measures.values import per_recording, rate_by_recording, ratio_of
from nvcore.comparison.scoring import SystemResult
from nvcore.metrics.venn import Venn, categorise, count_categories
from nvcore.subjects.alerts.episodes import ALERT_TEXT, RESTS_ON_DRIVER, UNWANTED, AlertKind
from nvcore.subjects.alerts.settings import ALERTS
from nvcore.subjects.alerts.steps import ASKED, OF_URGENCY, alerts_in
from nvcore.subjects.driver.comparison.settings import DRIVER

Members = Callable[[Result, SystemResult], np.ndarray]
"""Function that selects encounters of a kind, bool, shape (n_encounters,)."""
_SHARE: Final = AxisScale(".0%", least=1.0, least_reach=1.0)
_ASKED: Final[dict[str, Any]] = {"applies": ASKED.holds, "only_if": ASKED}
_URGENT: Final[dict[str, Any]] = {"applies": OF_URGENCY.holds, "only_if": OF_URGENCY}
_SCORED: Final[dict[str, Any]] = {"tables": (MeasureTable.SCORECARD,), **_ASKED}


def _unwanted_rows(result: Result, system: SystemResult) -> np.ndarray:
    return alerts_in(result).rows_of_kind(system, *UNWANTED)


def _by_recording(result: Result, system: SystemResult, *kinds: AlertKind) -> np.ndarray:
    """Count a system's alerts of these kinds in each recording, int64, shape (n_recordings,)."""
    rows = alerts_in(result).rows_of_kind(system, *kinds)
    recording = result.dataset.frame_columns.recording[rows]
    return per_recording(result, None, recording).astype(np.int64)


def _unwanted_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    return _by_recording(result, system, *UNWANTED)


_UNWANTED: Final[dict[str, Any]] = {
    "better": LOWER,
    "stages": (ALERTS, DRIVER),
    "is_worsened_by_alarms": True,
    **_SCORED,
}


def _of_kind(kind: AlertKind) -> tuple[Measure, Measure]:
    """Return two measures of one kind of alert: number of alerts, and alerts per hour."""
    rests_on_driver = kind in RESTS_ON_DRIVER

    def count(result: Result, system: SystemResult) -> float:
        return alerts_in(result).count(system)[kind]

    def by_recording(result: Result, system: SystemResult) -> Any:
        counts = _by_recording(result, system, kind)
        known = result.made["detectable"]["known_row"].to_numpy() >= 0
        is_known = per_recording(result, known, result.encounters.recording) > 0
        if is_known.all() or not rests_on_driver:
            return counts
        return np.where(is_known, counts, np.nan)

    label = f"{kind.value} alerts"
    unknown = "it is known of no {one} whether the driver sees {them}" if rests_on_driver else ""
    shared: dict[str, Any] = {
        "better": LOWER if kind in UNWANTED else "",
        "stages": (ALERTS, DRIVER) if rests_on_driver else (ALERTS,),
        "is_worsened_by_alarms": kind is AlertKind.FALSE,
        **_ASKED,
    }
    return (
        Measure(
            key=f"alerts_{kind.value}",
            label=label,
            part=label if kind in UNWANTED else "",
            form="d",
            of=count,
            unit="alerts",
            meaning=ALERT_TEXT[kind],
            empty=unknown,
            by_recording=by_recording,
            tables=(MeasureTable.SCORECARD,),
            **shared,
        ),
        Measure(
            key=f"alerts_{kind.value}_per_hour",
            label=f"{label} per hour",
            form=".1f",
            of=lambda result, system: ratio_of(HOUR_S * count(result, system), result.duration_s),
            unit=PER_HOUR,
            meaning="The same per hour.",
            empty=", or ".join(filter(None, (unknown, NO_RATE))),
            by_recording=rate_by_recording(by_recording, per_s=HOUR_S),
            **shared,
        ),
    )


def _count(
    key: str,
    label: str,
    members: Members,
    better: Better,
    meaning: str,
    *,
    part: str = "",
    inference: Inference | None = None,
    where: dict[str, Any] = _ASKED,
) -> Measure:
    """Return a measure that counts the encounters selected by `members`."""

    def by_recording(result: Result, system: SystemResult) -> np.ndarray:
        counts = per_recording(result, members(result, system), result.encounters.recording)
        return counts.astype(np.int64)

    return Measure(
        key=key,
        label=label,
        part=part,
        form="d",
        better=better,
        stages=(ALERTS,),
        is_worsened_by_alarms=False,
        leads=inference is not None,
        of=lambda result, system: int(np.count_nonzero(members(result, system))),
        unit="encounters",
        meaning=meaning,
        by_recording=by_recording,
        inference=inference,
        tables=(MeasureTable.SCORECARD,),
        **where,
    )


def _tested(
    key: str,
    what: str,
    members: Members,
    among: Callable[[Result], np.ndarray],
    meaning: str,
    *,
    per: str,
    denominator: str,
    split_in_group: str,
    where: dict[str, Any] = _ASKED,
) -> tuple[Measure, Measure]:
    """Return measures of the number and the share of encounters selected by `members`, with tests.

    The number is tested within these recordings, the share by resampling units.
    """

    def split(result: Result) -> Venn:  # all but `among` count as distant
        x, y = (members(result, system) for _, system in result.sides)
        return count_categories(categorise(~among(result), x, y))

    def parts(result: Result, system: SystemResult) -> Parts:
        return Parts(result.encounters.first_row[members(result, system)], None)

    within = Inference(
        test="encounters",
        scale=_SHARE,
        label=f"share of {what}, within these recordings",
        form=".1%",
        split=split,
        per=per,
        needs_tracks=True,
        repeats=f"{key}_by_unit",
        split_in_group=split_in_group,
    )
    by_unit = Inference(
        test="units", scale=_SHARE, parts=parts, per=per, noun=what, needs_tracks=True
    )
    label = f"{what}, of {denominator}"
    return (
        _count(key, label, members, HIGHER, meaning, inference=within, where=where),
        Measure(
            key=f"{key}_by_unit",
            label=f"share of {what}, by {{units}}",
            form=".1%",
            better=HIGHER,
            stages=(ALERTS,),
            is_worsened_by_alarms=False,
            inference=by_unit,
            **where,
        ),
    )


def _is_alerted(result: Result, system: SystemResult) -> np.ndarray:
    is_alerted: np.ndarray = result.is_near & (alerts_in(result).first_alert(system) >= 0)
    return is_alerted


def _median_lead_s(result: Result, system: SystemResult) -> float:
    """Return a system's median lead over the urgent encounters that both systems alert, seconds."""
    leads_s = [alerts_in(result).lead_s(side) for _, side in result.sides]
    is_alerted_by_both = ~np.isnan(leads_s).any(axis=0)
    lead_s = alerts_in(result).lead_s(system)[is_alerted_by_both]
    return float(np.median(lead_s)) if len(lead_s) else np.nan


MEASURES: Final[tuple[Measure, ...]] = (
    Measure(
        key="alerts_unwanted",
        label="unwanted alerts",
        form="d",
        leads=True,
        of=lambda result, system: len(_unwanted_rows(result, system)),
        unit="alerts",
        meaning="Alerts that are false, a nuisance or redundant. There may be more "
        "redundant ones where it is not known whether the driver sees the {many}.",
        by_recording=_unwanted_by_recording,
        **_UNWANTED,
    ),
    Measure(
        key="alerts_unwanted_per_hour",
        label="unwanted alerts per hour",
        part="per hour",
        form=".1f",
        of=lambda result, system: ratio_of(
            HOUR_S * len(_unwanted_rows(result, system)), result.duration_s
        ),
        unit=PER_HOUR,
        meaning="The same per hour.",
        empty=NO_RATE,
        by_recording=rate_by_recording(_unwanted_by_recording, per_s=HOUR_S),
        inference=Inference(
            test="units",
            scale=AxisScale(",.0f", least=1.0, least_reach=1.0, unit="alerts per hour"),
            parts=lambda result, system: Parts(_unwanted_rows(result, system), None),
            per="duration_s",
            factor=HOUR_S,
            not_of_pedestrians="a false alert belongs to no {one}",
            noun="unwanted alerts",
            noun_unit=" per hour",
            needs_tracks=True,
        ),
        **_UNWANTED,
    ),
    *chain(*(_of_kind(kind) for kind in AlertKind if kind is not AlertKind.IGNORED)),
    *_tested(
        "alerted",
        "encounters alerted",
        _is_alerted,
        lambda result: result.is_near,
        "Encounters that count and that any alert is about.",
        per="n_encounters",
        denominator="{n_near:,}",
        split_in_group="the near ones, by who alerts them",
    ),
    _count(
        "not_alerted",
        "not alerted",
        lambda result, system: result.is_near & ~_is_alerted(result, system),
        LOWER,
        "Encounters that count and that no alert is about.",
        part="not alerted",
    ),
    *_tested(
        "alerted_in_time",
        "urgent encounters alerted in time",
        lambda result, system: alerts_in(result).in_time(system),
        lambda result: alerts_in(result).is_to_alert,
        "Urgent encounters that an alert is about that begins before the last chance.",
        per="n_to_alert",
        denominator="{n_to_alert}",
        split_in_group="the urgent ones, by who alerts them in time",
        where=_URGENT,
    ),
    _count(
        "urgent_not_alerted",
        "urgent, never alerted",
        lambda result, system: (
            alerts_in(result).is_to_alert & (alerts_in(result).first_alert(system) < 0)
        ),
        LOWER,
        "Urgent encounters that no alert is about.",
        part="never alerted",
        where=_URGENT,
    ),
    Measure(
        key="median_alert_lead_s",
        label="median lead of the alert, where both alert (s)",
        form=".2f",
        better="",  # the median says nothing of those never alerted
        stages=(ALERTS,),
        is_worsened_by_alarms=False,
        of=_median_lead_s,
        unit="s",
        meaning="Median time from the first alert to the last chance, of the urgent encounters "
        "that both systems alert; negative: too late. It has the reaction time in it.",
        empty="no encounter is urgent, or both systems alerted none of them",
        tables=(MeasureTable.SCORECARD,),
        **_URGENT,
    ),
)

COUNTS: Final = {"n_to_alert": lambda result: alerts_in(result).is_to_alert}
"""Encounters used as denominators of measures and in labels, bool, shape (n_encounters,)."""
