"""What time left has to say in every medium."""

from __future__ import annotations

import numpy as np

from nvcore.comparison import Result
from nvcore.evidence.claims import values_of
from nvcore.time_left.facts import (
    Among,
    Confirmed,
    Kind,
    Others,
    Reason,
    Speed,
    Unknown,
    Urgent,
)
from nvcore.time_left.kinds import TimeLeft, Urgency
from nvcore.time_left.steps import count_time_left, time_left_in


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
        Kind("no chance", n_of[Urgency.NO_CHANCE]),
        Kind("outside", n_of[Urgency.OUTSIDE]),
        Kind("not urgent", n_of[Urgency.NOT_URGENT]),
        Kind("unknown", n_of[Urgency.UNKNOWN], unknown),
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
    is_assumed, kmh = time_left_in(result).has_assumed_speed, result.params.speed_kmh
    if is_assumed.all():
        return Speed("assumed", kmh)
    n = int(np.count_nonzero(is_assumed))
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
        only = Reason("sampled" if n_sampled else "linked" if n_linked else "short", 0)
        return Unknown((only,))
    every = (
        Reason("n sampled", n_sampled),
        Reason("n linked", n_linked),
        Reason("n short", n_short),
    )
    reasons = tuple(reason for reason in every if reason.n)
    return Unknown(reasons) if reasons else None
