"""Measures of alerts: how many of each kind an hour, and whom the driver was told of in time."""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain
from typing import Any, Final

import numpy as np

from nvcore.alerts.kinds import ALERT_TEXT, UNWANTED, AlertKind
from nvcore.alerts.settings import ALERTS
from nvcore.alerts.steps import ASKED, alerts_in
from nvcore.comparison import Result
from nvcore.driver.comparison.settings import DRIVER
from nvcore.measures.entry import (
    HIGHER,
    LOWER,
    NO_FRAMES,
    AxisScale,
    Better,
    Inference,
    Measure,
    MeasureTable,
    Parts,
)
from nvcore.measures.values import per_recording, rate_by_recording, ratio_of
from nvcore.metrics.venn import Venn, categorise, count_categories
from nvcore.scoring import SystemResult
from nvcore.time_left.steps import time_left_in

Members = Callable[[Result, SystemResult], np.ndarray]
"""Encounters of a kind; bool, shape (n_encounters,)."""
_HOUR_S: Final = 3600.0
_SHARE: Final = AxisScale(".0%", least=1.0, least_reach=1.0)
_NOBODY: Final = "no encounter is urgent"


def _of_kinds(
    key: str, label: str, kinds: tuple[AlertKind, ...], meaning: str, better: Better
) -> tuple[Measure, Measure]:
    """The alerts of some kinds: how many, and how many an hour."""

    def count(result: Result, system: SystemResult) -> int:
        return len(alerts_in(result).rows_of_kind(system, *kinds))

    def per_hour(result: Result, system: SystemResult) -> float:
        return ratio_of(_HOUR_S * count(result, system), result.duration_s)

    def counts(result: Result, system: SystemResult) -> np.ndarray:
        rows = alerts_in(result).rows_of_kind(system, *kinds)
        of_recordings = per_recording(result, None, result.dataset.frame_columns.recording[rows])
        return of_recordings.astype(np.int64)

    def parts(result: Result, system: SystemResult) -> Parts:
        return Parts(alerts_in(result).rows_of_kind(system, *kinds), None)

    is_whole = kinds == UNWANTED
    rests_on_driver = {AlertKind.REDUNDANT, AlertKind.NEEDED} & {*kinds}
    shared: dict[str, Any] = {
        "better": better,
        "stages": (ALERTS, DRIVER) if rests_on_driver else (ALERTS,),
        "is_worsened_by_alarms": AlertKind.FALSE in kinds,
        "applies": ASKED.holds,
        "only_if": ASKED,
    }
    rate = Inference(
        test="units",
        scale=AxisScale(",.0f", least=1.0, least_reach=1.0, unit="alerts per hour"),
        parts=parts,
        per="duration_s",
        factor=_HOUR_S,
        not_of_pedestrians="a false alert belongs to no {one}",
        noun=label,
        noun_unit=" per hour",
        needs_tracks=True,
    )
    return (
        Measure(
            key=key,
            label=label,
            part=label if {*kinds} < {*UNWANTED} else "",
            form="d",
            leads=is_whole,
            of=count,
            unit="alerts",
            meaning=meaning,
            by_recording=counts,
            tables=(MeasureTable.SCORECARD,),
            **shared,
        ),
        Measure(
            key=f"{key}_per_hour",
            label=f"{label} per hour",
            part="per hour",
            form=".1f",
            of=per_hour,
            unit="1/h",
            meaning="The same per hour.",
            empty=NO_FRAMES,
            by_recording=rate_by_recording(counts, per_s=_HOUR_S),
            tables=(MeasureTable.SCORECARD,) if is_whole else (),
            inference=rate if is_whole else None,
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
) -> Measure:
    """Number of encounters of a kind."""

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
        tables=(MeasureTable.SCORECARD,),
        applies=ASKED.holds,
        only_if=ASKED,
        inference=inference,
    )


def _is_alerted(result: Result, system: SystemResult) -> np.ndarray:
    alerts = alerts_in(result)
    is_alerted: np.ndarray = alerts.is_near & (alerts.first_alert(system) >= 0)
    return is_alerted


def _in_time(result: Result, system: SystemResult) -> np.ndarray:
    return alerts_in(result).in_time(system)


def _parts_of(members: Members) -> Callable[[Result, SystemResult], Parts]:
    return lambda result, system: Parts(result.encounters.first_row[members(result, system)], None)


def _split(members: Members, of: Callable[[Result], np.ndarray]) -> Callable[[Result], Venn]:
    """Encounters of a kind by who alerts them; all others count as distant."""

    def split(result: Result) -> Venn:
        x, y = (members(result, system) for _, system in result.sides)
        return count_categories(categorise(~of(result), x, y))

    return split


def _by_unit(key: str, members: Members, per: str, what: str) -> Measure:
    """The share of encounters of a kind, for a claim about other recordings."""
    return Measure(
        key=key,
        label=f"share of {what}, by {{units}}",
        form=".1%",
        better=HIGHER,
        stages=(ALERTS,),
        is_worsened_by_alarms=False,
        applies=ASKED.holds,
        only_if=ASKED,
        inference=Inference(
            test="units",
            scale=_SHARE,
            parts=_parts_of(members),
            per=per,
            noun=what,
            needs_tracks=True,
        ),
    )


def _within(members: Members, of: Callable[[Result], np.ndarray], **known: str) -> Inference:
    """McNemar's test of who alerts them."""
    return Inference(
        test="encounters",
        scale=_SHARE,
        form=".1%",
        split=_split(members, of),
        needs_tracks=True,
        **known,  # type: ignore[arg-type]
    )


def _median_lead_s(result: Result, system: SystemResult) -> float:
    """Of the urgent encounters that both systems alert, so that both medians are of the same."""
    leads_s = [alerts_in(result).lead_s(side) for _, side in result.sides]
    is_alerted_by_both = ~np.isnan(leads_s).any(axis=0)
    lead_s = alerts_in(result).lead_s(system)[is_alerted_by_both]
    return float(np.median(lead_s)) if len(lead_s) else np.nan


MEASURES: Final[tuple[Measure, ...]] = (
    *_of_kinds(
        "alerts_unwanted",
        "unwanted alerts",
        UNWANTED,
        "Alerts that are false, a nuisance or redundant. There may be more redundant ones where it "
        "is not known whether the driver sees the {many}.",
        LOWER,
    ),
    *chain.from_iterable(
        _of_kinds(
            f"alerts_{kind.value}",
            f"{kind.value} alerts",
            (kind,),
            ALERT_TEXT[kind],
            LOWER if kind in UNWANTED else "",
        )
        for kind in AlertKind
        if kind is not AlertKind.IGNORED
    ),
    _count(
        "alerted",
        "encounters alerted, of {n_near:,}",
        _is_alerted,
        HIGHER,
        "Encounters that count and that any alert is about.",
        inference=_within(
            _is_alerted,
            lambda result: alerts_in(result).is_near,
            label="share of encounters alerted, within these recordings",
            per="n_encounters",
            repeats="alerted_by_unit",
            split_in_group="the near ones, by who alerts them",
        ),
    ),
    _by_unit("alerted_by_unit", _is_alerted, "n_encounters", "encounters alerted"),
    _count(
        "not_alerted",
        "not alerted",
        lambda result, system: alerts_in(result).is_near & ~_is_alerted(result, system),
        LOWER,
        "Encounters that count and that no alert is about.",
        part="not alerted",
    ),
    _count(
        "alerted_in_time",
        "urgent encounters alerted in time, of {n_urgent}",
        _in_time,
        HIGHER,
        "Urgent encounters that an alert is about that begins before the last chance.",
        inference=_within(
            _in_time,
            lambda result: time_left_in(result).is_urgent,
            label="share of urgent encounters alerted in time, within these recordings",
            per="n_urgent",
            repeats="alerted_in_time_by_unit",
            split_in_group="the urgent ones, by who alerts them in time",
        ),
    ),
    _by_unit("alerted_in_time_by_unit", _in_time, "n_urgent", "urgent encounters alerted in time"),
    _count(
        "urgent_not_alerted",
        "urgent, never alerted",
        lambda result, system: (
            time_left_in(result).is_urgent & (alerts_in(result).first_alert(system) < 0)
        ),
        LOWER,
        "Urgent encounters that no alert is about.",
        part="never alerted",
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
        empty=f"{_NOBODY}, or both systems alerted none of them",
        tables=(MeasureTable.SCORECARD,),
        applies=ASKED.holds,
        only_if=ASKED,
    ),
)
