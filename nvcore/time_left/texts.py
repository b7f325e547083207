"""Time left in words: what urgent means, one encounter, and what the speed changes."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.objects import Objects
from nvcore.params import Params
from nvcore.time_left.encounters import systems_in_words
from nvcore.time_left.judging import needed_time, turning_speeds
from nvcore.time_left.kinds import Urgency
from nvcore.time_left.steps import time_left_in
from nvcore.wording import capitalised, listed

FEW_URGENT: Final = 10
"""Fewest urgent encounters of which a single one does not move a share by more than 10 %."""
_AHEAD: Final = {
    "share_in_time": ("confirms the larger share in time", "The share in time", 1),
    "mean_impact_kmh": ("has the lower mean impact speed", "The mean impact speed", -1),
}
"""What the system ahead does, the measure, and the sign of X - Y where X is ahead."""


def describe_needed(params: Params, objects: Objects) -> str:
    """What the last chance is, with the settings at hand."""
    needed_s = float(needed_time(np.array(params.speed_kmh), params))
    return (
        f"At {params.speed_kmh:g} km/h the car still stops before {objects.say('{a_one}')} if the "
        f"warning comes more than {needed_s:.1f} s before contact: {params.reaction_s:g} s pass "
        f"until the brakes act, then it brakes with {params.deceleration:g} m/s². The frame from "
        "which on less is left is the last chance."
    )


def few_urgent(n: int) -> str:
    """That so many urgent encounters are few; empty: they are not, or there is none."""
    if not 0 < n < FEW_URGENT:
        return ""
    who = "The only urgent encounter says" if n == 1 else f"{n} urgent encounters are few: they say"
    return f"{who} what happened in these recordings, and little of what happens in others."


def describe_encounter(result: Result, encounter: int) -> str:
    """The last chance of an encounter and what each system made of it; in sentences.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    """
    urgency = time_left_in(result).urgency.iloc[encounter]
    kind, row = Urgency(urgency["urgency"]), int(urgency["urgent_row"])
    speed_kmh = _speed_of(result, encounter)
    if kind is Urgency.UNKNOWN:
        return f"Time left to stop is unknown: {why_unknown(result, encounter)}."
    if kind is Urgency.NOT_URGENT:
        least_s = float(urgency["min_ttc_s"])
        if np.isinf(least_s):
            return "Not urgent: the car never comes nearer, as far as the boxes tell."
        return f"Not urgent at {speed_kmh}: never less than {least_s:.1f} s to contact."
    frames = result.dataset.frames
    when = f"frame {frames['frame'].iloc[row]} ({frames['time_s'].iloc[row]:.2f} s)"
    if kind is Urgency.NO_CHANCE:
        return f"No chance at {speed_kmh}: too near to stop when first known, in {when}."
    if kind is Urgency.OUTSIDE:
        he = result.objects.say("{he}")
        return f"Outside the corridor when {he} becomes urgent at {speed_kmh}, in {when}."
    of_both = ". ".join(systems_in_words(result, np.array([encounter]))[0])
    return f"Urgent at {speed_kmh}: the last chance to stop is {when}. {of_both}."


def why_unknown(result: Result, encounter: int) -> str:
    """Why the time to contact of an encounter is unknown."""
    if time_left_in(result).contact.is_sampled[encounter]:
        return "not every frame is evaluated"
    if time_left_in(result).contact.is_linked[encounter]:
        return f"the truth gives this {result.objects.singular} no track id"
    return result.objects.say("{he} is there for too few frames, or cut by the picture's edge")


def _speed_of(result: Result, encounter: int) -> str:
    recording = int(result.encounters.recording[encounter])
    if time_left_in(result).has_assumed_speed[recording]:
        return f"{result.params.speed_kmh:g} km/h (assumed)"
    return f"{result.dataset.frame_columns.speed_kmh[recording]:g} km/h"


def describe_turns(curve: pd.DataFrame) -> tuple[str, ...]:
    """Who is ahead at which speed, in sentences; empty where nobody is urgent at any.

    Parameters
    ----------
    curve
        Of `nvcore.time_left.judging.curve_over_speed`.
    """
    if not curve["urgent"].any():
        return ()
    return tuple(_turns_of(curve, measure) for measure in _AHEAD)


def _turns_of(curve: pd.DataFrame, measure: str) -> str:
    does, name, sign = _AHEAD[measure]
    difference = sign * np.nan_to_num(curve[f"{measure}_x"] - curve[f"{measure}_y"])
    apart = np.flatnonzero(np.abs(difference) > 1e-9)
    if not len(apart):
        return f"{name} of X and Y is the same at every speed."
    turns = turning_speeds(curve, measure)
    first, second = "XY" if difference[apart[0]] > 0 else "YX"
    n_even = int(np.count_nonzero(curve["urgent"])) - len(apart)
    but = f" but {n_even} of {len(curve)}, at which X and Y are equal" if n_even else ""
    even = f"; at {n_even} of {len(curve)} speeds X and Y are equal" if n_even else ""
    if not turns:
        return f"{first} {does} at every speed{but}."
    if len(turns) == 1:
        return f"Below {turns[0]:g} km/h {first} {does}, from there on {second}{even}."
    speeds = listed([f"{speed:g}" for speed in turns])
    return capitalised(
        f"{name.lower()} turns {len(turns)} times: up to {turns[0]:g} km/h {first} is ahead, and "
        f"the order changes at {speeds} km/h{even}."
    )
