"""Moments worth looking at: the worst ones of each system, and the largest differences."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.similarity import runs_of
from nvcore.notes import Note, say
from nvcore.tables.lanes import miss_starts

NEVER: Final = -1
"""Frame row of an event that does not happen."""


def encounter_moments(result: Result) -> pd.DataFrame:
    """Find the frames of each encounter that are worth opening, as rows of the frames table.

    Returns
    -------
    One row per encounter, columns int64: first_row, the first relevant frame (of a distant
    encounter the first annotated one); missed_row_x and missed_row_y, the first relevant frame in
    which that system misses the pedestrian, -1 if it never does; shown_row, the costliest frame of
    the heavier failure (X's or Y's), preferably one in which the other system detects the
    pedestrian, or first_row without any failure.
    """
    encounters = result.encounters
    n, rows = len(encounters), encounters.order
    of = np.repeat(np.arange(n), np.diff(encounters.offsets))
    frame_row = encounters.frame_index
    is_relevant = result.k_truth.k[rows] >= RELEVANT_K
    first = _earliest(n, of[is_relevant], frame_row[is_relevant])
    first = np.where(first == NEVER, encounters.first_row, first)
    moments = {"first_row": first}
    is_new = np.ones(len(of), bool)
    is_new[1:] = (np.diff(of) != 0) | (np.diff(frame_row) != 0)
    start, place = np.flatnonzero(is_new), np.cumsum(is_new) - 1

    def either(is_so: np.ndarray) -> np.ndarray:
        """Return whether the condition holds for any box of the same pedestrian in the frame.

        A track that occurs twice in a frame is one pedestrian.
        """
        of_any: np.ndarray = np.logical_or.reduceat(is_so, start)[place]
        return of_any

    is_missed_by, is_detected_by = {}, {}
    for letter, system in result.sides:
        is_matched = system.matches.is_matched[rows]
        is_missed = is_relevant & ~either(is_relevant & is_matched)
        moments[f"missed_row_{letter}"] = _earliest(n, of[is_missed], frame_row[is_missed])
        is_missed_by[letter], is_detected_by[letter] = is_missed, either(is_matched)
    x, y = result.x.failures, result.y.failures
    is_of_y = (y["severity_s"] > x["severity_s"]).to_numpy()
    peak_row = np.where(is_of_y, y["peak_row"], x["peak_row"])
    shown_row = np.where(peak_row == NEVER, first, peak_row)
    is_alone = np.where(
        is_of_y[of],
        is_missed_by["y"] & is_detected_by["x"],
        is_missed_by["x"] & is_detected_by["y"],
    )
    alone = _costliest(encounters.offsets, result.cost[rows], is_alone, frame_row)
    moments["shown_row"] = np.where((peak_row == NEVER) | (alone == NEVER), shown_row, alone)
    return pd.DataFrame(moments).astype("int64")


def encounter_box(result: Result, encounter: int, row: int) -> np.ndarray:
    """Return the box (x, y, w, h, px) of an encounter's pedestrian in a frame.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    row
        Row of the frames table, one in which the pedestrian is annotated. If the track occurs
        there twice: its first box.

    Raises
    ------
    ValueError
        If the pedestrian is not annotated in this frame.
    """
    encounters, truth = result.encounters, result.dataset.truth
    start, stop = encounters.offsets[encounter : encounter + 2]
    position = start + np.searchsorted(encounters.frame_index[start:stop], row)
    if position == stop or encounters.frame_index[position] != row:
        raise ValueError(f"encounter {encounter} has no box in row {row} of the frames table")
    box = encounters.order[position]
    return np.array([truth.x[box], truth.y[box], truth.w[box], truth.h[box]])


class EncounterTime(NamedTuple):
    """Time for which an encounter's pedestrian counts, and for which X and Y miss it, seconds."""

    relevant_s: float
    missed_s_x: float
    missed_s_y: float


def encounter_time(result: Result, encounter: int) -> EncounterTime:
    """Return how long an encounter's pedestrian is relevant, and how long each system misses it.

    A distant encounter has none: all are 0. A track that occurs twice in a frame is one
    pedestrian, matched if either box is.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    """
    encounters, frames = result.encounters, result.dataset.frame_columns
    start, stop = encounters.offsets[encounter : encounter + 2]
    rows, frame_row = encounters.order[start:stop], encounters.frame_index[start:stop]
    is_relevant = result.k_truth.k[rows] >= RELEVANT_K
    relevant = np.unique(frame_row[is_relevant])
    missed = (
        np.setdiff1d(relevant, frame_row[system.matches.is_matched[rows]])
        for _, system in result.sides
    )
    fps = frames.fps[encounters.recording[encounter]]
    return EncounterTime(*(float(frames.gap[some].sum() / fps) for some in (relevant, *missed)))


def _costliest(
    offsets: np.ndarray, cost: np.ndarray, is_candidate: np.ndarray, frame_row: np.ndarray
) -> np.ndarray:
    """Return the first frame row in which each encounter's cost is largest, or `NEVER`.

    Only candidates count. Encounters without a candidate get `NEVER`.
    """
    n = len(offsets) - 1
    of = np.repeat(np.arange(n), np.diff(offsets))[is_candidate]
    largest = np.full(n, -np.inf)
    np.maximum.at(largest, of, cost[is_candidate])
    is_largest = cost[is_candidate] == largest[of]
    return _earliest(n, of[is_largest], frame_row[is_candidate][is_largest])


def _earliest(n: int, of: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the first value of each group, or `NEVER` for an empty group.

    Inputs are sorted by group and value.
    """
    earliest = np.full(n, NEVER, dtype=np.int64)
    is_first = np.ones(len(of), dtype=bool)
    is_first[1:] = of[1:] != of[:-1]
    earliest[of[is_first]] = values[is_first]
    return earliest


LEAST_DIFFERENCE: Final = 0.01
"""Least difference of similarities inside an interval. Smaller ones are noise in box positions."""


class _Span(NamedTuple):
    """An interval of frames. All of its rows refer to the frames table, both ends included."""

    kind: str
    first: int
    last: int
    row: int
    depth_s: float


def worst_moments(result: Result, *, n: int = 5) -> pd.DataFrame:
    """Find the intervals in which each system does worst and those in which X and Y differ most.

    Kinds ``"x"`` and ``"y"``: low-similarity intervals by depth. Kinds ``"x_better"`` and
    ``"y_better"``: maximal runs of consecutive listed frames in which that system's similarity is
    larger by more than 0.01, by the sum of difference times time step.

    Parameters
    ----------
    n
        Largest number of each kind.

    Returns
    -------
    Kind by kind, the deepest first: kind, recording, recording_index; first_frame and
    last_frame of the interval; row (of the frames table), frame, time_s and the similarities of
    the frame with the lowest similarity (kinds ``x``, ``y``) or the largest difference; depth_s
    and duration_s in seconds; reason, a sentence about the whole interval that calls the systems X
    and Y, and track, the pedestrian that it names, missing if it is about false alarms.
    """
    spans = [*_low_spans(result, n), *_difference_spans(result, n)]
    frames, columns = result.dataset.frames, result.dataset.frame_columns
    first, last, row = (
        np.array([getattr(span, name) for span in spans], dtype=np.int64)
        for name in ("first", "last", "row")
    )
    reasons = [_reason(result, span) for span in spans]  # a loop over a handful of moments
    recording = columns.recording[row].astype(np.int64)
    frame = frames["frame"].to_numpy()
    passed = columns.passed
    return pd.DataFrame(
        {
            "kind": np.array([span.kind for span in spans], dtype=object),
            "recording": result.dataset.recordings["name"].to_numpy(dtype=object)[recording],
            "recording_index": recording,
            "first_frame": frame[first],
            "last_frame": frame[last],
            "row": row,
            "frame": frame[row],
            "time_s": frames["time_s"].to_numpy()[row],
            "duration_s": (passed[last + 1] - passed[first]) / columns.fps[recording],
            "depth_s": np.array([span.depth_s for span in spans], dtype=float),
            "similarity_x": result.x.similarity[row],
            "similarity_y": result.y.similarity[row],
            "track": pd.array([note.fields.get("track") for note in reasons], dtype="Int64"),
            "reason": np.array([say(note, result.objects) for note in reasons], dtype=object),
        }
    )


def next_misses(result: Result, recording: int) -> np.ndarray:
    """Find the frames in which X or Y begins to miss a relevant pedestrian.

    Returns
    -------
    Rows within the recording (0: its first listed frame), increasing, unique; int64.
    """
    starts = [miss_starts(result, recording, system) for _, system in result.sides]
    first = result.dataset.frame_columns.first[recording]
    rows: np.ndarray = np.unique(np.concatenate(starts)) - first
    return rows


def _largest(depth_s: np.ndarray, n: int) -> np.ndarray:
    """Return the positions of the `n` largest values. Of equal values, the earlier comes first."""
    largest: np.ndarray = np.argsort(-depth_s, kind="stable")[:n]
    return largest


def _low_spans(result: Result, n: int) -> list[_Span]:
    spans = []
    for letter, system in result.sides:
        table = system.intervals
        worst = table.iloc[_largest(table["depth_s"].to_numpy(), n)]
        names = ("first_row", "last_row", "worst_row", "depth_s")
        values = zip(*(worst[name].tolist() for name in names), strict=True)
        spans += [_Span(letter, *value) for value in values]
    return spans


def _difference_spans(result: Result, n: int) -> list[_Span]:
    frames = result.dataset.frame_columns
    difference = result.x.similarity - result.y.similarity
    spans = []
    for kind, lead in (("x_better", difference), ("y_better", -difference)):
        is_clear = lead > LEAST_DIFFERENCE
        first, last = runs_of(np.where(is_clear, 0, -1), frames.recording)
        total = np.concatenate([[0.0], np.cumsum(np.where(is_clear, lead * frames.gap, 0))])
        rate = frames.fps[frames.recording[first]]
        depth_s = (total[last + 1] - total[first]) / rate
        for i in _largest(depth_s, n):
            row = first[i] + np.argmax(lead[first[i] : last[i] + 1])
            spans.append(_Span(kind, int(first[i]), int(last[i]), int(row), float(depth_s[i])))
    return spans


def _reason(result: Result, span: _Span) -> Note:
    """Explain what makes a moment as bad as it is.

    The reason names the pedestrian (or the false alarms) with the largest effect on similarity
    summed over the interval, not only in its worst frame.
    """
    worse, other = ("x", "y") if span.kind in ("x", "y_better") else ("y", "x")
    systems = dict(result.sides)
    system, frames = systems[worse], slice(span.first, span.last + 1)
    of_misses, of_alarms = system.distances.d_miss[frames], system.distances.d_false[frames]
    if span.kind.endswith("better"):  # what makes the difference
        rival = systems[other].distances
        of_misses, of_alarms = of_misses - rival.d_miss[frames], of_alarms - rival.d_false[frames]
    gap, alpha = result.dataset.frame_columns.gap[frames], result.params.alpha
    salient = system.distances.salient_row[frames]
    has_salient = salient >= 0
    encounter = result.encounters.encounter_of[salient[has_salient]]
    effect = np.bincount(
        encounter - encounter.min(initial=0), weights=(alpha * of_misses * gap)[has_salient]
    )
    if len(effect) and effect.max() >= ((1 - alpha) * of_alarms * gap).sum():
        worst = int(np.argmax(effect) + encounter.min(initial=0))
        return _miss_reason(result, span, worst, worse, other)
    return _alarm_reason(result, span, worse, system)


def _miss_reason(result: Result, span: _Span, encounter: int, worse: str, other: str) -> Note:
    encounters, system, rival = result.encounters, result.system(worse), result.system(other)
    start, stop = encounters.offsets[encounter : encounter + 2]
    inside = start + np.searchsorted(
        encounters.frame_index[start:stop], [span.first, span.last + 1]
    )
    rows, frame_row = encounters.order[slice(*inside)], encounters.frame_index[slice(*inside)]
    about = {
        "system": worse,
        "track": int(encounters.track[encounter]),
        "height_px": float(result.dataset.truth.h[rows].max()),
    }
    missed_rows, rival_missed_rows = (
        # a track that occurs twice in a frame is matched if either box is
        np.setdiff1d(frame_row, frame_row[scored.matches.truth_det[rows] >= 0])
        for scored in (system, rival)
    )
    apart_px, rival_px = (float(of.nearest.truth[rows].max()) for of in (system, rival))
    if not len(missed_rows):
        return Note("moments.near_miss", apart_px=apart_px, **about)
    n_matched = len(rival_matched := np.setdiff1d(missed_rows, rival_missed_rows))
    is_nearer = span.kind.endswith("better") and rival_px < apart_px
    return Note(
        "moments.miss",
        **about,
        other=other,
        missed=_lasting(result, span, missed_rows),
        is_matched=n_matched > 0,
        rival_s=_time_s(result, rival_matched) if 0 < n_matched < len(missed_rows) else None,
        rival_px=rival_px if is_nearer else None,
        apart_px=apart_px if np.isfinite(apart_px) else None,
    )


def _alarm_reason(result: Result, span: _Span, worse: str, system: SystemResult) -> Note:
    frames = np.arange(span.first, span.last + 1)
    n_alarms = system.false_alarms[frames]
    if not n_alarms.any():
        boxes = result.dataset.system(system.name)
        rows = boxes.rows_of(span.first, span.last + 1)
        apart_px = system.nearest.detections[rows][system.matches.is_counted[rows]]
        return Note("moments.far_detections", system=worse, apart_px=float(apart_px.max()))
    lasting = _lasting(result, span, frames[n_alarms > 0])
    return Note("moments.false_alarms", system=worse, lasting=lasting, most=int(n_alarms.max()))


def _lasting(result: Result, span: _Span, frames: np.ndarray) -> Note:
    """Return how long some frames of an interval last, and how long the whole interval lasts."""
    whole_s = _time_s(result, np.arange(span.first, span.last + 1))
    return Note("moments.duration", part_s=_time_s(result, frames), whole_s=whole_s)


def _time_s(result: Result, frames: np.ndarray) -> float:
    """Return the total duration of some frames of one recording, seconds."""
    columns = result.dataset.frame_columns
    return float(columns.gap[frames].sum() / columns.fps[columns.recording[frames[0]]])
