"""Detectors page: outcome of the boxes of the current frame in a comparison."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.dataset.columns import boxes_of_frame
from nvcore.dataset.schema import NO_LABEL, DetectionState
from nvcore.metrics.matching import match_boxes
from nvcore.pictures import Picture
from nvcore.settings.params import Params
from nvcore.subjects.detectors.base import Detections
from nvcore.subjects.detectors.figures import iou_with, sides_in


@dataclass(frozen=True)
class Outcome:
    """Outcome of the boxes that count, and of the truth.

    Attributes
    ----------
    states
        `DetectionState` of each box, int8, (n,); BELOW: it does not count, or its class does not.
    iou
        With the nearest box of the truth, (n,); NaN without truth.
    truth, ignored
        Left, top, width, height of the truth that counts and of the other, px of the recording.
    """

    states: NDArray[np.int8]
    iou: NDArray[np.float64]
    truth: NDArray[np.float64]
    ignored: NDArray[np.float64]

    def n_of(self, state: DetectionState) -> int:
        """Number of boxes in this state."""
        return int(np.count_nonzero(self.states == state))

    @property
    def n_missed(self) -> int:
        """Number of truth boxes that count and that nothing matches."""
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
    """Match the boxes of a picture to the truth of its frame, as a comparison would.

    Parameters
    ----------
    row
        Row in the frames table.
    boxes, is_counting
        All candidates, and which of them the detector gives; (n,).
    params
        Its settings for matching are used.
    classes
        Classes that the detector knows, in any picture of a run.
    """
    frames, truth = dataset.frame_columns, dataset.truth.of_frames(row, row + 1)
    recording, here = int(frames.recording[row]), slice(row, row + 1)
    size = float(frames.width[recording]), float(frames.height[recording])
    sides = sides_in(boxes, picture, size)
    is_read, labels = _labels(dataset, boxes, classes)
    compared = np.flatnonzero(is_counting & is_read)
    own = boxes_of_frame(sides[compared], boxes.score[compared], labels[compared])
    frame = replace(
        frames, recording=frames.recording[here], frame=frames.frame[here], gap=frames.gap[here]
    )
    states = np.zeros(len(boxes), np.int8)
    states[compared] = match_boxes(truth, own, frame, params).state
    all_truth = np.column_stack(truth.xywh)
    counted = all_truth[~truth.ignore]
    return Outcome(states, iou_with(sides, counted), counted, all_truth[truth.ignore])


def _labels(
    dataset: Dataset, boxes: Detections, classes: Collection[str]
) -> tuple[NDArray[np.bool_], NDArray[np.int32]]:
    """Return which boxes a comparison reads, and their classes as places in `Dataset.labels`.

    It reads all boxes if the detector knows no class that counts.
    """
    is_read, places = np.ones(len(boxes), bool), np.full(len(boxes), NO_LABEL, np.int32)
    if boxes.label is not None:
        objects, place = dataset.objects, {name: i for i, name in enumerate(dataset.labels)}
        names = boxes.label.astype(str).tolist()
        places[:] = [place.get(objects.label_of(name), NO_LABEL) for name in names]
        if any(map(objects.counts, classes)):
            is_read[:] = [objects.counts(name) for name in names]
    return is_read, places
