"""Clips: parts of recordings around events, rated and compared one by one."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.metrics.encounters import RELEVANT_K

LENGTH_S: Final = 15.0
"""Length of a clip in the paper's study."""
LEAD_S: Final = 5.0
"""Time from the beginning of a clip to its event. (Our choice.)"""
ROUNDING_S: Final = 5e-4
"""Frames this much before a start or end count as at it, because starts and ends are rounded."""
_STRETCH: Final = re.compile(r"(.+) \[(\d+(?:\.\d+)?)-(\d+(?:\.\d+)?) s\]", re.DOTALL)


def clip_name(recording: str, start_s: float, end_s: float) -> str:
    """Return a clip's name in tables of ratings. Without a start, the clip is the whole recording.

    Examples
    --------
    >>> clip_name("night", 12.0, 27.0), clip_name("night", np.nan, np.nan)
    ('night [12-27 s]', 'night')
    """
    return recording if np.isnan(start_s) else f"{recording} [{start_s:.10g}-{end_s:.10g} s]"


def stretch_of(clip: str) -> tuple[str, float, float]:
    """Undo `clip_name`. Return recording, start and end (s since first frame, NaN: all of it)."""
    known = _STRETCH.fullmatch(clip)
    return (clip, np.nan, np.nan) if known is None else (known[1], float(known[2]), float(known[3]))


def cut_clips(
    result: Result, *, length_s: float = LENGTH_S, lead_s: float = LEAD_S
) -> pd.DataFrame:
    """Cut clips around the encounters and the false-alert episodes of both systems.

    An event begins with the first relevant frame (``k >= 0.5``) of an encounter, or with a
    false-alert episode. In order of time, each event gets a clip that begins `lead_s` before it and
    lasts `length_s`, unless the event begins inside the previous clip and so belongs to that one.
    Clips do not overlap: one begins where the previous one ends, if that is later. A clip that
    would reach beyond the end of the recording begins earlier if possible, or else is shorter.

    Returns
    -------
    ``clip`` (`clip_name`), ``recording``, ``start_s``, ``end_s`` (since its first frame, rounded to
    1 ms), ``reason`` (kinds of events that begin in the clip). A clip has the frames from its start
    to before its end. Without events there are no rows.

    Raises
    ------
    InputError
        If a clip would end before its event begins.
    """
    if not 0 <= lead_s < length_s:
        raise InputError(
            f"a clip of {length_s:g} s begins 0 to {length_s:g} s before what it shows; got "
            f"{lead_s:g} s"
        )
    frames, encounters = result.dataset.frame_columns, result.encounters
    time_s = result.dataset.frames["time_s"].to_numpy()
    boxes = encounters.order[result.k_truth.k[encounters.order] >= RELEVANT_K]
    # ordered by encounter and frame: the first row of each is where it begins to count
    of, first = np.unique(encounters.encounter_of[boxes], return_index=True)
    rows = [result.dataset.truth.frame_index[boxes[first]]]
    reasons = [f"encounter {track}" for track in encounters.track[of]]
    for _, system in result.sides:
        rows.append(system.episodes["first_row"].to_numpy())
        reasons += [f"false alert of {system.name}"] * len(system.episodes)
    row = np.concatenate(rows).astype(np.int64)
    names = result.dataset.recordings["name"].astype(str).to_numpy()
    clips: list[list[Any]] = []
    last_recording, end_s = -1, 0.0
    # over what happens: each clip depends on the one before
    for i in np.argsort(row, kind="stable"):
        recording, begin_s = int(frames.recording[row[i]]), float(time_s[row[i]])
        if recording != last_recording:
            last_recording, end_s = recording, 0.0
        elif begin_s < end_s:
            clips[-1][-1] |= {reasons[i]: None}
            continue
        last = frames.first[recording + 1] - 1
        whole_s = float(time_s[last] + frames.step_s[last])
        start_s = max(min(begin_s - lead_s, whole_s - length_s), end_s)
        start_s, end_s = round(start_s, 3), round(min(start_s + length_s, whole_s), 3)
        clips.append([names[recording], start_s, end_s, {reasons[i]: None}])
    return pd.DataFrame(
        [(clip_name(*clip[:3]), *clip[:3], "; ".join(clip[3])) for clip in clips],
        columns=["clip", "recording", "start_s", "end_s", "reason"],
    )


def rows_between(dataset: Dataset, recording: int, start_s: float, end_s: float) -> range:
    """Return the rows of frames from a start to before an end, s. NaN: of the whole recording."""
    own = dataset.frame_columns.rows_of(recording)
    if np.isnan(start_s):
        return range(own.start, own.stop)
    time_s = dataset.frames["time_s"].to_numpy()[own]
    first, stop = np.searchsorted(time_s, np.array([start_s, end_s]) - ROUNDING_S)
    return range(own.start + int(first), own.start + int(stop))


def compare_clips(result: Result, clips: Iterable[str]) -> Result:
    """Return the comparison in which each of these clips is a recording of its own, by its name.

    A miss that begins before a clip begins with it, and recency counts to its end. Clips from other
    comparisons are skipped.

    Returns
    -------
    `result` itself if no clip is only a part of a recording.
    """
    dataset = result.dataset
    place = {str(name): i for i, name in enumerate(dataset.recordings["name"])}
    names: list[str] = []
    parents: list[int] = []
    rows: list[range] = []
    for clip in dict.fromkeys(clips):  # over clips
        recording, start_s, end_s = (clip, np.nan, np.nan) if clip in place else stretch_of(clip)
        if recording in place:
            own = rows_between(dataset, place[recording], start_s, end_s)
            if own or np.isnan(start_s):  # skip clips beyond the end
                names, parents, rows = [*names, clip], [*parents, place[recording]], [*rows, own]
    if set(names) <= set(place):
        return result
    frame = dataset.frames["frame"].to_numpy()
    boxes = dataset.boxes.sort_values("frame_index", kind="stable")
    box_rows, parts, n_rows = boxes["frame_index"].to_numpy(), [], 0
    for own in rows:  # over clips
        inside = boxes.iloc[slice(*np.searchsorted(box_rows, (own.start, own.stop)))]
        parts.append(inside.assign(frame_index=inside["frame_index"] - own.start + n_rows))
        n_rows += len(own)
    recordings = dataset.recordings.iloc[parents].reset_index(drop=True)
    units = recordings["unit"].where(recordings["unit"] != "", recordings["name"])
    cut = dataset_from_tables(
        recordings.assign(name=names, unit=units),
        [frame[own.start : own.stop] for own in rows],
        pd.concat(parts),
        dataset.systems,
        settings=dataset.settings,
        labels=dataset.labels,
        of_subjects=dataset.of_subjects,
    )
    return compare(cut, result.params, x=result.x.name, y=result.y.name)
