"""Time left in words: what urgent means, one encounter, and what the speed changes."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import values_of
from nvcore.objects import Objects
from nvcore.params import Params
from nvcore.time_left.encounters import systems_in_words
from nvcore.time_left.judging import needed_time, turning_speeds
from nvcore.time_left.kinds import TimeLeft, Urgency
from nvcore.time_left.steps import count_time_left, time_left_in
from nvcore.wording import capitalised, count_text, listed

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


def describe_urgency(result: Result) -> str:
    """How many encounters leave a last chance to stop, at which speed, and why others do not."""
    counts = time_left_in(result).count_urgency()
    if not len(result.encounters) or not result.dataset.objects.is_on_road:
        return ""
    others = [
        f"{counts[kind]} {words}"
        for kind, words in (
            (Urgency.NO_CHANCE, "without a chance (too near to stop when first known)"),
            (Urgency.OUTSIDE, "outside the corridor"),
            (Urgency.NOT_URGENT, "not urgent"),
            (Urgency.UNKNOWN, f"unknown{_why_unknown(result)}"),
        )
        if counts[kind]
    ]
    n = counts[Urgency.URGENT]
    if counts[Urgency.NOT_URGENT] == len(result.encounters):
        return result.objects.say("{Nobody} is urgent {at}.", at=speed_text(result))
    if counts[Urgency.UNKNOWN] == len(result.encounters):
        return f"Time left to stop is unknown for all encounters{_why_unknown(result)}."
    none = result.objects.say("{Nobody} is")
    who = count_text(n, "encounter is", "encounters are") if n else none
    text = f"{who} urgent {speed_text(result)}"
    if others:
        text += f"; {', '.join(others)}"
    if result.venn.distant:  # which the Venn diagram beside it leaves out
        distant = count_text(result.venn.distant, "distant one")
        text += f" (of all {len(result.encounters):,} encounters, {distant} among them)"
    return f"{text}."


def speed_text(result: Result) -> str:
    """At which speed: "at 50 km/h (assumed)", or as the recordings say."""
    is_assumed, assumed = (
        time_left_in(result).has_assumed_speed,
        f"{result.params.speed_kmh:g} km/h",
    )
    if is_assumed.all():
        return f"at {assumed} (assumed)"
    if not is_assumed.any():
        return "at the speed of each recording"
    n = count_text(int(np.count_nonzero(is_assumed)), "recording")
    return f"at the speed of each recording ({assumed} assumed in {n} without)"


def _why_unknown(result: Result) -> str:
    """Why the time to contact of encounters is unknown, in brackets."""
    contact = time_left_in(result).contact
    is_unknown = (time_left_in(result).urgency["urgency"] == Urgency.UNKNOWN.value).to_numpy()
    reasons = {
        "not every frame is evaluated": contact.is_sampled,
        "the truth has no track ids": contact.is_linked & ~contact.is_sampled,
        "too short, or cut by the picture's edge": is_unknown & contact.is_judged,
    }
    counts = {text: int(np.count_nonzero(of)) for text, of in reasons.items() if of.any()}
    if len(counts) == 1:
        return f" ({next(iter(counts))})"
    return f" ({', '.join(f'{n} as {text}' for text, n in counts.items())})" if counts else ""


def describe_time_left(result: Result) -> tuple[str, ...]:
    """How many urgent pedestrians each system confirms in time; empty where nobody is urgent."""
    n = int(time_left_in(result).is_urgent.sum())
    if not n:
        return ()
    in_time_x, in_time_y = (count_time_left(system, TimeLeft.IN_TIME) for _, system in result.sides)
    impact_x, impact_y = values_of("mean_impact_kmh", result)
    impact = f"impact speed {impact_x:.1f} km/h with X and {impact_y:.1f} km/h with Y."
    speed = speed_text(result)
    if n == 1:
        who = {(1, 1): "X and Y", (1, 0): "X, not by Y", (0, 1): "Y, not by X", (0, 0): "neither"}
        by = who[in_time_x, in_time_y]
        return (f"The only urgent encounter {speed} is confirmed in time by {by}; {impact}",)
    return (
        f"Of {n} urgent encounters {speed}, X confirms {in_time_x} in time and Y {in_time_y}; mean "
        f"{impact}",
    )
