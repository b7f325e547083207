"""Turn the output of a system into alerts, and judge each alert against the ground truth.

A policy sees only what the system has at run time: boxes, scores, tracks (boxes are linked over
frames if it reports none), reported distances, the weight k of a box. The truth decides the kind of
an alert afterwards. Only the oracle uses the truth beforehand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import NO_TRACK, SAME_S, DetectionState
from nvcore.inputs.session import Session
from nvcore.metrics.encounters import RELEVANT_K, Encounters
from nvcore.metrics.linking import LINK_GAP, track_truth
from nvcore.metrics.matching import Matches
from nvcore.settings.params import Params
from nvcore.subjects.alerts.inputs import AlertInputs, AlertLog, places_of
from nvcore.subjects.alerts.kernels import switch_alerts
from nvcore.subjects.time_left.judging import is_outside
from nvcore.subjects.time_left.kinds import Urgency


class AlertKind(StrEnum):
    """Kinds of alerts by how justified they are. An alert gets the first kind that applies."""

    IGNORED = "ignored"
    FALSE = "false"
    NUISANCE = "nuisance"
    REDUNDANT = "redundant"
    NEEDED = "needed"
    WANTED = "wanted"


ALERT_TEXT: Final[dict[AlertKind, str]] = {
    AlertKind.IGNORED: "Alerts about what the ground truth ignores: neither right nor wrong.",
    AlertKind.FALSE: "Alerts whose boxes match {nobody}, and nothing that is ignored.",
    AlertKind.NUISANCE: "Alerts about {a_one} {who} is not urgent, and far or outside of the "
    "corridor when they begin.",
    AlertKind.REDUNDANT: "Alerts about {a_one} {whom} the driver has seen before they begin.",
    AlertKind.NEEDED: "Alerts about {a_one} {whom} the driver has not seen when they begin.",
    AlertKind.WANTED: "Alerts that are redundant or needed: whether the driver sees the {one} is "
    "not known.",
}
UNWANTED: Final = (AlertKind.FALSE, AlertKind.NUISANCE, AlertKind.REDUNDANT)
"""Kinds of alerts that the driver would rather not have had."""
RESTS_ON_DRIVER: Final = (AlertKind.REDUNDANT, AlertKind.NEEDED)
"""Kinds whose number is undefined if no pedestrian's detectability is known."""

NO_ALERTS: Final = pd.DataFrame(
    {
        "recording": np.empty(0, np.int64),
        "first_row": np.empty(0, np.int64),
        "last_row": np.empty(0, np.int64),
        "track": np.empty(0, np.int64),
        "encounter": np.empty(0, np.int64),
        "kind": np.empty(0, object),
        "log_kind": np.empty(0, object),
    }
)
"""Alerts of one system: recording, first_row and last_row (of the frames), track (of the system, or
the number of its linked boxes within the recording, or `NO_TRACK`), encounter (-1: none), kind
(`AlertKind`), log_kind (the log's own word, or empty)."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Ground truth, urgency and driver's view against which alerts are judged.

    Attributes
    ----------
    k_truth
        Proximity weight of each truth box; float64, shape (n_truth,).
    urgency
        Result of `nvcore.subjects.time_left.judging.find_urgent`.
    seen
        Result of `nvcore.subjects.driver.comparison.judging.judge_driver`.
    corridor
        Limit of the corridor: distance from the middle as a share of half the width.
    """

    dataset: Dataset
    encounters: Encounters
    k_truth: np.ndarray
    urgency: pd.DataFrame
    seen: pd.DataFrame
    corridor: float

    def is_before(self, name: str, encounter: np.ndarray, row: np.ndarray) -> np.ndarray:
        """Return whether an event in `seen` precedes the given frame rows, bool, shape (n,).

        ``confirmed_row``: the driver has seen the encounters by then. ``known_row``: by then it is
        known whether the driver sees them.
        """
        first = self.seen[name].to_numpy()[encounter]
        is_before: np.ndarray = (first >= 0) & (first < row)
        return is_before


@dataclass(frozen=True, eq=False)
class Reported:
    """Output of one system before any score threshold.

    Attributes
    ----------
    boxes, k
        Boxes of the system, and the proximity weight of each.
    matches
        Matches of the boxes. Boxes below a threshold may be marked so.
    """

    boxes: BoxColumns
    k: np.ndarray
    matches: Matches


def alerts_by_policy(
    scene: Scene, system: Reported, policy: Params, *, threshold: float
) -> pd.DataFrame:
    """Return the alerts that a policy derives from a system's output, with columns of `NO_ALERTS`.

    Parameters
    ----------
    threshold
        Boxes with a lower score are not reported. Boxes without a score are.
    """
    boxes, frames = system.boxes, scene.dataset.frame_columns
    is_in = ~(boxes.score < threshold) & (system.matches.state != DetectionState.BELOW)
    rows = np.flatnonzero(is_in)
    tracks = _Tracks(rows, track_truth(boxes.only(is_in), frames).track)
    is_near = system.k[rows] >= policy.alert_k
    if policy.alert_distance_m is not None:
        distance_m = boxes.distance_m[rows]
        is_near = np.where(np.isnan(distance_m), is_near, distance_m <= policy.alert_distance_m)
    alerting = is_near & ~is_outside(boxes, rows, frames, policy.alert_corridor)
    if policy.alert_oracle == "on":
        truth_row = system.matches.det_truth[rows]
        matched = np.flatnonzero(truth_row >= 0)
        encounter = scene.encounters.encounter_of[truth_row[matched]]
        row = boxes.frame_index[rows[matched]]
        alerting[matched] &= ~scene.is_before("confirmed_row", encounter, row)
    durations = (policy.alert_on_s, policy.alert_off_s, policy.alert_least_s, policy.alert_pause_s)
    return _judged(scene, system, tracks, alerting, [*map(float, durations)], step=1)


def alerts_by_log(scene: Scene, system: Reported, log: AlertLog) -> pd.DataFrame:
    """Return the alerts in a system's own log, with columns of `NO_ALERTS`.

    The flagged boxes of one track form an alert. A gap in the flags may be as long as a gap in a
    linked track. In a table an alert begins in the first listed frame at or after its start. Its
    boxes are those of its track, or all boxes of the system during the alert.
    """
    boxes, frames = system.boxes, scene.dataset.frame_columns
    tracks = _Tracks(np.arange(len(boxes)), track_truth(boxes, frames).track)
    if isinstance(log, np.ndarray):
        own = scene.dataset.boxes.iloc[boxes.first_row : boxes.first_row + len(boxes)]
        is_alerted = np.isin(places_of(own), log)
        return _judged(scene, system, tracks, is_alerted, [0.0] * 4, step=LINK_GAP + 1)
    table = _of_dataset(log, scene.dataset)
    first, stop = frames.first[table["recording"]], frames.first[table["recording"] + 1]
    # a single time axis for all recordings, separated by their longest duration
    time_s = scene.dataset.frames["time_s"].to_numpy()
    length_s = time_s.max(initial=0.0) + 1.0
    axis = time_s + frames.recording * length_s
    shift = table["recording"].to_numpy() * length_s
    begin = np.searchsorted(axis, table["start_s"].to_numpy() + shift - SAME_S)
    until = np.minimum(table["end_s"].to_numpy(), length_s - 0.5) + shift + SAME_S
    end = np.searchsorted(axis, until, side="right") - 1
    begin = np.clip(begin, first, stop - 1)
    alerts = table[["recording", "track", "log_kind"]].assign(
        first_row=begin, last_row=np.clip(end, begin, stop - 1)
    )
    # an alert without a track has all boxes of the system during the alert
    of_all = np.full(len(boxes), NO_TRACK)
    both = _Tracks(np.tile(tracks.rows, 2), np.concatenate([tracks.track, of_all]))
    return _with_kinds(scene, system, both, alerts)


@dataclass(frozen=True, eq=False)
class _Tracks:
    """Selected boxes of a system, each with its track number within the recording.

    `rows` are rows of the system's boxes. Both arrays are int64, shape (n,).

    Tracks that the system reports are kept. Other boxes are linked over frames.
    """

    rows: np.ndarray
    track: np.ndarray


def _judged(
    scene: Scene,
    system: Reported,
    tracks: _Tracks,
    alerting: np.ndarray,
    durations: Sequence[float],
    *,
    step: int,
) -> pd.DataFrame:
    """Merge boxes that call for an alert into alerts, and give each alert its kind."""
    frames = scene.dataset.frame_columns
    frame_index = system.boxes.frame_index[tracks.rows]
    recording = frames.recording[frame_index].astype(np.int64)
    key = _codes(recording, tracks.track)
    place = np.flatnonzero(alerting)
    place = place[np.lexsort((frame_index[place], key[place]))]
    onset, end, first = np.empty((3, len(place)), np.int64)
    rate = frames.fps[frames.recording]
    final_row, row = frames.first[frames.recording + 1] - 1, frame_index[place]
    time_s, end_s = frames.frame / rate, (frames.frame + frames.gap) / rate
    n = switch_alerts(
        key[place], row, final_row, time_s, end_s, *durations, step, onset, end, first
    )
    at = place[first[:n]]
    alerts = pd.DataFrame(
        {
            "recording": recording[at],
            "first_row": onset[:n],
            "last_row": end[:n],
            "track": tracks.track[at],
            "log_kind": pd.Series([""] * n, dtype=object),
        }
    )
    return _with_kinds(scene, system, tracks, alerts)


def _first_decided(
    scene: Scene, system: Reported, tracks: _Tracks, alerts: pd.DataFrame
) -> np.ndarray:
    """Find the box that decides the kind of each alert, as a row of boxes, or -1 if there is none.

    This is the first box that matches a pedestrian, else the first absorbed box: people are often
    ignored from afar, and annotated when they are near. The nearest box wins within a frame.
    """
    boxes, frames = system.boxes, scene.dataset.frame_columns
    decided = np.full(len(alerts), -1)
    for state in (DetectionState.MATCHED, DetectionState.ABSORBED):
        is_decided = system.matches.state[tracks.rows] == state
        rows, track = tracks.rows[is_decided], tracks.track[is_decided]
        frame_index = boxes.frame_index[rows]
        recording = np.concatenate([frames.recording[frame_index], alerts["recording"]])
        code = _codes(recording.astype(np.int64), np.concatenate([track, alerts["track"]]))
        first = code * len(frames)
        own, wanted = first[: len(rows)] + frame_index, first[len(rows) :]
        order = np.lexsort((-system.k[rows], own))
        rows, own = rows[order], own[order]
        place = np.searchsorted(own, wanted + alerts["first_row"].to_numpy())
        is_there = (place < len(own)) & (decided < 0)
        last = (wanted + alerts["last_row"].to_numpy())[is_there]
        is_there[is_there] = own[place[is_there]] <= last
        decided[is_there] = rows[place[is_there]]
    return decided


def _codes(recording: np.ndarray, track: np.ndarray) -> np.ndarray:
    """Number each box's track uniquely across recordings, int64, shape (n,)."""
    known, code = np.unique(track, return_inverse=True)
    codes: np.ndarray = recording * max(len(known), 1) + code
    return codes


def _with_kinds(
    scene: Scene, system: Reported, tracks: _Tracks, alerts: pd.DataFrame
) -> pd.DataFrame:
    """Add encounter and kind to each alert, and sort alerts by first frame."""
    decided = _first_decided(scene, system, tracks, alerts)
    truth, encounters, frames = scene.dataset.truth, scene.encounters, scene.dataset.frame_columns
    encounter = np.full(len(alerts), -1)
    has_box = np.flatnonzero(decided >= 0)
    truth_row = system.matches.det_truth[decided[has_box]]
    is_match = truth_row >= 0
    encounter[has_box[is_match]] = encounters.encounter_of[truth_row[is_match]]
    onset = alerts["first_row"].to_numpy()
    kinds = np.where(decided >= 0, AlertKind.IGNORED.value, AlertKind.FALSE.value).astype(object)
    matched = np.flatnonzero(encounter >= 0)
    who, row = encounter[matched], onset[matched]
    owner = np.repeat(np.arange(len(encounters)), np.diff(encounters.offsets))
    # the pedestrian's box in the frame in which the alert begins, or the next
    key = owner * len(frames) + encounters.frame_index
    at = encounters.order[np.searchsorted(key, who * len(frames) + row)]
    is_far = scene.k_truth[at] < RELEVANT_K
    is_far |= is_outside(truth, at, frames, scene.corridor)
    urgency = scene.urgency["urgency"].to_numpy()[who]
    is_not_urgent = ~np.isin(urgency, [Urgency.URGENT.value, Urgency.UNKNOWN.value])
    has_seen, is_known = (
        scene.is_before(name, who, row) for name in ("confirmed_row", "known_row")
    )
    kinds[matched] = np.select(
        [is_not_urgent & is_far, has_seen, is_known],
        [kind.value for kind in (AlertKind.NUISANCE, AlertKind.REDUNDANT, AlertKind.NEEDED)],
        AlertKind.WANTED.value,
    )
    judged = alerts.assign(encounter=encounter, kind=pd.Series(kinds, dtype=object).to_numpy())
    order = np.lexsort((judged["track"], judged["last_row"], judged["first_row"]))
    return judged.iloc[order][[*NO_ALERTS]].reset_index(drop=True)


def _of_dataset(table: pd.DataFrame, dataset: Dataset) -> pd.DataFrame:
    """Return the log rows of the dataset's recordings, replacing recording names by numbers.

    Finds recordings that the session renamed under their original names, too.
    """
    row_of = {name: row for row, name in enumerate(dataset.recordings["name"])}
    if isinstance(dataset.settings, Session):
        for entry in dataset.settings.recordings:
            if entry.title in row_of:
                row_of[entry.name] = row_of[entry.title]
    number = table["recording"].map(row_of)
    kept = table[number.notna()]
    return kept.assign(recording=number.dropna().astype(np.int64)).reset_index(drop=True)


def inputs_of(dataset: Dataset) -> AlertInputs:
    """Return the alert logs and alert policies of a session's systems. Fused systems have none."""
    named = dataset.of("alerts") if isinstance(dataset.settings, Session) else None
    return named or AlertInputs({}, {})


def policy_of(params: Params, dataset: Dataset, system: int) -> Params:
    """Return the settings with a system's own policy applied if its session names one."""
    return replace(params, **inputs_of(dataset).policies.get(system, {}))
