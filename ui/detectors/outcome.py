"""Detectors page: what the boxes of the current frame are in a comparison."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nvcore.columns import boxes_of_frame
from nvcore.dataset import Dataset
from nvcore.detectors.base import Detections
from nvcore.detectors.figures import iou_with, sides_in
from nvcore.metrics.matching import match_boxes
from nvcore.params import Params
from nvcore.pictures import Picture
from nvcore.schema import NO_LABEL, DetectionState


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
    *,
    classes: Collection[str],
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
    classes
        What the detector can call a box, in any picture of a run.
    """
    frames, truth = dataset.frame_columns, dataset.truth.of_frames(row, row + 1)
    recording = int(frames.recording[row])
    size = float(frames.width[recording]), float(frames.height[recording])
    sides = sides_in(boxes, picture, size)
    is_compared = np.flatnonzero(is_counting & _is_of_a_class_that_counts(dataset, boxes, classes))
    this_frame = slice(row, row + 1)
    frame = replace(
        frames,
        recording=frames.recording[this_frame],
        frame=frames.frame[this_frame],
        gap=frames.gap[this_frame],
    )
    labels = _places_of_labels(dataset, boxes)[is_compared]
    own = boxes_of_frame(sides[is_compared], boxes.score[is_compared], labels)
    matches = match_boxes(truth, own, frame, params)
    states = np.zeros(len(boxes), np.int8)
    states[is_compared] = matches.state
    all_truth = np.column_stack(truth.xywh)
    counted = all_truth[~truth.ignore]
    return Outcome(states, iou_with(sides, counted), counted, all_truth[truth.ignore])


def _is_of_a_class_that_counts(
    dataset: Dataset, boxes: Detections, classes: Collection[str]
) -> NDArray[np.bool_]:
    """Which boxes a comparison reads: all, where the detector knows no class that counts."""
    if boxes.label is None or not any(map(dataset.objects.counts, classes)):
        return np.ones(len(boxes), dtype=bool)
    names, place = np.unique(boxes.label.astype(str), return_inverse=True)
    counts = np.array([dataset.objects.counts(name) for name in names.tolist()], dtype=bool)
    is_read: NDArray[np.bool_] = counts[place]
    return is_read


def _places_of_labels(dataset: Dataset, boxes: Detections) -> NDArray[np.int32]:
    """Place of each box's class among `Dataset.labels`; NO_LABEL where it is none of them."""
    if boxes.label is None:
        return np.full(len(boxes), NO_LABEL, np.int32)
    place = {name: i for i, name in enumerate(dataset.labels)}
    own = [dataset.objects.label_of(str(name)) for name in boxes.label]
    return np.array([place.get(name, NO_LABEL) for name in own], np.int32)
