"""Split of a training by physical object, by recording or by time."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.detectors.arguments import TrainArguments
from nvcore.errors import InputError, ParameterError
from nvcore.schema import NO_TRACK
from nvcore.settings import as_names
from nvcore.wording import MOST_NAMED, did_you_mean, listed, one_line

_LEAST_RECORDINGS: Final = 4
"""Minimum number of recordings to hold out whole ones where objects have no tracks."""


class Split(NamedTuple):
    """Frames and boxes of a training that are held out.

    Attributes
    ----------
    is_held_out
        Boxes of the truth, bool, (n_truth,).
    has_background
        Rows of the frames table that are trained on, bool, (n_frames,).
    is_left_out
        Rows that are on neither side, bool, (n_frames,).
    words
        Description of what was held out.
    """

    is_held_out: NDArray[np.bool_]
    has_background: NDArray[np.bool_]
    is_left_out: NDArray[np.bool_]
    words: str


def split_frames(
    dataset: Dataset,
    rows: NDArray[np.int64],
    objects: NDArray[np.int64],
    arguments: TrainArguments,
) -> Split:
    """Choose what is held out of the chosen frames.

    Parameters
    ----------
    rows
        Of the frames table, those chosen, ascending.
    objects
        Rows of the truth's boxes to learn in these frames, at least one.
    arguments
        Kind of the split, and which.

    Raises
    ------
    InputError
        If a recording to be held out is not there, or none is left to learn from.
    ParameterError
        If the split is not possible.
    """
    frames, frame_of = dataset.frame_columns, dataset.truth.frame_index[objects]
    recording: NDArray[Any] = dataset.recordings["name"].to_numpy()[frames.recording[rows]]
    track, share, seed = dataset.truth.track[objects], arguments.share, arguments.seed
    has_tracks = bool((track != NO_TRACK).all())
    by, is_left_out = arguments.split, np.zeros(len(dataset.frames), np.bool_)
    if by == "auto":
        by = "recording" if len(set(recording)) >= _LEAST_RECORDINGS else "time"
        by = "object" if has_tracks else by
    if arguments.hold_out:
        names = _recordings_named(arguments, dataset, list(dict.fromkeys(recording.tolist())))
        is_out, words = np.isin(recording, names), one_line(listed(names))
    elif by == "object":
        if not has_tracks:
            raise ParameterError(
                "split: the truth has boxes without a track, so that it is not known which are of "
                "one object; split by recording or time"
            )
        groups = list(zip(frames.recording[frame_of].tolist(), track.tolist(), strict=True))
        is_held_out = np.zeros(len(dataset.truth), np.bool_)
        is_held_out[objects] = is_object_out = by_group(groups, share, seed)
        n_out = len({group for group, out in zip(groups, is_object_out, strict=True) if out})
        words = f"{n_out} of {len(set(groups))} physical objects"
        return Split(is_held_out, ~is_left_out, is_left_out, words)
    elif by == "recording":
        is_out = by_group(recording.tolist(), share, seed)
        if not is_out.any():
            raise ParameterError(
                "split: a single recording cannot be split by recording; split by object or time"
            )
        words = one_line(listed(list(dict.fromkeys(recording[is_out].tolist()))))
    else:
        numbers = frames.recording[rows].astype(np.int64)
        is_trained, is_out = by_time(numbers, frames.frame[rows], share, arguments.gap)
        is_left_out[rows[~is_trained & ~is_out]] = True
        words = f"the last {100 * share:g} % of each recording"
    has_background, is_held_out = np.ones_like(is_left_out), np.zeros(len(dataset.truth), np.bool_)
    has_background[rows[is_out]] = False
    is_held_out[objects[np.isin(frame_of, rows[is_out])]] = True
    return Split(is_held_out, has_background, is_left_out, words)


def _recordings_named(
    arguments: TrainArguments, dataset: Dataset, known: Sequence[str]
) -> Sequence[str]:
    """Return the recordings to be held out, which all have to be among those known."""
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


def by_group(groups: Sequence[Hashable], share: float, seed: int) -> NDArray[np.bool_]:
    """Hold out whole groups, so that none is on both sides.

    Groups are recordings; or physical objects, where pictures are tracks of the same one.

    Parameters
    ----------
    groups
        Name of the group of each item, (n,).
    share
        Of the groups to be held out, rounded; where there are two or more, at least one is held
        out and one is not.

    Returns
    -------
    bool, (n,): whether each item is held out.

    Raises
    ------
    ParameterError
        Unless 0 < share < 1.
    """
    _check_share(share)
    names = list(dict.fromkeys(groups))
    n_out = min(max(1, round(share * len(names))), len(names) - 1)
    chosen = np.random.default_rng(seed).permutation(len(names))[: max(n_out, 0)]
    out = {names[i] for i in chosen}
    return np.array([group in out for group in groups], np.bool_)


def by_time(
    recording: NDArray[np.int64], frame: NDArray[np.int64], share: float, gap: int = 0
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Train on the beginning of each recording, hold out its end.

    Parameters
    ----------
    recording, frame
        Of each item, (n,).
    share
        Of each recording's frames, from its first to its last item, to be held out.
    gap
        Frames before the held-out part that are on neither side, since neighbours are alike.

    Returns
    -------
    Whether each item is trained on, and whether it is held out; bool, (n,).

    Raises
    ------
    ParameterError
        Unless 0 < share < 1 and the gap is at least 0.
    """
    _check_share(share)
    if gap < 0:
        raise ParameterError(f"gap: expected 0 or more frames, got {gap}")
    is_trained, is_out = np.zeros(len(frame), np.bool_), np.zeros(len(frame), np.bool_)
    for name in np.unique(recording):
        is_here = recording == name
        first, last = int(frame[is_here].min()), int(frame[is_here].max())
        border = first + round((1 - share) * (last - first + 1))
        is_out |= is_here & (frame >= border)
        is_trained |= is_here & (frame < border - gap)
    return is_trained, is_out


def _check_share(share: float) -> None:
    if not 0 < share < 1:
        raise ParameterError(f"share: expected more than 0 and less than 1, got {share:g}")
