"""Speed alerts: the limit stored from sign to sign, and excess of it for too long.

A system stores the limit that it read last until it reads another. It alerts the driver once the
car has been above it for the parameter `speeding_after_s`, until the car no longer is. The truth
does the same with the signs that were passed. If the limit or the speed is unknown, nobody is
alerted.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.metrics.similarity import runs_of
from nvcore.subjects.alerts.settings import KMH_OF
from nvcore.tables.classes import matches_by_place

NO_LIMIT: Final = math.inf
"""Value stored after the end of a limit. No limit is known, so no speed is above it."""
_ENDS: Final = re.compile(r"\b(ends?|derestrict\w*|unlimited|no (speed )?limit)\b", re.IGNORECASE)


ROWS: Final = {
    "alerted": ("alerted when the limit calls for it, of {true}", "d"),
    "missed": ("missed", "d"),
    "right": ("alerts that are right", "d"),
    "false": ("false", "d"),
    "not_known": ("while no true limit is known", "d"),
    "median_late_s": ("median lateness (s)", "+.2f"),
    "right_limit": ("time with the right limit", ".0%"),
    "no_limit_s": ("time without a limit read (s)", ".1f"),
    "true_no_limit_s": ("time without a known true limit (s)", ".1f"),
    "no_speed_s": ("time without a known speed (s)", ".1f"),
}
"""Displayed columns of `Speeding.summary`, with texts (with ``true`` in them) and formats."""


class State(StrEnum):
    """Kind of an episode.

    Attributes
    ----------
    TRUE
        An episode of the truth in which the driver should have been alerted.
    RIGHT, FALSE
        A system's alert that overlaps an episode of the truth, or none.
    NOT_KNOWN
        A system's alert that overlaps none, at a time when the truth knows no limit.
    MISSED
        An episode of the truth that no alert of a system overlaps.
    """

    TRUE = "true"
    RIGHT = "right"
    FALSE = "false"
    NOT_KNOWN = "not_known"
    MISSED = "missed"


class Cause(StrEnum):
    """Cause of a false or missed alert of a system: the limit stored at its start.

    Attributes
    ----------
    MISREAD
        A limit read from a sign that shows another.
    NO_SIGN
        A limit read where no sign is.
    AHEAD
        The limit of a sign that was not yet passed.
    NOT_READ
        No limit, or that of an earlier sign, because the valid sign was not read.
    TIMING
        The right limit, but read so late or so early that the car was above it at other times.
    """

    MISREAD = "misread"
    NO_SIGN = "no_sign"
    AHEAD = "ahead"
    NOT_READ = "not_read"
    TIMING = "timing"


@dataclass(frozen=True, eq=False)
class Stored:
    """Limit stored in every frame.

    Attributes
    ----------
    limit_kmh
        km/h, float64, shape (n_frames,); NaN unknown, `NO_LIMIT` after the end of a limit.
    row
        Row of the box that shows it, in the truth or the system, -1 before the first; int64, shape
        (n_frames,).
    """

    limit_kmh: np.ndarray
    row: np.ndarray


def limit_of(label: str) -> float:
    """Return the limit that a class shows, in the unit of its number, or NaN if it shows none.

    Parameters
    ----------
    label
        One of `nvcore.dataset.Dataset.labels`. For speed signs it is the number without its unit.

    Examples
    --------
    >>> [*map(limit_of, ["50", "end of speed limit", "give way"])]
    [50.0, inf, nan]
    """
    if label.isascii() and label.isdecimal():
        return float(label)
    return NO_LIMIT if _ENDS.search(label.replace("_", " ")) else math.nan


def has_limits(dataset: Dataset) -> bool:
    """Whether there are signs whose class is a limit, and frames in which the speed is known."""
    if not dataset.objects.is_numbered:  # then "1" is a class, not a limit
        return False
    is_known = ~np.isnan(dataset.frame_columns.speed_kmh)
    return bool(is_known.any() and (~np.isnan([*map(limit_of, dataset.labels)])).any())


def store_limits(
    boxes: BoxColumns, rows: np.ndarray, limit_kmh: np.ndarray, frames: FrameColumns
) -> Stored:
    """Store the limit of each of these boxes from its frame until that of the next one.

    If a frame has several, the highest box counts, as it is the nearest. Recordings begin without a
    limit.

    Parameters
    ----------
    boxes
        Boxes of the truth or a system.
    rows
        Rows of the boxes that are stored; int64, shape (n,).
    limit_kmh
        Limit that each box shows; float64, shape (n_boxes,).
    frames
        The listed frames.
    """
    rows = rows[np.lexsort((boxes.h[rows], boxes.frame_index[rows]))]
    at = boxes.frame_index[rows]
    latest = np.searchsorted(at, np.arange(len(frames)), side="right") - 1
    row = np.append(rows, -1)[latest]  # -1: the one appended
    is_own = np.append(at, -1)[latest] >= frames.first[frames.recording]
    row = np.where(is_own, row, -1)
    return Stored(np.append(limit_kmh, math.nan)[row], row)


def find_speeding(
    limit_kmh: np.ndarray, speed_kmh: np.ndarray, frames: FrameColumns, *, after_s: float
) -> pd.DataFrame:
    """Find episodes in which the driver should be alerted: above the limit for `after_s` or longer.

    An episode begins in the first frame at least `after_s` after the first one above the limit, and
    ends with the last frame above it or the recording. A change of the limit does not interrupt it,
    but an unknown limit or speed does.

    Parameters
    ----------
    limit_kmh, speed_kmh
        Limit and speed in every frame, km/h; float64, shape (n_frames,); NaN unknown.
    frames
        The listed frames.
    after_s
        Seconds, 0 or more.

    Returns
    -------
    Columns first_row and last_row (of the frames table, inclusive), in the order of the frames.
    """
    above = np.where(speed_kmh > limit_kmh, 0, -1)  # never where one is NaN
    first, last = runs_of(above, frames.recording)
    # passed counts frames over all recordings, which are never mixed: the onset is within the run
    due = frames.passed[first] + after_s * frames.fps[frames.recording[first]] * (1 - 1e-9)
    onset = np.searchsorted(frames.passed, due)
    table = pd.DataFrame({"first_row": onset, "last_row": last})
    episodes: pd.DataFrame = table[onset <= last].reset_index(drop=True)
    return episodes


@dataclass(frozen=True, eq=False)
class Speeding:
    """Speed alerts of a comparison.

    Attributes
    ----------
    result
        The comparison.
    stored
        The stored limits of ``"truth"``, ``"x"`` and ``"y"``.
    episodes
        One row per episode of the truth and of each system, and per episode that a system misses:
        subject (``"truth"``, ``"x"``, ``"y"``), state (`State`), cause (`Cause` if false or missed,
        else empty), recording (row of the recordings table), first_row and last_row (of the
        frames table, inclusive), start_s and stop_s (the end of the last frame's time step, seconds
        from the recording's first frame), limit_kmh (stored by the subject at the start; NaN none),
        true_limit_kmh (by the truth, then), top_kmh (highest speed in it) and late_s (from the
        start of the truth's episode to that of the system's first alert in it, seconds, negative:
        earlier; NaN for all other rows). Sorted by subject, then time. A missed episode has the
        times of the truth's.
    """

    result: Result
    stored: Mapping[str, Stored] = field(repr=False)
    episodes: pd.DataFrame = field(repr=False)

    @property
    def table(self) -> pd.DataFrame:
        """`episodes` with the names of the recordings, as in ``speeding.csv``."""
        names = self.result.dataset.recordings["name"].to_numpy()
        return self.episodes.assign(recording=names[self.episodes["recording"]])

    def limits(self) -> pd.DataFrame:
        """Return runs of frames with the same stored limit, as lanes.

        Returns
        -------
        Columns subject, recording, first_row, last_row, start_s, stop_s (see `episodes`) and
        limit_kmh (NaN unknown, inf none holds), by subject, then time.
        """
        frames = self.result.dataset.frame_columns
        parts = []
        for subject, stored in self.stored.items():
            limit = stored.limit_kmh
            shown = pd.factorize(limit, use_na_sentinel=False)[0]
            first, last = runs_of(shown, frames.recording)
            part = _timed(
                self.result, subject, pd.DataFrame({"first_row": first, "last_row": last})
            )
            parts.append(part.assign(limit_kmh=limit[first]))
        return pd.concat(parts, ignore_index=True)

    def summary(self) -> pd.DataFrame:
        """Summarise each system's speed alerts, one row for X and one for Y.

        Returns
        -------
        Columns system (its name), true (episodes of the truth), alerted (those with an alert),
        missed, alerts (of the system), right, false, not_known; false_<cause> and missed_<cause>
        for every `Cause`; median_late_s and most_late_s (of the alerted; NaN: none), false_s
        (seconds of false alerts), right_limit (share of the time in which the system has stored the
        truth's limit, where the truth knows one; NaN: never), no_limit_s and true_no_limit_s
        (seconds in which the system, the truth has no limit stored or an unknown one) and
        no_speed_s (seconds of unknown speed): in these nobody can be alerted.
        """
        frames, episodes = self.result.dataset.frame_columns, self.episodes
        truth, step_s = self.stored["truth"].limit_kmh, frames.step_s
        is_known = ~np.isnan(truth)
        known_s = float(step_s[is_known].sum())
        n_true = int((episodes["subject"] == "truth").sum())
        n_of = episodes.groupby(["subject", "state"]).size()
        n_because = episodes.groupby(["subject", "state", "cause"]).size()
        rows = []
        for letter, system in self.result.sides:
            own = episodes[episodes["subject"] == letter]
            false = own[own["state"] == State.FALSE]
            limit = self.stored[letter].limit_kmh
            right_s = float(step_s[is_known & (limit == truth)].sum())
            n = {state: int(n_of.get((letter, state), 0)) for state in State}
            rows.append(
                {
                    "system": system.name,
                    "true": n_true,
                    "alerted": n_true - n[State.MISSED],
                    "alerts": n[State.RIGHT] + n[State.FALSE] + n[State.NOT_KNOWN],
                    **{state.value: n[state] for state in State if state is not State.TRUE},
                    **{
                        f"{state}_{cause}": int(n_because.get((letter, state, cause), 0))
                        for state in (State.FALSE, State.MISSED)
                        for cause in Cause
                    },
                    "median_late_s": own["late_s"].median(),
                    "most_late_s": own["late_s"].max(),
                    "false_s": float((false["stop_s"] - false["start_s"]).sum()),
                    "right_limit": right_s / known_s if known_s else math.nan,
                    "no_limit_s": float(step_s[np.isnan(limit)].sum()),
                    "true_no_limit_s": float(step_s[~is_known].sum()),
                    "no_speed_s": float(step_s[np.isnan(frames.speed_kmh)].sum()),
                }
            )
        return pd.DataFrame(rows)


def judge_speeding(result: Result) -> Speeding:
    """Compare the systems' speed alerts with those that the truth calls for.

    The truth stores a limit in the last annotated frame of its sign, when the car passes it. A sign
    annotated to the end of the recording was not passed. A system stores a limit in every frame in
    which a counted detection (matched or false) shows one. A sign of the truth with an unknown
    limit makes the stored one unknown. A system that cannot read a sign keeps its stored limit.

    Parameters
    ----------
    result
        Comparison of speed signs whose classes are their limits, with the speed of the car.
    """
    dataset, encounters = result.dataset, result.encounters
    truth, frames = dataset.truth, dataset.frame_columns
    # NO_LABEL is -1: the last
    shown = np.array([*map(limit_of, dataset.labels), math.nan]) * KMH_OF[result.params.limit_unit]
    is_passed = encounters.last_row + 1 < frames.first[encounters.recording + 1]
    passed = encounters.order[encounters.offsets[1:] - 1][is_passed]
    stored = {"truth": store_limits(truth, passed, shown[truth.label], frames)}
    for letter, system in result.sides:
        boxes = dataset.system(system.name)
        read = shown[boxes.label]
        rows = np.flatnonzero(system.matches.is_counted & ~np.isnan(read))
        stored[letter] = store_limits(boxes, rows, read, frames)
    true, *own = (
        find_speeding(
            limit.limit_kmh, frames.speed_kmh, frames, after_s=result.params.speeding_after_s
        )
        for limit in stored.values()
    )
    parts = [_episodes(result, stored, "truth", true, State.TRUE)]
    for (letter, system), alerts in zip(result.sides, own, strict=True):
        causes = _causes(result, system, stored[letter], stored["truth"], shown)
        parts += _judged(result, stored, letter, alerts, true, causes)
    return Speeding(result, stored, pd.concat(parts, ignore_index=True))


def _judged(
    result: Result,
    stored: Mapping[str, Stored],
    letter: str,
    alerts: pd.DataFrame,
    true: pd.DataFrame,
    causes: np.ndarray,
) -> list[pd.DataFrame]:
    """Return a system's rows of `Speeding.episodes`, from its alerts and the truth's episodes."""
    first = alerts["first_row"].to_numpy()
    is_known = ~np.isnan(stored["truth"].limit_kmh[first])
    state = np.where(is_known, State.FALSE, State.NOT_KNOWN).astype(object)
    state[_first_overlap(alerts, true) >= 0] = State.RIGHT
    alert = _first_overlap(true, alerts)
    is_alerted = alert >= 0
    time_s = result.dataset.frames["time_s"].to_numpy()
    late_s = np.full(len(alerts), math.nan)
    # backwards: an alert that covers several episodes has the time of the first
    at, of = alert[is_alerted][::-1], true["first_row"].to_numpy()[is_alerted][::-1]
    late_s[at] = time_s[first[at]] - time_s[of]
    own = _episodes(result, stored, letter, alerts, state).assign(
        cause=np.where(state == State.FALSE, causes[first], ""), late_s=late_s
    )
    missed = true[~is_alerted]
    lacking = _episodes(result, stored, letter, missed, State.MISSED).assign(
        cause=causes[missed["first_row"].to_numpy()]
    )
    return [pd.concat([own, lacking]).sort_values("first_row", kind="stable")]


def _causes(
    result: Result, system: SystemResult, own: Stored, true: Stored, shown: np.ndarray
) -> np.ndarray:
    """Return the `Cause` that would explain a wrong alert in each frame, object, (n_frames,)."""
    encounters, truth = result.encounters, result.dataset.truth
    sign = np.append(matches_by_place(result, system).det_truth, -1)[own.row]
    of_sign = np.append(encounters.encounter_of, -1)[sign]
    frame = np.arange(len(own.row))
    kinds = [
        (own.row < 0, Cause.NOT_READ),
        (sign < 0, Cause.NO_SIGN),
        (own.limit_kmh != np.append(shown[truth.label], math.nan)[sign], Cause.MISREAD),
        (np.append(encounters.last_row, -1)[of_sign] > frame, Cause.AHEAD),
        (own.limit_kmh != true.limit_kmh, Cause.NOT_READ),
    ]
    conditions, causes = zip(*kinds, strict=True)
    return np.select(conditions, [np.array(cause, dtype=object) for cause in causes], Cause.TIMING)


def _first_overlap(runs: pd.DataFrame, others: pd.DataFrame) -> np.ndarray:
    """Return the first of the others that each run overlaps, or -1.

    Both tables are in order, without overlaps within a table.
    """
    at = np.searchsorted(others["last_row"], runs["first_row"])
    starts = np.append(others["first_row"], np.iinfo(np.int64).max)[at]
    return np.where(starts <= runs["last_row"], at, -1)


def _episodes(
    result: Result,
    stored: Mapping[str, Stored],
    subject: str,
    runs: pd.DataFrame,
    state: np.ndarray | State,
) -> pd.DataFrame:
    """Return rows of `Speeding.episodes` without cause and lateness."""
    speed_kmh = np.append(result.dataset.frame_columns.speed_kmh, 0.0)
    first, last = runs["first_row"].to_numpy(), runs["last_row"].to_numpy()
    bounds = np.stack([first, last + 1], axis=1).ravel()
    top_kmh = np.maximum.reduceat(speed_kmh, bounds)[::2] if len(bounds) else np.empty(0)
    return _timed(result, subject, runs, state=state, cause="").assign(
        limit_kmh=stored[subject].limit_kmh[first],
        true_limit_kmh=stored["truth"].limit_kmh[first],
        top_kmh=top_kmh,
        late_s=math.nan,
    )


def _timed(result: Result, subject: str, runs: pd.DataFrame, **more: object) -> pd.DataFrame:
    """Return runs of frames with subject, further constant columns, recording and times."""
    frames = result.dataset.frames
    first, last = frames.iloc[runs["first_row"]], frames.iloc[runs["last_row"]]
    return pd.DataFrame(
        {
            "subject": subject,
            **more,
            "recording": first["recording"].to_numpy(),
            "first_row": runs["first_row"].to_numpy(),
            "last_row": runs["last_row"].to_numpy(),
            "start_s": first["time_s"].to_numpy(),
            "stop_s": last["time_s"].to_numpy() + last["step_s"].to_numpy(),
        }
    )
