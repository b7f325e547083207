"""The car's speed over the time of a recording: a CSV file that a session names for it.

    time_s,speed_kmh
    0.00,48.2
    0.10,48.0

Time is that of the recording: frame 0 is at 0 s, frame f at f / fps. Between two readings the
speed is on the line through them; before the first and after the last nothing is known of it.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.errors import InputError
from nvcore.inputs.added import Input
from nvcore.inputs.files import digest
from nvcore.inputs.hashes import changed_input
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.table import read_series
from nvcore.inputs.session import Session
from nvcore.schema import SAME_S
from nvcore.wording import count_text

SUBJECT: Final = "speed"
"""What the files are called in `Dataset.inputs`."""


def with_speeds(dataset: Dataset, session: Session) -> Dataset:
    """The dataset with the speeds of the series that its session names, frame by frame.

    A series goes before the one speed that a recording states. In frames outside of its readings
    that one counts, else the speed that is assumed.

    Raises
    ------
    InputError
        If a file cannot be used, has no reading, or knows none of its recording's frames; with
        file and line.
    """
    frames, names = dataset.frame_columns, dataset.recordings["name"].tolist()
    entries = session.of_all.entries(names)
    speed_kmh, n_frames = np.full(len(frames), np.nan), 0
    paths: list[str] = []
    for recording, name in enumerate(names):  # a loop over recordings: at most hundreds
        path = entries[name].speed if name in entries else None
        if path is None:
            continue
        rows = frames.rows_of(recording)
        time_s = frames.frame[rows] / frames.fps[recording]
        speed_kmh[rows] = _interpolated(session.folder / path, path, name, time_s)
        n_frames += len(time_s)
        paths.append(path)
    if not paths:  # those of recordings without frames
        return dataset
    n_known = np.count_nonzero(~np.isnan(speed_kmh))
    words = f"speed of the car in {n_known:,} of {count_text(n_frames, 'frame')} of "
    words += count_text(len(paths), "recording")
    if n_known < n_frames:
        words += (
            "; in the others, outside of the readings, the one speed that their recording states, "
            "else an assumed one"
        )
    digests = digest([SourceFile(session.folder / path, path) for path in paths])
    columns = {"file": paths, "sha256": digests}
    inputs = pd.DataFrame(columns).assign(subject=SUBJECT, format="csv", conversion=words)
    text = f"{dataset.fingerprint}\n{SUBJECT}\n".encode() + speed_kmh.tobytes()
    return replace(
        dataset,
        frames=dataset.frames.assign(speed_kmh=speed_kmh),
        inputs=pd.concat([dataset.inputs, inputs[list(dataset.inputs)]], ignore_index=True),
        findings=(
            *dataset.findings,
            *changed_input(SUBJECT, paths, digests, session.hashes),
        ),
        fingerprint=hashlib.sha256(text).hexdigest(),
    )


def _interpolated(file: Path, path: str, name: str, time_s: np.ndarray) -> np.ndarray:
    """Speed at these times of a recording, km/h; NaN outside of the readings."""
    at_s, readings = read_series(file, "speed_kmh", what="speeds")
    if not len(at_s):
        raise InputError("expected speeds of the car, found none below line 1", file=path)
    is_within = (time_s >= at_s[0] - SAME_S) & (time_s <= at_s[-1] + SAME_S)
    if not is_within.any():
        raise InputError(
            f"its readings, from {at_s[0]:g} to {at_s[-1]:g} s, are of none of the evaluated "
            f"frames of {name}, from {time_s[0]:g} to {time_s[-1]:g} s; expected seconds from "
            "frame 0",
            file=path,
        )
    return np.where(is_within, np.interp(time_s, at_s, readings), np.nan)


SPEEDS: Final = Input(
    SUBJECT,
    lambda session: any(entry.speed is not None for entry in session.recordings),
    with_speeds,
)
"""What a session says of the car's speed over time."""
