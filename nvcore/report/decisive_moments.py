"""Frames that decide a comparison, at most one per scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.dataset.schema import Category, MissClass
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.notes import Note, say
from nvcore.tables.moments import worst_moments

MOST: Final = 12
"""Maximum number of frames of a report."""
EXCLUSIVE: Final = 4
"""Maximum number of encounters that only X detects, and that only Y detects."""
APART_S: Final = 2.0
"""Time in seconds below which frames where the same system does badly are one scene."""
LEAST_LEAD: Final = 0.05
"""Minimum difference in similarity for a moment in which one system is better."""
KINDS: Final = {
    "x": "A worst moment of X",
    "y": "A worst moment of Y",
    "x_better": "X better than Y",
    "y_better": "Y better than X",
}
MOST_OF: Final = dict.fromkeys(KINDS.values(), 2)
"""Maximum number of moments of each of these kinds."""
LOSER: Final = {"x": "x", "y": "y", "x_better": "y", "y_better": "x"}
"""System that does badly in each kind of moment."""


class Moment(NamedTuple):
    """Frame to show in the report, with the reason.

    Attributes
    ----------
    row
        Row of the frames table.
    title, text
        Reason for showing the frame, and description of the event.
    encounter
        Encounter concerned. -1: the moment is about the detections of `loser`.
    loser
        The system that does badly, "x" or "y".
    """

    row: int
    title: str
    text: str
    encounter: int
    loser: str


def decisive_moments(result: Result) -> list[Moment]:
    """Return the frames to show in the report, at most `MOST` and one per scene.

    Encounters that only one system detects come first, by the severity of the failure, each at the
    frame with the largest difference in similarity. The worst moments of each system and those with
    the largest difference follow. If the same system does badly in several frames of a recording
    within `APART_S`, the first in this order is taken.
    """
    # the worst of each kind comes before the second worst of any kind
    ranked = worst_moments(result, n=MOST)
    ranked = ranked.assign(rank=ranked.groupby("kind").cumcount())
    worst = [
        moment
        for row in ranked.sort_values("rank", kind="stable").to_dict("records")
        if (moment := _worst(result, row)) is not None
    ]
    moments: list[Moment] = []
    n_of: dict[str, int] = {}
    for moment in (
        *_exclusive(result, Category.X_ONLY, "x", "y"),
        *_exclusive(result, Category.Y_ONLY, "y", "x"),
        *worst,
    ):
        kind = moment.title.partition(" (")[0]
        if n_of.get(kind, 0) < MOST_OF.get(kind, MOST) and not _is_shown(result, moment, moments):
            moments.append(moment)
            n_of[kind] = n_of.get(kind, 0) + 1
    return moments[:MOST]


def main_moments(result: Result, n: int = 3) -> list[Moment]:
    """Return `n` of `decisive_moments`, with one of each kind before a second of any kind."""
    moments = decisive_moments(result)
    first = {moment.title.partition(" (")[0]: moment for moment in reversed(moments)}
    return sorted(moments, key=lambda moment: moment not in first.values())[:n]


def _worst(result: Result, moment: Mapping[Any, Any]) -> Moment | None:
    """Choose a frame for one of `worst_moments`, or None if X and Y hardly differ in it."""
    kind, encounter = moment["kind"], _about(result, moment)
    loser = LOSER[kind]
    row = _clearest_row(result, moment, encounter, loser)
    losing, other = (result.x, result.y) if loser == "x" else (result.y, result.x)
    lower, higher = float(losing.similarity[row]), float(other.similarity[row])
    title = KINDS[kind]
    if kind.endswith("better"):
        if higher - lower < LEAST_LEAD:
            return None
        title = f"{title} ({higher:.2f} to {lower:.2f})"
    return Moment(row, title, str(moment["reason"]), encounter, loser)


def _clearest_row(result: Result, moment: Mapping[Any, Any], encounter: int, loser: str) -> int:
    """Return the frame with the worst similarity in which the moment's pedestrian is missed."""
    if encounter < 0:
        return int(moment["row"])
    encounters, frames = result.encounters, result.dataset.frame_columns
    recording = int(moment["recording_index"])
    begin, end = frames.first[recording : recording + 2]
    ends = [moment["first_frame"], moment["last_frame"]]
    first, last = begin + np.searchsorted(frames.frame[begin:end], ends)
    start, stop = encounters.offsets[encounter : encounter + 2]
    frame_rows, boxes = encounters.frame_index[start:stop], encounters.order[start:stop]
    losing, other = (result.x, result.y) if loser == "x" else (result.y, result.x)
    is_missed = ~losing.matches.is_matched[boxes] & (frame_rows >= first) & (frame_rows <= last)
    if not is_missed.any():
        return int(moment["row"])
    cost = losing.similarity[frame_rows]
    if moment["kind"].endswith("better"):
        cost = cost - other.similarity[frame_rows]
    return int(frame_rows[np.argmin(np.where(is_missed, cost, np.inf))])


def _is_shown(result: Result, moment: Moment, moments: Sequence[Moment]) -> bool:
    """Return whether `moments` contain the moment's frame or scene."""
    recording = result.dataset.frame_columns.recording
    time_s = result.dataset.frames["time_s"].to_numpy()
    return any(
        previous.row == moment.row
        or (
            previous.loser == moment.loser
            and recording[previous.row] == recording[moment.row]
            and abs(time_s[previous.row] - time_s[moment.row]) < APART_S
        )
        for previous in moments
    )


def _about(result: Result, moment: Mapping[Any, Any]) -> int:
    """Return the encounter whose track a moment names, or -1 if it names none."""
    if pd.isna(moment["track"]):
        return -1
    encounters = result.encounters
    is_encounter = (encounters.recording == moment["recording_index"]) & (
        encounters.track == int(moment["track"])
    )
    return int(np.argmax(is_encounter)) if is_encounter.any() else -1


def _exclusive(result: Result, category: Category, winner: str, loser: str) -> list[Moment]:
    encounters = result.encounters
    detected_by, missed_by = (result.system(letter) for letter in (winner, loser))
    rows, frame_rows = encounters.order, encounters.frame_index
    of = np.repeat(np.arange(len(encounters)), np.diff(encounters.offsets))
    is_decisive = (result.category == category.value)[of] & (result.k_truth.k[rows] >= RELEVANT_K)
    is_decisive &= detected_by.matches.is_matched[rows] & ~missed_by.matches.is_matched[rows]
    of, frame_rows = of[is_decisive], frame_rows[is_decisive]
    lead = detected_by.similarity[frame_rows] - missed_by.similarity[frame_rows]
    order = np.argsort(-lead, kind="stable")
    _, first = np.unique(of[order], return_index=True)
    order = order[np.sort(first)]  # the clearest frame of each encounter
    # an encounter that the other system nearly detects says little, even with a clear frame
    missed_s, detected_s = (
        system.failures["severity_s"].to_numpy() for system in (missed_by, detected_by)
    )
    order = order[np.argsort((detected_s - missed_s)[of[order]], kind="stable")]
    recording = result.dataset.frame_columns.recording[frame_rows]
    time_s = result.dataset.frames["time_s"].to_numpy()[frame_rows]
    clearest: list[int] = []
    while len(order) and len(clearest) < EXCLUSIVE:
        index = int(order[0])
        clearest.append(index)
        is_same_scene = (recording[order] == recording[index]) & (
            np.abs(time_s[order] - time_s[index]) < APART_S
        )
        order = order[~is_same_scene]
    return [
        Moment(
            row=int(frame_rows[index]),
            title=f"Only {winner.upper()} detects",
            text=_coverage_text(result, int(of[index]), winner, loser),
            encounter=int(of[index]),
            loser=loser,
        )
        for index in clearest
    ]


def _coverage_text(result: Result, encounter: int, winner: str, loser: str) -> str:
    detected_by, missed_by = (result.system(letter) for letter in (winner, loser))
    kind = MissClass(missed_by.encounters["miss_class"].iloc[encounter])
    note = Note(
        "moments.coverage",
        track=result.encounters.track[encounter],
        winner=winner,
        loser=loser,
        detected=float(detected_by.encounters["coverage"].iloc[encounter]),
        missed=float(missed_by.encounters["coverage"].iloc[encounter]),
        failure=None if kind is MissClass.NONE else kind.value.replace("_", " "),
    )
    return say(note, result.objects)
