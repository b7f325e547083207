"""Transforms of a system's boxes, and how well the boxes overlap the truth under each.

A transform is what a user can correct: frame numbers, scale, position, the meaning of a box's
numbers, the format of the files. All transforms of a system are scored on the same draw of frames.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.columns import BoxColumns
from nvcore.dataset import Dataset
from nvcore.dataset.sources import ReadAs
from nvcore.findings import TRUTH_NAME
from nvcore.inputs.box_layouts import UNITS, Box, BoxLayout, layouts, parse_layout
from nvcore.inputs.placing import REASONS
from nvcore.inputs.session import Session, SystemSource
from nvcore.metrics.kernels.checks import best_overlaps

MAX_PAIRS: Final = 30_000
"""Pairs of a pedestrian and a detection that one transform may cost; above, frames are drawn."""
FIT_IOU: Final = 0.5
"""Overlap from which on a box fits a pedestrian."""
NEAR_IOU: Final = 0.3
"""Smaller overlaps say nothing for a transform."""
LARGEST: Final = 1.2
"""Numbers up to this many times the whole may be shares of it: boxes stick out of pictures."""
LARGE: Final = 0.1
"""How far a believable box may stick out of the picture, as a share of it."""
NOT_LISTED: Final = REASONS[2]
NO_AREA: Final = REASONS[-1]
_RECORDING: Final = 40
"""Bits of a frame number below the number of its recording."""


@dataclass(frozen=True)
class Transform:
    """A correction of a system's boxes; by default none.

    Attributes
    ----------
    frame_step, offset_frames
        Frame = step x number + offset.
    scale
        Factors of x and w, y and h.
    offset_px
        Added to x, y after scaling.
    boxes
        What the four numbers of a box are instead; None: as they were read.
    format
        Name of the format that the files are read as instead; empty: the same.
    """

    frame_step: float = 1.0
    offset_frames: int = 0
    scale: tuple[float, float] = (1.0, 1.0)
    offset_px: tuple[float, float] = (0.0, 0.0)
    boxes: BoxLayout | None = None
    format: str = ""

    @property
    def kinds(self) -> list[str]:
        """What it corrects, the most serious first, in words."""
        has = {
            "another format": bool(self.format),
            "another meaning of a box's numbers": self.boxes is not None,
            "another frame rate": self.frame_step != 1,
            "pictures of another size": self.scale != (1.0, 1.0),
            "another frame number": bool(self.offset_frames) and self.frame_step == 1,
            "another place in the picture": any(self.offset_px) and self.scale == (1.0, 1.0),
        }
        return [kind for kind, is_so in has.items() if is_so]


@dataclass(frozen=True)
class Fit:
    """How well a system's boxes overlap the drawn pedestrians under a transform.

    Attributes
    ----------
    transform
        What was done to the boxes.
    n, n_fitting
        Pedestrians looked at; those with a box that overlaps by `FIT_IOU` or more.
    mean
        Mean IoU of each pedestrian's best box, 0..1.
    rank
        The same without overlaps below `NEAR_IOU`: the higher, the better the transform.
    n_possible
        The smaller of two numbers: pedestrians in frames with detections, and these detections.
    """

    transform: Transform
    n: int
    n_fitting: int
    mean: float
    rank: float
    n_possible: int

    @property
    def share(self) -> float:
        """Fitting pedestrians of as many as could fit at best, 0..1."""
        return self.n_fitting / max(self.n_possible, 1)


class FrameBoxes(NamedTuple):
    """Boxes by frame: frame i is ``key[i]`` and has the rows ``offsets[i]:offsets[i + 1]``.

    A key holds recording and frame number; keys ascend.
    """

    key: np.ndarray
    offsets: np.ndarray
    box: Box
    score: np.ndarray

    @classmethod
    def placed(cls, dataset: Dataset, boxes: BoxColumns) -> FrameBoxes:
        """The boxes that stand in evaluated frames."""
        frames = dataset.frame_columns
        key = _key(frames.recording, frames.frame)
        return cls(key, boxes.offsets, boxes.xywh, boxes.score)

    def with_left_out(self, dataset: Dataset, name: str, reasons: tuple[str, ...]) -> FrameBoxes:
        """These boxes and those of a source that were left out for some reasons."""
        lost = dataset.left_out
        lost = lost[(lost["subject"] == name) & lost["reason"].isin(reasons)]
        recording = pd.Index(dataset.recordings["name"]).get_indexer(pd.Index(lost["recording"]))
        is_there = (recording >= 0) & (lost["frame"].abs() < 1 << (_RECORDING - 1)).to_numpy()
        lost, recording = lost[is_there], recording[is_there]
        if lost.empty:
            return self
        keys = np.repeat(self.key, np.diff(self.offsets)), _key(recording, lost["frame"].to_numpy())
        key = np.concatenate(keys)
        order = np.argsort(key, kind="stable")
        key, start = np.unique(key[order], return_index=True)
        added = [lost[side].to_numpy(float) for side in "xywh"]
        columns = [
            np.concatenate([own, more])[order]
            for own, more in zip(
                (*self.box, self.score), (*added, np.full(len(lost), np.nan)), strict=True
            )
        ]
        x, y, w, h, score = map(_frozen, columns)
        return FrameBoxes(key, np.append(start, len(order)), (x, y, w, h), score)

    def sizes(self, dataset: Dataset) -> Box:
        """Width and height (px) of the picture of each box, twice."""
        frames = dataset.frame_columns
        recording = np.repeat(recording_and_frame(self.key)[0], np.diff(self.offsets))
        width, height = frames.width[recording], frames.height[recording]
        return width, height, width, height

    def laid_out(self, dataset: Dataset, was: BoxLayout, layout: BoxLayout) -> FrameBoxes:
        """The boxes with another meaning of their numbers."""
        size = self.sizes(dataset)
        box, score = layout.boxes(was.numbers(self.box, self.score, size), size)
        x, y, w, h = map(_frozen, box)
        return FrameBoxes(self.key, self.offsets, (x, y, w, h), score)

    def every(self, n: int) -> FrameBoxes:
        """The boxes of every n-th frame that has some."""
        frames = np.flatnonzero(np.diff(self.offsets))[::n]
        n_boxes = np.diff(self.offsets)[frames]
        rows = rows_in_ranges(self.offsets[frames], n_boxes)[1]
        x, y, w, h = (_frozen(side[rows]) for side in self.box)
        offsets = np.concatenate([[0], np.cumsum(n_boxes)])
        return FrameBoxes(self.key[frames], offsets, (x, y, w, h), self.score[rows])

    def believable(self, dataset: Dataset) -> float:
        """Share of boxes that have an area, lie in the picture, and stand if of people; 0..1."""
        (x, y, w, h), (width, height, *_) = self.box, self.sizes(dataset)
        is_so = (w > 0) & (h > 0) & (x > -LARGE * width) & (y > -LARGE * height)
        is_so &= (x + w < (1 + LARGE) * width) & (y + h < (1 + LARGE) * height)
        return float(np.mean(is_so & (h > w) if dataset.objects.are_pedestrians else is_so))


@dataclass(frozen=True)
class Trial:
    """A system's boxes, to be held against a draw of the truth's under transforms.

    Attributes
    ----------
    dataset
        What they are from.
    name
        Of the system.
    truth, system
        The drawn boxes of the truth, and all of the system's that count.
    every
        1: all frames with pedestrians are drawn; n: every n-th.
    """

    dataset: Dataset
    name: str
    truth: FrameBoxes
    system: FrameBoxes
    every: int
    _by_layout: dict[BoxLayout, FrameBoxes] = field(default_factory=dict)

    @classmethod
    def of(cls, dataset: Dataset, name: str, boxes: BoxColumns) -> Trial:
        """The boxes of a system that count, against the evaluated frames."""
        truth = dataset.truth
        if truth.ignore.any():
            truth = truth.only(~truth.ignore)
        of_truth = FrameBoxes.placed(dataset, truth)
        system = FrameBoxes.placed(dataset, boxes)
        n_pairs = int((np.diff(of_truth.offsets) * np.diff(system.offsets)).sum())
        every = max(1, -(-n_pairs // MAX_PAIRS))
        return cls(dataset, name, of_truth.every(every), system, every)

    def with_left_out(self) -> Trial:
        """The trial with the rows that have no place: in other frames, or without an area."""
        reasons = (NOT_LISTED, NO_AREA)
        system = self.system.with_left_out(self.dataset, self.name, reasons)
        truth = self.truth.with_left_out(self.dataset, TRUTH_NAME, (NO_AREA,))
        return replace(self, truth=truth, system=system, _by_layout={})

    def was(self, name: str) -> ReadAs:
        """How a source was read."""
        return self.dataset.read_as.get(name, ReadAs())

    def other_layouts(self, name: str) -> list[BoxLayout]:
        """Meanings that the numbers of the truth or the system can have instead."""
        boxes, read_as = self.truth if name == TRUTH_NAME else self.system, self.was(name)
        was = parse_layout(read_as.boxes)
        numbers = was.numbers(boxes.box, boxes.score, boxes.sizes(self.dataset))[:4]
        largest = float(np.nanpercentile(np.abs(np.stack(numbers)), 99))
        units = [
            unit
            for unit, (whole, _) in UNITS.items()
            if unit == was.unit or (whole is not None and largest <= LARGEST * whole)
        ]
        orders = (False, True) if read_as.has_score_beside else (was.is_score_first,)
        return [layout for layout in layouts(units, orders) if layout != was]

    def with_truth_as(self, layout: BoxLayout) -> Trial:
        """The trial with another meaning of the numbers of the truth's boxes."""
        was = parse_layout(self.was(TRUTH_NAME).boxes)
        return replace(self, truth=self.truth.laid_out(self.dataset, was, layout))

    def boxes_under(self, transform: Transform) -> FrameBoxes:
        """The system's boxes by the transform's meaning of their numbers, else untransformed."""
        layout = transform.boxes
        if layout is None:
            return self.system
        if layout not in self._by_layout:
            was = parse_layout(self.was(self.name).boxes)
            self._by_layout[layout] = self.system.laid_out(self.dataset, was, layout)
        return self._by_layout[layout]

    def overlaps(
        self, transform: Transform
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Best boxes of the drawn pedestrians under a transform.

        Returns
        -------
        iou, box
            IoU of each pedestrian's best box and the row of that, 0 and -1 without any; shape (n,).
        lo, hi
            Rows of the system's boxes that each drawn frame is held against; shape (n_frames,).
        """
        system, key = self.boxes_under(transform), self.truth.key
        recording, frame = recording_and_frame(key)
        step, offset = transform.frame_step, transform.offset_frames
        # of several numbers that come to one frame the nearest counts, as where it is corrected
        number = np.rint((frame - offset) / step).astype(np.int64)
        is_frame = np.floor(step * number + offset + 0.5) == frame
        wanted = _key(recording, number)
        row = np.minimum(np.searchsorted(system.key, wanted), max(len(system.key) - 1, 0))
        if len(system.key):
            is_frame &= system.key[row] == wanted
            lo, hi = (np.where(is_frame, system.offsets[row + end], 0) for end in (0, 1))
        else:
            lo = hi = np.zeros(len(key), np.int64)
        n = len(self.truth.score)
        iou, best = np.empty(n), np.empty(n, np.int64)
        of_frame = np.repeat(np.arange(len(key)), np.diff(self.truth.offsets))
        moves = map(float, (*transform.scale, *transform.offset_px))
        best_overlaps(of_frame, *self.truth.box, lo, hi, *system.box, *moves, iou, best)
        return iou, best, lo, hi

    def fit(self, transform: Transform) -> Fit:
        """How well the boxes fit under a transform."""
        iou, _, lo, hi = self.overlaps(transform)
        n = max(len(iou), 1)
        return Fit(
            transform,
            len(iou),
            int(np.count_nonzero(iou >= FIT_IOU)),
            float(iou.sum()) / n,
            float(iou[iou >= NEAR_IOU].sum()) / n,
            int(min(np.diff(self.truth.offsets)[hi > lo].sum(), (hi - lo).sum())),
        )

    def is_spread(self, transform: Transform) -> bool:
        """Whether the pedestrians whose box fits stand in more than one place."""
        is_fitting = self.overlaps(transform)[0] >= FIT_IOU
        x, y, w, _ = (side[is_fitting] for side in self.truth.box)
        spread = [np.ptp(np.percentile(side, [10, 90])) for side in (x, y) if len(side)]
        return bool(spread and max(spread) >= 0.5 * np.median(w))


def source_of(dataset: Dataset, name: str) -> SystemSource:
    """What the session says of a system; nothing without a session."""
    settings = dataset.settings
    if not isinstance(settings, Session):
        return SystemSource(name)
    return settings.systems[dataset.systems.index(name)]


def rows_in_ranges(start: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows of ranges that begin at `start` and have `n` rows: number of the range, and row."""
    end = np.cumsum(n)
    number = np.repeat(np.arange(len(n)), n)
    return number, np.arange(n.sum()) - np.repeat(end - n - start, n)


def above_threshold(boxes: BoxColumns, threshold: float | None) -> BoxColumns:
    """The detections that pass a threshold; those without a score always do."""
    return boxes if threshold is None else boxes.only(~(boxes.score < threshold))


def recording_and_frame(key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Row of the recording, and frame number (which may be negative), of keys."""
    recording = (key + (1 << (_RECORDING - 1))) >> _RECORDING
    return recording, key - (recording << _RECORDING)


def _key(recording: np.ndarray, frame: np.ndarray) -> np.ndarray:
    key: np.ndarray = (recording.astype(np.int64) << _RECORDING) + frame
    return key


def _frozen(column: np.ndarray) -> np.ndarray:
    """The column as a dataset's own: kernels are compiled for one kind of array."""
    column = np.ascontiguousarray(column, np.float64)
    column.flags.writeable = False
    return column
