"""Recordings too long to be scored at once: the systems piece by piece, the truth as a whole.

Most memory is of the systems' boxes. Steps that look at one frame at a time are made of pieces and
put together; what is then left of a system is what it made of each frame and each box of the truth,
and its false alarms. All that goes on over frames (tracks, encounters, events, intervals, episodes)
and the measures of the recording are made of the whole by the library's own steps, so that no digit
depends on where the cuts are, however long an encounter is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np

from nvcore.columns import BOX_COLUMNS, BoxColumns
from nvcore.comparison import TRUTH_STEPS, Result, compare
from nvcore.dataset import Dataset
from nvcore.metrics.encounters import encounters_of
from nvcore.metrics.false_alarms import find_episodes
from nvcore.metrics.linking import TruthTracks
from nvcore.metrics.matching import Matches
from nvcore.metrics.proximity import Weights
from nvcore.metrics.proximity.borrowing import borrows
from nvcore.metrics.similarity import Nearest, SetDistances
from nvcore.params import Params
from nvcore.scoring import Inputs, Made, Memo, SystemInputs, steps_of
from nvcore.scoring.system import STEPS

_NO_ROWS: Final = np.empty(0, np.int64)
_COUNTS: Final = ("n_det", "matched", "false_alarms")


class _Piece(NamedTuple):
    """What one system made of a piece, and the first row of its frames and of its truth boxes."""

    first_frame: int
    first_truth: int
    made: dict[str, Any]
    alarms: BoxColumns


def can_be_cut(params: Params) -> bool:
    """Whether no step needs all boxes of a system at once, as alerts and borrowed distances do."""
    return params.alerts == "off" and not borrows(params)


def compare_pieces(whole: Dataset, piece_of: Callable[[int, int], Dataset], most: int) -> Result:
    """The comparison of one recording, its systems scored in pieces of at most `most` frames.

    Parameters
    ----------
    whole
        The recording with the boxes of its truth alone; its settings name X and Y.
    piece_of
        Its frames from one row to before another, with the boxes of all sources.

    Returns
    -------
    As `nvcore.comparison.compare` of the whole, to the bit, but without the boxes of the systems.
    """
    params, n_frames = whole.params_of(), len(whole.frames)
    thresholds = dict(zip(whole.systems, (params.threshold_x, params.threshold_y), strict=True))
    pieces: dict[str, list[_Piece]] = {name: [] for name in thresholds}
    cuts = np.linspace(0, n_frames, -(-n_frames // most) + 1).astype(int).tolist()
    for start, stop in pairwise(cuts):
        scored = _score(piece_of(start, stop), whole, start, params, thresholds)
        for name, piece in zip(pieces, scored, strict=True):
            pieces[name].append(piece)
    memo, settings = Memo(params, {}), {step.name: step.settings for step in STEPS}
    for number, (name, parts) in enumerate(pieces.items()):
        made_of_all = {
            **{key: np.concatenate([part.made[key] for part in parts]) for key in _COUNTS},
            **{
                key: join([(part, part.made[key]) for part in parts])
                for key, join in _JOINED.items()
            },
            "episodes": _episodes(whole, parts),
        }
        for key, value in made_of_all.items():
            memo.put((key, number, thresholds[name]), value, settings[key])
    return compare(whole, stages=memo.used)


def _score(
    piece: Dataset,
    whole: Dataset,
    first_frame: int,
    params: Params,
    thresholds: Mapping[str, float | None],
) -> list[_Piece]:
    """What each system made of a piece, which no longer needs its boxes then."""
    tracks, encounters = encounters_of(whole)
    rows = whole.truth.rows_of(first_frame, first_frame + len(piece.frames))
    inputs = piece, params, TruthTracks(tracks.track[rows], tracks.linked_recordings), encounters
    truth = Made(steps_of("truth", TRUTH_STEPS), Inputs(*inputs), Memo(params, {}))
    scored = []
    for name, threshold in thresholds.items():
        at = SystemInputs(*inputs, name, threshold)
        made = Made(STEPS, at, Memo(params, {}), before=truth.__getitem__)
        kept = {key: made[key] for key in (*_COUNTS, *_JOINED)}
        alarms = at.detections.only(kept["matches"].is_false_alarm)
        scored.append(_Piece(first_frame, rows.start, kept, alarms))
    return scored


def _episodes(whole: Dataset, parts: Sequence[_Piece]) -> Any:
    """Episodes of the false alarms of all pieces."""
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part.alarms, name) for part in parts]) for name in BOX_COLUMNS
    }
    columns["frame_index"] = np.concatenate(
        [part.alarms.frame_index + part.first_frame for part in parts]
    )
    for column in columns.values():  # as a dataset's own: kernels are compiled for one kind
        column.flags.writeable = False
    alarms = replace(parts[0].alarms, **columns)
    return find_episodes(alarms, np.ones(len(alarms), bool), whole.frame_columns)


def _shifted(parts: Sequence[tuple[_Piece, np.ndarray]]) -> np.ndarray:
    """Rows of truth boxes, -1: none, counted in the whole."""
    return np.concatenate([np.where(row >= 0, row + of.first_truth, -1) for of, row in parts])


_JOINED: Final[dict[str, Callable[[Sequence[tuple[_Piece, Any]]], Any]]] = {
    # of the boxes of the system itself nothing is kept
    "matches": lambda parts: Matches(
        np.empty(0, np.int8),
        _NO_ROWS,
        np.concatenate([matches.truth_det for _, matches in parts]),
    ),
    "nearest": lambda parts: Nearest(
        np.concatenate([nearest.truth for _, nearest in parts]), np.empty(0)
    ),
    "weights": lambda parts: Weights(
        np.empty(0), sum(weights.n_without_distance for _, weights in parts)
    ),
    "distances": lambda parts: SetDistances(
        np.concatenate([of.d_miss for _, of in parts]),
        np.concatenate([of.d_false for _, of in parts]),
        _shifted([(piece, of.salient_row) for piece, of in parts]),
    ),
}
"""Steps of one frame at a time, and how what they made of pieces is put together."""
