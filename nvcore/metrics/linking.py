"""Track ids for files without any, and linking of one system's boxes into episodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.dataset.schema import NO_TRACK
from nvcore.metrics.kernels.linking import link_rows

LINK_IOU: Final = 0.3
"""Smallest IoU of two boxes of one track in successive frames."""
LINK_GAP: Final = 2
"""Largest number of listed frames in which a track may be missing."""


@dataclass(frozen=True)
class TruthTracks:
    """Track of every truth box.

    Attributes
    ----------
    track
        int64, shape (n_truth,); ignored boxes keep the id from the file.
    linked_recordings
        Rows of the recordings whose tracks were created by linking.
    """

    track: np.ndarray
    linked_recordings: np.ndarray


def link_boxes(boxes: BoxColumns, frames: FrameColumns, rows: np.ndarray) -> np.ndarray:
    """Number the tracks of some boxes from 0 over all recordings, int64, shape (len(rows),).

    Boxes of successive listed frames are linked by the assignment with the largest total IoU over
    pairs with IoU >= 0.3. A track may be missing in up to 2 listed frames and never crosses
    recordings.

    Parameters
    ----------
    rows
        Rows of `boxes`, increasing.
    """
    track = np.empty(len(rows), np.int64)
    link_rows(rows, boxes.arrays, frames.recording, LINK_IOU, LINK_GAP, track)
    return track


def track_truth(truth: BoxColumns, frames: FrameColumns) -> TruthTracks:
    """Return the track of every pedestrian, linking those without an id over the frames.

    New ids start after the largest id of their recording, so that no id of the file is used twice.
    """
    rows = np.flatnonzero((truth.track == NO_TRACK) & ~truth.ignore)
    if not len(rows):
        return TruthTracks(truth.track, np.empty(0, np.int64))
    linked = link_boxes(truth, frames, rows)
    recording = frames.recording[truth.frame_index]
    largest = np.zeros(len(frames.fps), np.int64)
    np.maximum.at(largest, recording, truth.track)
    # link_boxes numbers over all recordings: start again in each
    of_row = recording[rows]
    restart = np.full(len(frames.fps), np.iinfo(np.int64).max)
    np.minimum.at(restart, of_row, linked)
    track = truth.track.copy()
    track[rows] = linked - restart[of_row] + largest[of_row] + 1
    return TruthTracks(track, np.unique(of_row))
