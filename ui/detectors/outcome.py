"""Detectors page: what the boxes of the current frame are in a comparison."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nvcore.columns import BoxColumns
from nvcore.dataset import Dataset
from nvcore.detectors.base import Detections
from nvcore.figures.detectors.boxes import iou_with, sides_in
from nvcore.metrics.matching import match_boxes
from nvcore.params import Params
from nvcore.pictures import Picture
from nvcore.schema import NO_LABEL, NO_TRACK, DetectionState


@dataclass(frozen=True)
class Outcome:
    """What became of the boxes that count, and of the truth.

    Attributes
    ----------
    states
        `DetectionState` of each box, int8, (n,); BELOW: it does not count, or its class does not.
    iou
        With the truth's nearest, (n,); NaN without truth.
    truth, ignored
        Left, top, width, height of the truth that counts and of the other, px of the recording.
    """

    states: NDArray[np.int8]
    iou: NDArray[np.float64]
    truth: NDArray[np.float64]
    ignored: NDArray[np.float64]

    def n_of(self, state: DetectionState) -> int:
        """Boxes of this state."""
        return int(np.count_nonzero(self.states == state))

    @property
    def n_missed(self) -> int:
        """Boxes of the truth that count and that nothing matches."""
        return len(self.truth) - self.n_of(DetectionState.MATCHED)


def outcome_of(
    dataset: Dataset,
    row: int,
    picture: Picture,
    boxes: Detections,
    is_counting: NDArray[np.bool_],
    params: Params,
) -> Outcome:
    """Boxes of a picture, matched to the truth of its frame as a comparison would.

    Parameters
    ----------
    row
        Of the frames table.
    boxes, is_counting
        All candidates, and which of them the detector gives; (n,).
    params
        Of which those that say when a detection matches are read.
    """
    frames, truth = dataset.frame_columns, dataset.truth.of_frames(row, row + 1)
    recording = int(frames.recording[row])
    size = float(frames.width[recording]), float(frames.height[recording])
    sides = sides_in(boxes, picture, size)
    is_compared = np.flatnonzero(is_counting & _is_of_a_class_that_counts(dataset, boxes))
    this_frame = slice(row, row + 1)
    frame = replace(
        frames,
        recording=frames.recording[this_frame],
        frame=frames.frame[this_frame],
        gap=frames.gap[this_frame],
    )
    matches = match_boxes(truth, _columns(dataset, boxes, sides, is_compared), frame, params)
    states = np.zeros(len(boxes), np.int8)
    states[is_compared] = matches.state
    all_truth = np.column_stack(truth.xywh)
    counted = all_truth[~truth.ignore]
    return Outcome(states, iou_with(sides, counted), counted, all_truth[truth.ignore])


def _is_of_a_class_that_counts(dataset: Dataset, boxes: Detections) -> NDArray[np.bool_]:
    """Which boxes a comparison reads; as for the files of a run, all where none would be."""
    if boxes.label is None:
        return np.ones(len(boxes), dtype=bool)
    names = boxes.label.astype(str)
    counts = {name: dataset.objects.counts(name) for name in np.unique(names).tolist()}
    is_read = np.array([counts[name] for name in names.tolist()], dtype=bool)
    return is_read if is_read.any() else ~is_read


def _columns(
    dataset: Dataset, boxes: Detections, sides: NDArray[np.float64], rows: NDArray[np.int64]
) -> BoxColumns:
    """These rows as the boxes of a single frame."""
    n = len(rows)
    label = np.full(n, NO_LABEL, np.int32)
    if boxes.label is not None:
        place = {name: i for i, name in enumerate(dataset.labels)}
        own = [dataset.objects.label_of(str(name)) for name in boxes.label[rows]]
        label = np.array([place.get(name, NO_LABEL) for name in own], np.int32)
    columns = {
        **dict(zip("xywh", np.ascontiguousarray(sides[rows].T), strict=True)),
        "score": boxes.score[rows],
        "track": np.full(n, NO_TRACK, np.int64),
        "ignore": np.zeros(n, dtype=bool),
        "distance_m": np.full(n, np.nan),
        "label": label,
        "frame_index": np.zeros(n, np.int64),
        "offsets": np.array([0, n]),
    }
    for column in columns.values():  # as a dataset's own: kernels are compiled for one kind
        column.flags.writeable = False
    return BoxColumns(**columns, first_row=0)
