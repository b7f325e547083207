"""What time left has to say in every medium."""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import values_of
from nvcore.params import Params
from nvcore.time_left.facts import (
    Ahead,
    Among,
    Confirmed,
    Equal,
    FewUrgent,
    LastChance,
    NeededWarning,
    NotUrgent,
    OrderOverSpeed,
    Others,
    OverSpeed,
    Response,
    Speed,
    SpeedOfOne,
    Unknown,
    UnknownReason,
    Urgent,
    WhyUnknown,
)
from nvcore.time_left.judging import needed_time, turning_speeds
from nvcore.time_left.kinds import TimeLeft, Urgency
from nvcore.time_left.steps import count_time_left, time_left_in, time_left_of

FEW_URGENT: Final = 10
"""Fewest urgent encounters of which a single one does not move a share by more than 10 %."""
_CHANCES: Final[dict[Urgency, Literal["no chance", "outside", "urgent"]]] = {
    Urgency.NO_CHANCE: "no chance",
    Urgency.OUTSIDE: "outside",
    Urgency.URGENT: "urgent",
}


def confirmed(result: Result) -> tuple[Confirmed, ...]:
    """How many urgent encounters each system confirms in time; none where nobody is urgent."""
    n = int(time_left_in(result).is_urgent.sum())
    if not n:
        return ()
    x, y = (count_time_left(system, TimeLeft.IN_TIME) for _, system in result.sides)
    impact_x, impact_y = values_of("mean_impact_kmh", result)
    return (Confirmed(n, x, y, impact_x, impact_y, speed_of_all(result)),)


def urgent(result: Result) -> Urgent | None:
    """How many encounters leave a last chance to stop, and why others do not; None: there is none.

    Nor is there an answer for objects that are not on the road.
    """
    n_of, n_all = time_left_in(result).count_urgency(), len(result.encounters)
    if not n_all or not result.dataset.objects.is_on_road:
        return None
    speed, n, unknown = speed_of_all(result), n_of[Urgency.URGENT], _unknown(result)
    if n_of[Urgency.UNKNOWN] == n_all:
        return Urgent("unknown", speed, unknown=unknown)
    if n_of[Urgency.NOT_URGENT] == n_all:
        return Urgent("none", speed)
    every = (
        NotUrgent("no chance", n_of[Urgency.NO_CHANCE]),
        NotUrgent("outside", n_of[Urgency.OUTSIDE]),
        NotUrgent("not urgent", n_of[Urgency.NOT_URGENT]),
        NotUrgent("unknown", n_of[Urgency.UNKNOWN], unknown),
    )
    kinds = tuple(kind for kind in every if kind.n)
    n_distant = result.venn.distant  # which the Venn diagram beside it leaves out
    return Urgent(
        "many" if n > 1 else "one" if n else "none",
        speed,
        n,
        Others(kinds) if kinds else None,
        Among(n_all, n_distant) if n_distant else None,
    )


def speed_of_all(result: Result) -> Speed:
    """At which speed time left is judged."""
    view, kmh = time_left_in(result), result.params.speed_kmh
    if view.assumed_speed_kmh is not None:
        return Speed("assumed", kmh)
    n = int(np.count_nonzero(view.has_assumed_speed))
    if result.dataset.frames["speed_kmh"].notna().any():
        return Speed("some frames" if n else "by frame", kmh, n)
    return Speed("some" if n else "own", kmh, n)


def _unknown(result: Result) -> Unknown | None:
    """Why the time to contact of encounters is unknown."""
    contact = time_left_in(result).contact
    is_unknown = (time_left_in(result).urgency["urgency"] == Urgency.UNKNOWN.value).to_numpy()
    n_sampled, n_linked, n_short = (
        int(np.count_nonzero(of))
        for of in (
            contact.is_sampled,
            contact.is_linked & ~contact.is_sampled,
            is_unknown & contact.is_judged,
        )
    )
    if (n_sampled > 0) + (n_linked > 0) + (n_short > 0) == 1:
        only = UnknownReason("sampled" if n_sampled else "linked" if n_linked else "short", 0)
        return Unknown((only,))
    every = (
        UnknownReason("n sampled", n_sampled),
        UnknownReason("n linked", n_linked),
        UnknownReason("n short", n_short),
    )
    reasons = tuple(reason for reason in every if reason.n)
    return Unknown(reasons) if reasons else None


def needed(params: Params) -> NeededWarning:
    """What the last chance is, with the settings at hand."""
    needed_s = float(needed_time(np.array(params.speed_kmh), params))
    return NeededWarning(params.speed_kmh, needed_s, params.reaction_s, params.deceleration)


def few_urgent(result: Result) -> tuple[FewUrgent, ...]:
    """That urgent encounters are few; none: they are not, or there is none."""
    n = int(time_left_in(result).is_urgent.sum())
    return (FewUrgent("one" if n == 1 else "many", n),) if 0 < n < FEW_URGENT else ()


def responses(result: Result, encounters: np.ndarray) -> list[tuple[Response, Response]]:
    """What X and Y made of urgent encounters.

    Parameters
    ----------
    encounters
        Rows of ``result.encounters``; shape (n,).
    """
    columns = ["time_left", "margin_s", "impact_kmh"]
    x, y = (
        [
            _response(letter, *row)
            for row in time_left_of(system)[columns]
            .iloc[encounters]
            .itertuples(index=False, name=None)
        ]
        for letter, system in result.sides
    )
    return list(zip(x, y, strict=True))


def _response(letter: str, time_left: str, margin_s: float, impact_kmh: float) -> Response:
    kind: Literal["in time", "only then", "late", "never"]
    if time_left == TimeLeft.NEVER:
        kind = "never"
    elif time_left == TimeLeft.IN_TIME:
        kind = "in time"
    else:
        kind = "late" if margin_s else "only then"
    return Response(kind, letter, margin_s, impact_kmh)


def last_chance(result: Result, encounter: int) -> LastChance:
    """The last chance of an encounter and what each system made of it.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    """
    urgency = time_left_in(result).urgency.iloc[encounter]
    kind, row = Urgency(urgency["urgency"]), int(urgency["urgent_row"])
    speed = _speed_of(result, encounter)
    if kind is Urgency.UNKNOWN:
        return LastChance("unknown", _why_unknown(result, encounter))
    if kind is Urgency.NOT_URGENT:
        least_s = float(urgency["min_ttc_s"])
        is_nearer = np.isfinite(least_s)
        return LastChance("not urgent" if is_nearer else "never nearer", None, speed, least_s)
    frames = result.dataset.frames
    return LastChance(
        _CHANCES[kind],
        speed=speed,
        frame=int(frames["frame"].iloc[row]),
        time_s=float(frames["time_s"].iloc[row]),
        responses=responses(result, np.array([encounter]))[0] if kind is Urgency.URGENT else (),
    )


def _why_unknown(result: Result, encounter: int) -> WhyUnknown:
    contact = time_left_in(result).contact
    if contact.is_sampled[encounter]:
        return WhyUnknown("sampled")
    return WhyUnknown("linked" if contact.is_linked[encounter] else "short")


def _speed_of(result: Result, encounter: int) -> SpeedOfOne:
    urgent_row, encounters = time_left_in(result).urgency["urgent_row"], result.encounters
    rows = encounters.frame_index[slice(*encounters.offsets[encounter : encounter + 2])]
    if urgent_row.iloc[encounter] >= 0:
        rows = urgent_row.to_numpy()[[encounter]]
    stated_kmh = result.dataset.frame_columns.speed_kmh[rows]
    is_assumed = np.isnan(stated_kmh)
    if is_assumed.all():
        return SpeedOfOne("assumed", result.params.speed_kmh)
    if result.dataset.frames["speed_kmh"].iloc[rows].isna().all():
        return SpeedOfOne("own", float(stated_kmh[0]))
    used_kmh = np.where(is_assumed, result.params.speed_kmh, stated_kmh)
    kind: Literal["by frame", "some frames"] = "some frames" if is_assumed.any() else "by frame"
    return SpeedOfOne(kind, float(used_kmh.min()), float(used_kmh.max()))


def orders(curve: pd.DataFrame) -> tuple[OrderOverSpeed, ...]:
    """Who is ahead at which speed, in both measures; none where nobody is urgent at any.

    Parameters
    ----------
    curve
        Of `nvcore.time_left.judging.curve_over_speed`.
    """
    if not curve["urgent"].any():
        return ()
    return _order(curve, "share_in_time", 1), _order(curve, "mean_impact_kmh", -1)


def _order(
    curve: pd.DataFrame, measure: Literal["share_in_time", "mean_impact_kmh"], sign: int
) -> OrderOverSpeed:
    """Who is ahead in a measure; `sign` is that of X - Y where X is."""
    difference = sign * np.nan_to_num(curve[f"{measure}_x"] - curve[f"{measure}_y"])
    apart = np.flatnonzero(np.abs(difference) > 1e-9)
    if not len(apart):
        return OrderOverSpeed("same", OverSpeed(measure))
    turns_kmh = tuple(turning_speeds(curve, measure))
    first, second = "xy" if difference[apart[0]] > 0 else "yx"
    n_equal = int(np.count_nonzero(curve["urgent"])) - len(apart)
    return OrderOverSpeed(
        "often" if len(turns_kmh) > 1 else "once" if turns_kmh else "always",
        OverSpeed(measure),
        Ahead(measure, first),
        second,
        turns_kmh,
        Equal("addition" if turns_kmh else "but", n_equal, len(curve)) if n_equal else None,
    )
