"""Small datasets for tests, written down box by box."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_LABEL, NO_TRACK, UNKNOWN_OCCLUSION
from nvcore.dataset.tables import dataset_from_tables
from nvcore.settings.params import Params

NAN = float("nan")


class Box(NamedTuple):
    """One box; plain tuples that start with (frame, x, y, w, h, track) do as well."""

    frame: int
    x: float
    y: float
    w: float
    h: float
    track: int = NO_TRACK
    score: float = NAN
    ignore: bool = False
    distance_m: float = NAN
    occlusion: int = UNKNOWN_OCCLUSION
    label: int = NO_LABEL
    detectability: float = NAN
    recording: int = 0

    @property
    def centre(self) -> float:
        return self.x + self.w / 2


class Place(NamedTuple):
    """One recording: its listed frames, size, frame rate, horizon and traffic context."""

    frames: Sequence[int]
    width: float = 100.0
    height: float = 100.0
    fps: float = 10.0
    horizon: float = NAN
    context: float = NAN


def at(frame: int, centre: float, **more: Any) -> Box:
    """Box of 2 x 50 px around a lateral position, foot point in row 90."""
    w, h = more.pop("w", 2.0), more.pop("h", 50.0)
    foot = more.pop("foot", 90.0)
    return Box(frame, centre - w / 2, foot - h, w, h, **more)


def make_dataset(
    truth: Iterable[Sequence[Any]] = (),
    x: Iterable[Sequence[Any]] = (),
    y: Iterable[Sequence[Any]] = (),
    *,
    n_frames: int | None = None,
    frames: Sequence[int] | None = None,
    places: Sequence[Place] | None = None,
    labels: tuple[str, ...] = (),
    is_independent: bool = True,
    **size: float,
) -> Dataset:
    """A dataset of the systems "x" and "y".

    Frames are 0..n_frames - 1, or as listed; by default up to the last one with a box. `size`:
    width, height, fps, horizon of the only recording (100, 100, 10, unknown). `places` describes
    several recordings instead, which are said to be independent, though many have the same boxes.
    `labels` are what the boxes' labels count.
    """
    sources = [[Box(*box) for box in boxes] for boxes in (truth, x, y)]
    if places is None:
        if frames is None:
            last = max((box.frame for boxes in sources for box in boxes), default=-1)
            frames = range(last + 1 if n_frames is None else n_frames)
        places = [Place(frames, **size)]
    row_of, n_rows = {}, 0
    for number, place in enumerate(places):
        for frame in place.frames:
            row_of[number, frame] = n_rows
            n_rows += 1
    rows = [
        (source, row_of[box.recording, box.frame], *box[1:-1])
        for source, boxes in enumerate(sources)
        for box in boxes
    ]
    boxes = pd.DataFrame(rows, columns=["source", "frame_index", *Box._fields[1:-1]])
    recordings = pd.DataFrame(
        [(f"r{i}", *p[1:3], float(p.fps), p.horizon, p.context) for i, p in enumerate(places)],
        columns=["name", "width", "height", "fps", "horizon", "context"],
    )
    if is_independent:
        recordings["unit"] = recordings["name"]
    listed = [np.array(place.frames, dtype=np.int64) for place in places]
    return dataset_from_tables(recordings, listed, boxes, ["x", "y"], labels=labels)


def tagged(dataset: Dataset, *tags: tuple[str, ...]) -> Dataset:
    """The dataset with tags, one tuple for each recording."""
    column = pd.Series(list(tags), dtype=object)
    return replace(dataset, recordings=dataset.recordings.assign(tags=column))


def result_of(dataset: Dataset, **params: Any) -> Result:
    """`analyse` with parameters by name; proximity "none" unless given."""
    return compare(dataset, Params(**{"proximity": "none", **params}))
