"""Speed of the car over time, from a CSV file for a recording.

    time_s,speed_kmh
    0.00,48.2
    0.10,48.0

Times are seconds since the recording's first evaluated frame, as `time_s` in all tables and on the
axis of the Timeline. The speed is interpolated linearly between readings. It is unknown before the
first, after the last, and between two readings that are far apart.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from nvcore.common.errors import InputError
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.dataset.schema import SAME_S
from nvcore.inputs.files.find import digest
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.table import read_series
from nvcore.inputs.session import Session
from nvcore.inputs.session.added import Input, with_files

SUBJECT: Final = "speed"
"""Name of the files in `Dataset.inputs`."""
LONGEST_GAP_S: Final = 5.0
"""Longest gap for interpolation, since cars can stop within it. (Our choice.)"""
FASTEST_KMH: Final = 400.0
"""Largest plausible speed. Higher readings are in another unit, or broken."""


def with_speeds(dataset: Dataset, session: Session) -> Dataset:
    """Return the dataset with the speed in each frame, from the files that its session names.

    A file takes precedence over the recording's single speed. Frames without a speed in the file
    use the single speed, else the assumed one.

    Raises
    ------
    InputError
        If a file cannot be used, has no reading, or knows none of its recording's frames; with
        file and line.
    """
    frames, names = dataset.frame_columns, dataset.recordings["name"].tolist()
    all_s = dataset.frames["time_s"].to_numpy()
    entries = session.of_all.entries(names)
    speed_kmh, n_frames = np.full(len(frames), np.nan), 0
    paths: list[str] = []
    for recording, name in enumerate(names):  # a loop over recordings: at most hundreds
        path = entries[name].speed if name in entries else None
        if path is None:
            continue
        time_s = all_s[rows := frames.rows_of(recording)]
        speed_kmh[rows] = _interpolated(session.folder / path, path, name, time_s)
        n_frames += len(time_s)
        paths.append(path)
    if not paths:  # those of recordings without frames
        return dataset
    n_known = np.count_nonzero(~np.isnan(speed_kmh))
    words = (
        f"speed of the car in {n_known:,} of {count_text(n_frames, 'frame')} of "
        f"{count_text(len(paths), 'recording')}"
    )
    if n_known < n_frames:
        words += (
            "; in the others, outside of the readings or between two more than "
            f"{LONGEST_GAP_S:g} s apart, the one speed that their recording states, else an "
            "assumed one"
        )
    return with_files(
        dataset,
        session,
        SUBJECT,
        paths,
        digest([SourceFile(session.folder / path, path) for path in paths]),
        says=f"{SUBJECT}\n".encode() + speed_kmh.tobytes(),
        conversion=words,
        frames=dataset.frames.assign(speed_kmh=speed_kmh),
    )


def _interpolated(file: Path, path: str, name: str, time_s: np.ndarray) -> np.ndarray:
    """Interpolate a recording's speed (km/h) at these times, NaN if readings are too far away."""
    zero = "the first evaluated frame"
    at_s, readings = read_series(file, "speed_kmh", what="speeds", high=FASTEST_KMH, zero=zero)
    if not len(at_s):
        raise InputError("expected speeds of the car, found none below line 1", file=path)
    before = np.searchsorted(at_s, time_s + SAME_S, side="right") - 1
    after = np.searchsorted(at_s, time_s - SAME_S)
    is_within = (before >= 0) & (after < len(at_s))
    if not is_within.any():
        raise InputError(
            f"its readings, from {at_s[0]:g} to {at_s[-1]:g} s, are of none of the evaluated "
            f"frames of {name}, from {time_s[0]:g} to {time_s[-1]:g} s; expected seconds from "
            f"{zero}",
            file=path,
        )
    gap_s = at_s[np.minimum(after, len(at_s) - 1)] - at_s[np.maximum(before, 0)]
    is_known = is_within & (gap_s <= LONGEST_GAP_S + SAME_S)
    return np.where(is_known, np.interp(time_s, at_s, readings), np.nan)


SPEEDS: Final = Input(
    SUBJECT,
    lambda session: any(entry.speed is not None for entry in session.recordings),
    with_speeds,
)
"""Files of a session with the car's speed over time."""
