"""Shots of a loaded session: evaluated frames with pictures, and the boxes of their truth."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import TrainedOn
from nvcore.detection.filtered_truth import filter_truth
from nvcore.detectors.arguments import TrainArguments
from nvcore.detectors.icf import IcfSettings
from nvcore.detectors.run import no_pictures
from nvcore.detectors.training.overlap import trained_part
from nvcore.detectors.training.shots import Shot, TrainingData
from nvcore.detectors.training.split import Split, split_frames
from nvcore.errors import InputError
from nvcore.inputs.evaluated_frames import frames_there, parse_frames
from nvcore.inputs.facts import frames_from
from nvcore.pictures import RecordingPictures
from nvcore.protocols import Protocol
from nvcore.schema import NO_LABEL
from nvcore.wording import count_text, one_line

MOST_OBJECTS: Final = 5000
"""Boxes that are learned unless the caller asks for every frame: neighbours are much alike."""
_HEAVY: Final = 2


def session_shots(
    dataset: Dataset, pictures: RecordingPictures, settings: IcfSettings, arguments: TrainArguments
) -> TrainingData:
    """The frames of a session to learn from.

    Boxes that the session's protocol leaves out, that are mostly hidden, cut off by the picture's
    edge or lower than `TrainArguments.least_height` are neither object nor background, like those
    that the truth flags as ignored.

    Raises
    ------
    InputError
        If no frame has a picture, or a recording to be held out is not there.
    ParameterError
        If the split is not possible.
    """
    rows, notes = _rows(dataset, pictures, frames_from(arguments.frames))
    counts = _counting(dataset, settings, arguments)
    every = arguments.every or _sparse(dataset, rows, counts)
    trained_on = _parts(dataset, rows)
    rows = _thinned(dataset, rows, every)
    is_here = np.zeros(len(dataset.frames), np.bool_)
    is_here[rows] = True
    objects = np.flatnonzero(counts & is_here[dataset.truth.frame_index])
    if not len(objects):
        raise InputError(
            "no box of the truth can be learned: all are ignored, mostly hidden, cut off by the "
            "picture's edge or too low; choose other recordings or frames, or lower boxes"
        )
    split = split_frames(dataset, rows, objects, arguments)
    shots = [
        _shot(dataset, pictures, int(row), counts, split) for row in rows[~split.is_left_out[rows]]
    ]
    notes += _left_out(dataset, is_here, counts, _least_height(settings, arguments))
    return TrainingData(shots, trained_on, every, split.words, tuple(notes))


def _left_out(
    dataset: Dataset, is_here: NDArray[np.bool_], counts: NDArray[np.bool_], least: float
) -> list[str]:
    """Say how many boxes of these frames are neither object nor background, and why."""
    is_out = is_here[dataset.truth.frame_index] & ~counts
    is_low = is_out & (dataset.truth.xywh[3] < least)
    n_low, n_others = int(is_low.sum()), int((is_out & ~is_low).sum())
    boxes = "box", "boxes"
    parts = {
        f"{count_text(n_low, *boxes)} lower than the least height, {least:g} px": n_low,
        f"{count_text(n_others, *boxes)} that do not count: ignored, mostly hidden, cut off by the "
        "edge, or left out by the session's protocol": n_others,
    }
    return [text for text, n in parts.items() if n]


def _rows(
    dataset: Dataset, pictures: RecordingPictures, frames_asked: str | None
) -> tuple[NDArray[np.int64], list[str]]:
    """Rows of the frames table that have a picture, and which have none."""
    frames = dataset.frame_columns
    names = dataset.recordings["name"].tolist()
    has_picture = np.zeros(len(frames), np.bool_)
    for number, index in pictures.indices.items():
        has_picture[frames.rows_of(number)] = index >= 0
    asked = np.flatnonzero(_asked(dataset, frames_asked))
    rows = asked[has_picture[asked]]
    if not len(rows):
        raise no_pictures(pictures, dataset)
    n_asked, n_here = (
        np.bincount(frames.recording[which], minlength=len(names)) for which in (asked, rows)
    )
    notes = []
    for number in np.flatnonzero(n_here < n_asked).tolist():
        if n_here[number]:
            n_without = n_asked[number] - n_here[number]
            notes.append(
                f"{n_without:,} of {n_asked[number]:,} frames of {names[number]}: no picture"
            )
        else:
            reason = pictures.notes.get(number) or "no frame has a picture"
            notes.append(f"{names[number]}: {reason}")
    return rows, [one_line(note) for note in notes]


def _asked(dataset: Dataset, frames: str | None) -> NDArray[np.bool_]:
    """Return a mask of the evaluated frames that the user asks for, bool, shape (n_frames,)."""
    columns = dataset.frame_columns
    is_asked = np.full(len(columns), frames is None)
    if frames is None:
        return is_asked
    own_of = {
        name: columns.frame[columns.rows_of(number)]
        for number, name in enumerate(dataset.recordings["name"])
    }
    for number, own in enumerate(own_of.values()):
        is_asked[columns.rows_of(number)] = np.isin(own, parse_frames(frames, Path(), own))
    if not is_asked.any():
        raise InputError(f"no evaluated frame is in {frames!r}: {frames_there(own_of)}")
    return is_asked


def _counting(
    dataset: Dataset, settings: IcfSettings, arguments: TrainArguments
) -> NDArray[np.bool_]:
    """Return a mask of the ground-truth boxes that are learned, bool, shape (n_truth,)."""
    of_session: Protocol = dataset.settings.protocol
    least = _least_height(settings, arguments)
    low, high = of_session.height_px
    left, top, right, bottom = of_session.border_px or (1.0,) * 4
    protocol = replace(
        of_session,
        height_px=(max(low, least), max(high, least)),
        occlusion=tuple(level for level in of_session.occlusion if level != _HEAVY) or (_HEAVY,),
        border_px=(max(left, 1.0), max(top, 1.0), max(right, 1.0), max(bottom, 1.0)),
        tags=(),
        recordings=(),
    )
    return filter_truth(dataset, protocol).counts


def _least_height(settings: IcfSettings, arguments: TrainArguments) -> float:
    """Lower boxes are left out, px."""
    if arguments.least_height is None:
        return settings.object_height * settings.scales[0]
    return arguments.least_height


def _sparse(dataset: Dataset, rows: NDArray[np.int64], counts: NDArray[np.bool_]) -> int:
    """The least step between frames with which there are few enough boxes."""
    per_frame = np.bincount(dataset.truth.frame_index[counts], minlength=len(dataset.frames))
    return max(1, -(-int(per_frame[rows].sum()) // MOST_OBJECTS))


def _thinned(dataset: Dataset, rows: NDArray[np.int64], every: int) -> NDArray[np.int64]:
    """Every so many rows of each recording."""
    recording = dataset.frame_columns.recording[rows]
    place = np.arange(len(rows)) - np.searchsorted(recording, recording)
    thinned: NDArray[np.int64] = rows[place % every == 0]
    return thinned


def _shot(
    dataset: Dataset,
    pictures: RecordingPictures,
    row: int,
    counts: NDArray[np.bool_],
    split: Split,
) -> Shot:
    frames, truth = dataset.frame_columns, dataset.truth
    number = int(frames.recording[row])
    source = pictures.sources[number]
    index = int(pictures.indices[number][row - int(frames.first[number])])
    across = source.width / float(frames.width[number])
    down = source.height / float(frames.height[number])
    of_frame = truth.rows_of(row, row + 1)
    boxes = np.stack([side[of_frame] for side in truth.xywh], axis=1)
    boxes = boxes * (across, down, across, down)
    is_object, is_out = counts[of_frame], split.is_held_out[of_frame]
    codes = truth.label[of_frame][is_object & ~is_out].tolist()
    return Shot(
        read=partial(source.read, index),
        source=str(dataset.recordings["name"].iloc[number]),
        learned=boxes[is_object & ~is_out],
        held_out=boxes[is_object & is_out],
        ignored=boxes[~is_object],
        has_background=bool(split.has_background[row]),
        labels=tuple("" if code == NO_LABEL else dataset.labels[code] for code in codes),
    )


def _parts(dataset: Dataset, rows: NDArray[np.int64]) -> tuple[TrainedOn, ...]:
    """List what to note of the training: for each recording, its first to its last frame."""
    frames = dataset.frame_columns
    recording, frame = frames.recording[rows], frames.frame[rows]
    return tuple(
        trained_part(
            dataset,
            str(dataset.recordings["name"].iloc[number]),
            int(frame[recording == number].min()),
            int(frame[recording == number].max()),
        )
        for number in np.unique(recording)
    )
