"""Notes about the time left to stop."""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.evidence.claims import values_of
from nvcore.notes import Note
from nvcore.report.verdict import PointOf
from nvcore.settings.params import Params
from nvcore.subjects.time_left.judging import needed_time, turning_speeds
from nvcore.subjects.time_left.kinds import TimeLeft, Urgency
from nvcore.subjects.time_left.steps import count_time_left, time_left_in, time_left_of

FEW_URGENT: Final = 10
"""With at least this many urgent encounters, one of them moves a share by at most 10 %."""


def confirmed(result: Result) -> tuple[Note, ...]:
    """Return how many urgent encounters X and Y confirm in time, or nothing if none is urgent."""
    n = int(time_left_in(result).is_urgent.sum())
    if not n:
        return ()
    x, y = (count_time_left(system, TimeLeft.IN_TIME) for _, system in result.sides)
    impact_x, impact_y = values_of("mean_impact_kmh", result)
    of_both = {"x": x, "y": y, "impact_x": impact_x, "impact_y": impact_y}
    return (Note("time_left.confirmed", n=n, **of_both, speed=speed_of_all(result)),)


POINTS: Final = (PointOf("Time left", confirmed, after="Severity"),)
"""Points of the verdict about the time left."""


def urgent(result: Result) -> Note | None:
    """Return how many encounters are urgent, and why others are not.

    None without encounters, and for objects that are not on the road.
    """
    n_of, n_all = time_left_in(result).count_urgency(), len(result.encounters)
    if not n_all or not result.dataset.objects.is_on_road:
        return None
    if n_of[Urgency.UNKNOWN] == n_all:
        return Note("time_left.all_unknown", reasons=_reasons(result))
    speed = speed_of_all(result)
    if n_of[Urgency.NOT_URGENT] == n_all:
        return Note("time_left.urgent", n=0, speed=speed, others=[])
    reasons = {Urgency.UNKNOWN: _reasons(result)}
    others = [
        Note("time_left.not_urgent", n=n_of[kind], urgency=kind.value, reasons=reasons.get(kind))
        for kind in (Urgency.NO_CHANCE, Urgency.OUTSIDE, Urgency.NOT_URGENT, Urgency.UNKNOWN)
        if n_of[kind]
    ]
    n_distant = result.venn.distant or None  # the Venn diagram beside the note leaves these out
    n = n_of[Urgency.URGENT]
    return Note(
        "time_left.urgent", n=n, speed=speed, others=others, n_all=n_all, n_distant=n_distant
    )


def _reasons(result: Result) -> list[Note]:
    """Return why times to contact are unknown. Several reasons come with counts."""
    contact = time_left_in(result).contact
    is_unknown = (time_left_in(result).urgency["urgency"] == Urgency.UNKNOWN.value).to_numpy()
    of_reasons = {
        "sampled": contact.is_sampled,
        "linked": contact.is_linked & ~contact.is_sampled,
        "short": is_unknown & contact.is_judged,
    }
    counts = {why: int(np.count_nonzero(of)) for why, of in of_reasons.items() if of.any()}
    return [
        Note("time_left.unknown", why=why, n=n if len(counts) > 1 else None)
        for why, n in counts.items()
    ]


def speed_of_all(result: Result) -> Note:
    """Return the car's speed for which time left is judged."""
    view, kmh = time_left_in(result), result.params.speed_kmh
    if view.assumed_speed_kmh is not None:
        return Note("time_left.speed", kmh=kmh)
    n_assumed = int(np.count_nonzero(view.has_assumed_speed)) or None
    by = "frame" if result.dataset.frames["speed_kmh"].notna().any() else "recording"
    return Note("time_left.speed", by=by, kmh=kmh, n_assumed=n_assumed)


def needed(params: Params) -> Note:
    """Return how long before contact the last chance to stop is with these settings."""
    return Note(
        "time_left.needed_warning",
        speed_kmh=params.speed_kmh,
        needed_s=float(needed_time(np.array(params.speed_kmh), params)),
        reaction_s=params.reaction_s,
        deceleration=params.deceleration,
    )


def few_urgent(result: Result) -> tuple[Note, ...]:
    """Return a caution if there are only few urgent encounters. Nothing if there are none."""
    n = int(time_left_in(result).is_urgent.sum())
    return (Note("time_left.few_urgent", n=n),) if 0 < n < FEW_URGENT else ()


def responses(result: Result, encounters: np.ndarray) -> list[tuple[Note, Note]]:
    """Return when X and Y confirm each urgent encounter, and the resulting impact speeds.

    Parameters
    ----------
    encounters
        Rows of ``result.encounters``; shape (n,).
    """
    x, y = (
        [
            Note(
                "time_left.response",
                system=letter,
                margin_s=None if np.isnan(margin_s) else margin_s,  # never confirmed
                impact_kmh=impact_kmh,
            )
            for margin_s, impact_kmh in time_left_of(system)[["margin_s", "impact_kmh"]]
            .iloc[encounters]
            .itertuples(index=False, name=None)
        ]
        for letter, system in result.sides
    )
    return list(zip(x, y, strict=True))


def last_chance(result: Result, encounter: int) -> Note:
    """Return the last chance of an encounter and the response of each system.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    """
    view, frames = time_left_in(result), result.dataset.frames
    urgency = view.urgency.iloc[encounter]
    kind, row = Urgency(urgency["urgency"]), int(urgency["urgent_row"])
    if kind is Urgency.UNKNOWN:
        is_sampled, is_linked = view.contact.is_sampled, view.contact.is_linked
        why = "sampled" if is_sampled[encounter] else "linked" if is_linked[encounter] else "short"
        return Note("time_left.one_unknown", why=why)
    speed = _speed_of(result, encounter)
    if kind is Urgency.NOT_URGENT:
        least_s = float(urgency["min_ttc_s"])
        least_s_if_nearer = least_s if np.isfinite(least_s) else None
        return Note("time_left.one_not_urgent", speed=speed, least_s=least_s_if_nearer)
    is_urgent = kind is Urgency.URGENT
    return Note(
        "time_left.last_chance",
        urgency=kind.value,
        speed=speed,
        frame=int(frames["frame"].iloc[row]),
        time_s=float(frames["time_s"].iloc[row]),
        responses=responses(result, np.array([encounter]))[0] if is_urgent else None,
    )


def _speed_of(result: Result, encounter: int) -> Note:
    """Return the car's speed at the last chance, or its range in an encounter that has none."""
    urgent_row, encounters = time_left_in(result).urgency["urgent_row"], result.encounters
    rows = encounters.frame_index[slice(*encounters.offsets[encounter : encounter + 2])]
    if urgent_row.iloc[encounter] >= 0:
        rows = urgent_row.to_numpy()[[encounter]]
    stated_kmh = result.dataset.frame_columns.speed_kmh[rows]
    is_assumed = np.isnan(stated_kmh)
    used_kmh = np.where(is_assumed, result.params.speed_kmh, stated_kmh)
    kmh = [float(used_kmh.min()), float(used_kmh.max())]
    if is_assumed.all() or result.dataset.frames["speed_kmh"].iloc[rows].isna().all():
        kmh = [float(used_kmh[0])]  # one speed, not a series
    return Note("time_left.speed_of_one", kmh=kmh, is_stated=not is_assumed.any())


def orders(curve: pd.DataFrame) -> tuple[Note, ...]:
    """Return which system is ahead at which speeds, in share in time and in impact speed.

    Nothing if no encounter is urgent at any speed.

    Parameters
    ----------
    curve
        Table of `nvcore.subjects.time_left.judging.curve_over_speed`.
    """
    if not curve["urgent"].any():
        return ()
    return _order(curve, "share_in_time", 1), _order(curve, "mean_impact_kmh", -1)


def _order(
    curve: pd.DataFrame, measure: Literal["share_in_time", "mean_impact_kmh"], sign: int
) -> Note:
    """Return which system is ahead in a measure at which speeds.

    `sign` is 1 if higher values are better, else -1.
    """
    difference = sign * np.nan_to_num(curve[f"{measure}_x"] - curve[f"{measure}_y"])
    apart = np.flatnonzero(np.abs(difference) > 1e-9)
    if not len(apart):
        return Note("time_left.order", measure=measure)
    first, second = "xy" if difference[apart[0]] > 0 else "yx"
    n_equal = int(np.count_nonzero(curve["urgent"])) - len(apart)
    return Note(
        "time_left.order",
        measure=measure,
        first=first,
        second=second,
        turns_kmh=[*turning_speeds(curve, measure)],
        n_equal=n_equal or None,
        n_all=len(curve),
    )
