"""Training pictures from a session: evaluated frames with pictures and their truth boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import InputError, ParameterError
from nvcore.common.wording import MOST_NAMED, count_text, did_you_mean, listed, one_line
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_LABEL, NO_TRACK
from nvcore.inputs.evaluated_frames import frames_there, parse_frames
from nvcore.inputs.facts import frames_from
from nvcore.metrics.detection.filtered_truth import filter_truth
from nvcore.pictures import RecordingPictures
from nvcore.settings.defaults import as_names
from nvcore.settings.protocols import Protocol
from nvcore.subjects.detectors.calls.arguments import TrainArguments
from nvcore.subjects.detectors.icf import IcfSettings
from nvcore.subjects.detectors.running.run import no_pictures
from nvcore.subjects.detectors.training.overlap import trained_part
from nvcore.subjects.detectors.training.shots import Shot, TrainingData, hold_out_groups

MOST_OBJECTS: Final = 5000
"""Maximum number of boxes to learn by default, because neighbouring frames are much alike."""
_HEAVY: Final = 2
_LEAST_RECORDINGS: Final = 4
"""Minimum number of recordings to hold out whole ones if objects have no tracks."""
_IGNORED, _LEARNED, _HELD_OUT = range(3)
"""Roles of a truth box in a training."""


def session_shots(
    dataset: Dataset, pictures: RecordingPictures, settings: IcfSettings, arguments: TrainArguments
) -> TrainingData:
    """Collect the frames of a session to learn from.

    Boxes are ignored, neither object nor background, if the truth flags them as ignored, the
    session's protocol leaves them out, they are mostly hidden or truncated, or they are lower than
    `TrainArguments.least_height`.

    Raises
    ------
    InputError
        If no frame has a picture, a recording to hold out does not exist, or none is left to learn
        from.
    ParameterError
        If the split is not possible.
    """
    frames, truth = dataset.frame_columns, dataset.truth
    names = dataset.recordings["name"].tolist()
    least = arguments.least_height
    if least is None:
        least = settings.object_height * settings.scales[0]
    rows, notes = _rows(dataset, pictures, frames_from(arguments.frames))
    counts = _counting(dataset, least)
    per_frame = np.bincount(truth.frame_index[counts], minlength=len(frames))
    every = arguments.every or max(1, -(-int(per_frame[rows].sum()) // MOST_OBJECTS))
    numbers, starts = np.unique(frames.recording[rows], return_index=True)
    parts = np.split(rows, starts[1:])
    trained_on = tuple(
        trained_part(dataset, names[number], *frames.frame[own[[0, -1]]].tolist())
        for number, own in zip(numbers, parts, strict=True)
    )
    rows = np.concatenate([own[::every] for own in parts])
    is_here = np.isin(truth.frame_index, rows)
    objects = np.flatnonzero(counts & is_here)
    if not len(objects):
        raise InputError(
            "no box of the truth can be learned: all are ignored, mostly hidden, cut off by the "
            "picture's edge or too low; choose other recordings or frames, or lower boxes"
        )
    split = _split(dataset, rows, objects, arguments)
    roles = np.full(len(truth), _IGNORED)
    roles[objects] = np.where(split.is_object_out, _HELD_OUT, _LEARNED)

    def shot(row: int, *, has_background: bool) -> Shot:
        number, of_frame = int(frames.recording[row]), truth.rows_of(row, row + 1)
        source = pictures.sources[number]
        across = source.width / float(frames.width[number])
        down = source.height / float(frames.height[number])
        boxes = np.stack([side[of_frame] for side in truth.xywh], axis=1)
        boxes = boxes * (across, down, across, down)
        role = roles[of_frame]
        codes = truth.label[of_frame][role == _LEARNED].tolist()
        return Shot(
            read=partial(source.read, int(pictures.indices[number][row - frames.first[number]])),
            source=str(names[number]),
            learned=boxes[role == _LEARNED],
            held_out=boxes[role == _HELD_OUT],
            ignored=boxes[role == _IGNORED],
            has_background=has_background,
            labels=tuple("" if code == NO_LABEL else dataset.labels[code] for code in codes),
        )

    shots = [
        shot(row, has_background=not is_out)
        for row, is_out, is_left_out in zip(
            rows.tolist(), split.is_out.tolist(), split.is_left_out.tolist(), strict=True
        )
        if not is_left_out
    ]
    is_ignored = is_here & ~counts
    n_low = int(np.count_nonzero(is_ignored & (truth.h < least)))
    n_others = int(np.count_nonzero(is_ignored)) - n_low
    if n_low:
        low = count_text(n_low, "box", "boxes")
        notes.append(f"{low} lower than the least height, {least:g} px")
    if n_others:
        notes.append(
            f"{count_text(n_others, 'box', 'boxes')} that do not count: ignored, mostly hidden, "
            "cut off by the edge, or left out by the session's protocol"
        )
    return TrainingData(shots, trained_on, every, split.words, tuple(notes))


def _rows(
    dataset: Dataset, pictures: RecordingPictures, asked: str | None
) -> tuple[NDArray[np.int64], list[str]]:
    """Return the rows of the frames asked for that have a picture, and notes about the others."""
    frames = dataset.frame_columns
    of_recording = [frames.rows_of(number) for number in range(len(dataset.recordings))]
    own_of = dict(
        zip(dataset.recordings["name"], (frames.frame[own] for own in of_recording), strict=True)
    )
    is_asked, has_picture = np.ones(len(frames), np.bool_), np.zeros(len(frames), np.bool_)
    if asked is not None:
        for rows, own in zip(of_recording, own_of.values(), strict=True):
            is_asked[rows] = np.isin(own, parse_frames(asked, Path(), own))
        if not is_asked.any():
            raise InputError(f"no evaluated frame is in {asked!r}: {frames_there(own_of)}")
    for number, index in pictures.indices.items():
        has_picture[of_recording[number]] = index >= 0
    if not (is_asked & has_picture).any():
        raise no_pictures(pictures, dataset)
    notes = []
    for number, (name, rows) in enumerate(zip(own_of, of_recording, strict=True)):
        n_asked, n_here = is_asked[rows].sum(), (is_asked & has_picture)[rows].sum()
        if 0 < n_here < n_asked:
            notes.append(f"{n_asked - n_here:,} of {n_asked:,} frames of {name}: no picture")
        elif n_asked and not n_here:
            notes.append(f"{name}: {pictures.notes.get(number) or 'no frame has a picture'}")
    return np.flatnonzero(is_asked & has_picture), [one_line(note) for note in notes]


def _counting(dataset: Dataset, least: float) -> NDArray[np.bool_]:
    """Return a mask of the boxes of the truth that are learned, bool, shape (n_truth,)."""
    of_session: Protocol = dataset.settings.protocol
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


class _Split(NamedTuple):
    """Held-out objects, bool, (n_objects,), and held-out frames, bool, (n_frames,).

    Skipped frames are on neither side. `words` describes what is held out.
    """

    is_object_out: NDArray[np.bool_]
    is_out: NDArray[np.bool_]
    is_left_out: NDArray[np.bool_]
    words: str


def _split(
    dataset: Dataset, rows: NDArray[np.int64], objects: NDArray[np.int64], arguments: TrainArguments
) -> _Split:
    """Choose what to hold out of these frame rows and truth boxes."""
    frames, share, seed = dataset.frame_columns, arguments.share, arguments.seed
    frame, numbers = frames.frame[rows], frames.recording[rows]
    recording = dataset.recordings["name"].to_numpy()[numbers].tolist()
    place = np.searchsorted(rows, dataset.truth.frame_index[objects])
    track = dataset.truth.track[objects]
    has_tracks = bool((track != NO_TRACK).all())
    by, is_left_out = arguments.split, np.zeros(len(rows), np.bool_)
    if by == "auto":
        by = "recording" if len(set(recording)) >= _LEAST_RECORDINGS else "time"
        by = "object" if has_tracks else by
    if arguments.hold_out:
        names = _recordings_named(arguments, dataset, list(dict.fromkeys(recording)))
        is_out, words = np.isin(recording, names), one_line(listed(names))
    elif by == "object":
        if not has_tracks:
            raise ParameterError(
                "split: the truth has boxes without a track, so that it is not known which are of "
                "one object; split by recording or time"
            )
        groups = list(zip(numbers[place].tolist(), track.tolist(), strict=True))
        is_object_out, out = hold_out_groups(groups, share, seed)
        words = f"{len(out)} of {len(set(groups))} physical objects"
        return _Split(is_object_out, is_left_out, is_left_out, words)
    elif by == "recording":
        is_out, held_out = hold_out_groups(recording, share, seed)
        if not held_out:
            raise ParameterError(
                "split: a single recording cannot be split by recording; split by object or time"
            )
        words = one_line(listed(held_out))
    else:
        first = frame[np.searchsorted(numbers, numbers)]
        last = frame[np.searchsorted(numbers, numbers, side="right") - 1]
        border = first + np.rint((1 - share) * (last - first + 1))
        is_out = frame >= border
        is_left_out = ~is_out & (frame >= border - arguments.gap)
        words = f"the last {100 * share:g} % of each recording"
    return _Split(is_out[place], is_out, is_left_out, words)


def _recordings_named(
    arguments: TrainArguments, dataset: Dataset, known: Sequence[str]
) -> Sequence[str]:
    """Return the recordings to hold out, which all have to be among the known ones."""
    names = as_names(arguments.hold_out)
    for name in names:
        if name in known:
            continue
        if name in dataset.recordings["name"].tolist():
            raise InputError(
                f"hold_out: {name!r} has no evaluated frame with a picture (among frames, if "
                "these are given)"
            )
        there = f"those here are {listed(known, most=MOST_NAMED)}"
        raise InputError(
            f"hold_out: there is no recording {name!r}, or it is not among those chosen "
            f"(only, tags); {did_you_mean(name, known, there)}"
        )
    if not {*known} - {*names}:
        raise InputError(
            "hold_out: every recording chosen is held out; one at least must be left to learn from"
        )
    return names
