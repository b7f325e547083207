"""Time left: judge whether braking could still have helped when a system confirmed a pedestrian.

No speed sensor is needed. While a pedestrian is approached at constant speed, one over the height
of the box (like the distance) falls on a line that reaches 0 at contact.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.dataset.schema import KMH, NO_TRACK
from nvcore.metrics.encounters import Encounters
from nvcore.metrics.kernels import over_ranges
from nvcore.settings.params import Params
from nvcore.subjects.time_left.kernels import confirmed_frames, contact_frames, urgent_frames
from nvcore.subjects.time_left.kinds import TimeLeft, Urgency

SPEEDS_KMH: Final = tuple(range(10, 131, 5))
"""Speeds of the curve over the assumed speed."""


@dataclass(frozen=True, eq=False)
class Contact:
    """Time to contact of every pedestrian in every frame.

    Attributes
    ----------
    ttc_s
        Time to contact of each truth box, seconds. inf: not closing. NaN: unknown, or an ignored
        box. float64, shape (n_truth,).
    is_sampled, is_linked
        Reasons for an unknown time of a whole encounter: the frames are a sample, or the track was
        created by our linking. bool, shape (n_encounters,).
    """

    ttc_s: np.ndarray
    is_sampled: np.ndarray
    is_linked: np.ndarray

    @property
    def is_judged(self) -> np.ndarray:
        """Encounters that allow estimating the time to contact, bool, shape (n_encounters,)."""
        judged: np.ndarray = ~(self.is_sampled | self.is_linked)
        return judged


def measure_contact(
    truth: BoxColumns,
    encounters: Encounters,
    frames: FrameColumns,
    *,
    ttc_window: float,
    is_on_road: bool = True,
) -> Contact:
    """Estimate the time to contact of every pedestrian in every frame, from boxes alone.

    A least-squares line is fitted through the distances (if every box has one, else through one
    over the heights) in the frames within half a window. Boxes cut by the picture's edge do not
    count. The time is infinite if the line does not fall by at least twice the slope's standard
    error, and unknown with fewer than 5 boxes.

    Parameters
    ----------
    ttc_window
        Width of the window, seconds.
    is_on_road
        True if a car could hit the objects. Otherwise the time is unknown.

    References
    ----------
    ``docs/metrics.md``, time left.
    """
    is_sampled = frames.sampling_step[encounters.recording] > 1
    is_linked = truth.track[encounters.order[encounters.offsets[:-1]]] == NO_TRACK
    contact = Contact(np.full(len(truth), np.nan), is_sampled, is_linked)
    if not is_on_road:
        return contact
    over_encounters(
        contact_frames,
        encounters,
        encounters.recording,
        frames.arrays,
        truth.arrays,
        float(ttc_window),
        contact.is_judged,
        contact.ttc_s,
    )
    return contact


def over_encounters(kernel: Callable[..., Any], encounters: Encounters, *arguments: object) -> None:
    """Run a kernel over the truth rows of all encounters, in as many threads as there are cores."""
    over_ranges(kernel, len(encounters), encounters.arrays, *arguments)


def speed_of_frames(frames: FrameColumns, speed_kmh: float) -> np.ndarray:
    """Return the car's speed in each frame, km/h, shape (n_frames,).

    The frame's own speed, else the recording's, else the assumed `speed_kmh`.
    """
    return np.where(np.isnan(frames.speed_kmh), speed_kmh, frames.speed_kmh)


def needed_time(speed_kmh: np.ndarray, params: Params) -> np.ndarray:
    """Return the time to contact below which the car can no longer stop, seconds.

    ``reaction_s + v / (2 * deceleration)``: on braking from v to 0 the car covers what it would
    have covered in half the time.
    """
    needed: np.ndarray = params.reaction_s + speed_kmh / KMH / (2 * params.deceleration)
    return needed


def is_outside(
    boxes: BoxColumns, rows: np.ndarray, frames: FrameColumns, corridor: float
) -> np.ndarray:
    """Find boxes more than `corridor` half widths away from the picture's middle, bool, (n,)."""
    half = frames.half_width[boxes.frame_index[rows]]
    centre = np.clip(boxes.x[rows] + 0.5 * boxes.w[rows], 0, 2 * half)
    outside: np.ndarray = np.abs(centre - half) > corridor * half
    return outside


def find_urgent(
    contact: Contact,
    truth: BoxColumns,
    encounters: Encounters,
    frames: FrameColumns,
    params: Params,
    *,
    speed_kmh: np.ndarray | None = None,
) -> pd.DataFrame:
    """Find out whether and when each encounter becomes urgent, so that the driver needs a warning.

    Parameters
    ----------
    speed_kmh
        Speed in each frame, shape (n_frames,). None: `speed_of_frames`.

    Returns
    -------
    One row per encounter, distant ones too: min_ttc_s (least time to contact, inf: never closing,
    NaN: unknown), urgency (`Urgency`), urgent_row (frame row of the first frame with
    a time to contact below `needed_time`, -1 none), speed_kmh (there; NaN without one).
    """
    n = len(encounters)
    if speed_kmh is None:
        speed_kmh = speed_of_frames(frames, params.speed_kmh)
    least, known, urgent = np.empty(n), np.empty(n, np.int64), np.empty(n, np.int64)
    needed = needed_time(speed_kmh, params)
    over_encounters(urgent_frames, encounters, contact.ttc_s, needed, least, known, urgent)
    is_urgent = urgent >= 0
    place, first_known = urgent[is_urgent], known[is_urgent]
    row, frame_row = encounters.order[place], encounters.frame_index[place]
    classes = np.where(known >= 0, Urgency.NOT_URGENT.value, Urgency.UNKNOWN.value).astype(object)
    classes[is_urgent] = np.select(
        [
            is_outside(truth, row, frames, params.corridor),
            frame_row == encounters.frame_index[first_known],
        ],
        [Urgency.OUTSIDE.value, Urgency.NO_CHANCE.value],
        default=Urgency.URGENT.value,
    )
    urgent_row, speed = np.full(n, -1), np.full(n, np.nan)
    urgent_row[is_urgent], speed[is_urgent] = frame_row, speed_kmh[frame_row]
    return pd.DataFrame(
        {
            "min_ttc_s": least,
            "urgency": pd.Series(classes, dtype=object),
            "urgent_row": urgent_row,
            "speed_kmh": speed,
        }
    )


def confirm(
    contact: Contact, encounters: Encounters, is_matched: np.ndarray, params: Params
) -> pd.DataFrame:
    """Find when a system confirms each pedestrian by matching `confirm_n` of `confirm_m` frames.

    Parameters
    ----------
    is_matched
        Truth boxes that the system matched; bool, shape (n_truth,).

    Returns
    -------
    One row per encounter: confirmed_row (frame row, -1 never), ttc_s (time to contact there, or at
    the nearest earlier frame where it is known; NaN: none).
    """
    n = len(encounters)
    row, ttc_s = np.empty(n, np.int64), np.empty(n)
    over_encounters(
        confirmed_frames,
        encounters,
        *(is_matched, contact.ttc_s, int(params.confirm_n), int(params.confirm_m), row, ttc_s),
    )
    return pd.DataFrame({"confirmed_row": row, "ttc_s": ttc_s})


def judge_time_left(
    urgency: pd.DataFrame, confirmed: pd.DataFrame, frames: FrameColumns, params: Params
) -> pd.DataFrame:
    """Judge whether a system confirms each urgent pedestrian in time, and compute impact speeds.

    Parameters
    ----------
    urgency, confirmed
        Results of `find_urgent` and `confirm`.

    Returns
    -------
    One row per encounter: time_left (`TimeLeft`, None where not urgent), margin_s
    (from confirmation to the first urgent frame, seconds, more is better; NaN unless urgent and
    confirmed), impact_kmh (0 is best; NaN if not urgent).

    Notes
    -----
    If confirmed late, with the time to contact ttc left, the car brakes over the last
    ``v * (ttc - reaction_s)`` metres: ``sqrt(v^2 - 2 * deceleration * v * (ttc - reaction_s))``.
    """
    is_urgent = urgency["urgency"].to_numpy() == Urgency.URGENT.value
    urgent_row = urgency["urgent_row"].to_numpy()[is_urgent]
    row = confirmed["confirmed_row"].to_numpy()[is_urgent]
    is_late, is_never = row >= urgent_row, row < 0
    speed = urgency["speed_kmh"].to_numpy()[is_urgent] / KMH
    braked_s = np.maximum(0, confirmed["ttc_s"].to_numpy()[is_urgent] - params.reaction_s)
    squared = speed**2 - 2 * params.deceleration * speed * braked_s
    frame, rate = frames.frame, frames.fps[frames.recording[urgent_row]]
    n = len(urgency)
    classes, margin_s, impact = np.full(n, None), np.full(n, np.nan), np.full(n, np.nan)
    classes[is_urgent] = np.select(
        [is_never, is_late], [TimeLeft.NEVER.value, TimeLeft.LATE.value], TimeLeft.IN_TIME.value
    )
    margin_s[is_urgent] = np.where(is_never, np.nan, (frame[urgent_row] - frame[row]) / rate)
    impact[is_urgent] = KMH * np.select(
        [is_never, is_late], [speed, np.sqrt(np.maximum(0, squared))], 0.0
    )
    return pd.DataFrame(
        {
            "time_left": pd.Series(classes, dtype=object),  # not str: None stays None
            "margin_s": margin_s,
            "impact_kmh": impact,
        }
    )


@dataclass(frozen=True, eq=False)
class Judgement:
    """Results of time left for one system, computed on first access.

    Most slider moves do not need them.

    Attributes
    ----------
    urgency, confirmed
        Results of `find_urgent` and `confirm`.
    """

    urgency: pd.DataFrame
    confirmed: pd.DataFrame
    frames: FrameColumns
    params: Params

    @cached_property
    def time_left(self) -> pd.DataFrame:
        """Result of `judge_time_left`."""
        return judge_time_left(self.urgency, self.confirmed, self.frames, self.params)


def curve_over_speed(
    contact: Contact,
    truth: BoxColumns,
    encounters: Encounters,
    confirmed: Sequence[pd.DataFrame],
    frames: FrameColumns,
    params: Params,
) -> pd.DataFrame:
    """Judge time left at each speed of `SPEEDS_KMH` instead of the stated or assumed speed.

    Parameters
    ----------
    confirmed
        Results of `confirm` for X and Y.

    Returns
    -------
    One row per speed of `SPEEDS_KMH`: speed_kmh, urgent (encounters), and for X and Y in_time_x,
    in_time_y (encounters), share_in_time_x, share_in_time_y, mean_impact_kmh_x, mean_impact_kmh_y
    (NaN if no encounter is urgent).
    """
    rows = []
    for speed_kmh in SPEEDS_KMH:
        of_frames = np.full(len(frames), float(speed_kmh))
        urgency = find_urgent(contact, truth, encounters, frames, params, speed_kmh=of_frames)
        n_urgent = int((urgency["urgency"] == Urgency.URGENT.value).sum())
        row = {"speed_kmh": float(speed_kmh), "urgent": n_urgent}
        for letter, of_system in zip("xy", confirmed, strict=True):
            judged = judge_time_left(urgency, of_system, frames, params)
            n_in_time = int((judged["time_left"] == TimeLeft.IN_TIME.value).sum())
            row[f"in_time_{letter}"] = n_in_time
            row[f"share_in_time_{letter}"] = n_in_time / n_urgent if n_urgent else np.nan
            row[f"mean_impact_kmh_{letter}"] = judged["impact_kmh"].mean()
        rows.append(row)
    return pd.DataFrame(rows)


def turning_speeds(curve: pd.DataFrame, measure: str) -> list[float]:
    """Return the speeds of a curve at which the lead passes from one system to the other.

    Parameters
    ----------
    curve
        Result of `curve_over_speed`.
    measure
        ``share_in_time`` or ``mean_impact_kmh``.
    """
    difference = (curve[f"{measure}_x"] - curve[f"{measure}_y"]).to_numpy(dtype=float)
    is_apart = np.abs(np.nan_to_num(difference)) > 1e-9  # equal means differ in their last digits
    speeds, sign = curve["speed_kmh"].to_numpy()[is_apart], np.sign(difference[is_apart])
    turns = np.flatnonzero(np.diff(sign)) + 1
    return [float(speed) for speed in speeds[turns]]
