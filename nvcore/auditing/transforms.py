"""Transforms of a system's boxes, scored by their overlap with the truth.

A transform is a correction that a user can apply: of frame numbers, scale, position, box layout or
file format. All transforms of a system are scored on the same sample of frames.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.common.findings import TRUTH_NAME
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.sources import ReadAs
from nvcore.inputs.assign_frames import REASONS
from nvcore.inputs.box_layouts import UNITS, Box, BoxLayout, layouts, parse_layout
from nvcore.inputs.session import Session, SystemSource
from nvcore.metrics.kernels.checks import best_overlaps

MAX_PAIRS: Final = 30_000
"""Most pairs of a pedestrian and a detection per transform; frames are sampled above this."""
FIT_IOU: Final = 0.5
"""Least IoU of a box that fits a pedestrian."""
NEAR_IOU: Final = 0.3
"""Least overlap that counts in favour of a transform."""
LARGEST: Final = 1.2
"""Numbers up to this many times the whole may be shares of it, since boxes stick out of pictures.
"""
LARGE: Final = 0.1
"""Largest extent of a plausible box beyond the picture, as a share of the picture."""
NOT_LISTED: Final = REASONS[2]
NO_AREA: Final = REASONS[-1]
_RECORDING: Final = 40
"""Bits of a frame number below the number of its recording."""


@dataclass(frozen=True)
class Transform:
    """Correction of a system's boxes, by default none.

    Attributes
    ----------
    frame_step, offset_frames
        Frame = step x number + offset.
    scale
        Factors of x and w, y and h.
    offset_px
        Added to x, y after scaling.
    boxes
        Other meaning of the four numbers of a box; None: as read.
    format
        Name of another format to read the files in; empty: the same.
    """

    frame_step: float = 1.0
    offset_frames: int = 0
    scale: tuple[float, float] = (1.0, 1.0)
    offset_px: tuple[float, float] = (0.0, 0.0)
    boxes: BoxLayout | None = None
    format: str = ""

    @property
    def kinds(self) -> list[str]:
        """Names of the corrections, the most serious first."""
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
    """Overlap of a system's boxes with the sampled pedestrians under a transform.

    Attributes
    ----------
    transform
        The transform that was applied.
    n, n_fitting
        Number of pedestrians, and of those with a box that overlaps by `FIT_IOU` or more.
    mean
        Mean IoU of each pedestrian's best box, 0..1.
    rank
        As `mean`, with overlaps below `NEAR_IOU` taken as 0; the higher, the better the transform.
    n_possible
        Most pedestrians that can fit: the smaller number of pedestrians and detections in frames
        that have both.
    """

    transform: Transform
    n: int
    n_fitting: int
    mean: float
    rank: float
    n_possible: int

    @property
    def share(self) -> float:
        """Fitting pedestrians as a share of the most that could fit, 0..1."""
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
        """Return the boxes in evaluated frames."""
        frames = dataset.frame_columns
        key = _key(frames.recording, frames.frame)
        return cls(key, boxes.offsets, boxes.xywh, boxes.score)

    def with_left_out(self, dataset: Dataset, name: str, reasons: tuple[str, ...]) -> FrameBoxes:
        """Add the boxes of a source that were left out for the given reasons."""
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
        """Return width and height (px) of the picture of each box, twice."""
        frames = dataset.frame_columns
        recording = np.repeat(recording_and_frame(self.key)[0], np.diff(self.offsets))
        width, height = frames.width[recording], frames.height[recording]
        return width, height, width, height

    def laid_out(self, dataset: Dataset, was: BoxLayout, layout: BoxLayout) -> FrameBoxes:
        """Return the boxes with their numbers interpreted by another layout."""
        size = self.sizes(dataset)
        box, score = layout.boxes(was.numbers(self.box, self.score, size), size)
        x, y, w, h = map(_frozen, box)
        return FrameBoxes(self.key, self.offsets, (x, y, w, h), score)

    def every(self, n: int) -> FrameBoxes:
        """Return the boxes of every n-th non-empty frame."""
        frames = np.flatnonzero(np.diff(self.offsets))[::n]
        n_boxes = np.diff(self.offsets)[frames]
        rows = rows_in_ranges(self.offsets[frames], n_boxes)[1]
        x, y, w, h = (_frozen(side[rows]) for side in self.box)
        offsets = np.concatenate([[0], np.cumsum(n_boxes)])
        return FrameBoxes(self.key[frames], offsets, (x, y, w, h), self.score[rows])

    def believable(self, dataset: Dataset) -> float:
        """Return the share of boxes with an area, in the picture, and upright if of pedestrians."""
        (x, y, w, h), (width, height, *_) = self.box, self.sizes(dataset)
        is_so = (w > 0) & (h > 0) & (x > -LARGE * width) & (y > -LARGE * height)
        is_so &= (x + w < (1 + LARGE) * width) & (y + h < (1 + LARGE) * height)
        return float(np.mean(is_so & (h > w) if dataset.objects.are_pedestrians else is_so))


@dataclass(frozen=True)
class Trial:
    """A system's boxes and a sample of the truth's frames, to compare under transforms.

    Attributes
    ----------
    dataset
        The dataset with both.
    name
        Name of the system.
    truth, system
        Sampled boxes of the truth, and all of the system's that count.
    every
        Sampling step: every n-th frame with pedestrians is compared.
    """

    dataset: Dataset
    name: str
    truth: FrameBoxes
    system: FrameBoxes
    every: int
    _by_layout: dict[BoxLayout, FrameBoxes] = field(default_factory=dict)

    @classmethod
    def of(cls, dataset: Dataset, name: str, boxes: BoxColumns) -> Trial:
        """Compare a system's boxes with the truth, sampled if there are many pairs."""
        truth = dataset.truth
        if truth.ignore.any():
            truth = truth.only(~truth.ignore)
        of_truth = FrameBoxes.placed(dataset, truth)
        system = FrameBoxes.placed(dataset, boxes)
        n_pairs = int((np.diff(of_truth.offsets) * np.diff(system.offsets)).sum())
        every = max(1, -(-n_pairs // MAX_PAIRS))
        return cls(dataset, name, of_truth.every(every), system, every)

    def with_left_out(self) -> Trial:
        """Add the rows that were left out: in frames not evaluated, or without an area."""
        reasons = (NOT_LISTED, NO_AREA)
        system = self.system.with_left_out(self.dataset, self.name, reasons)
        truth = self.truth.with_left_out(self.dataset, TRUTH_NAME, (NO_AREA,))
        # a transform may bring frames together that have no pair as they are
        n_frames = max(int(np.count_nonzero(np.diff(system.offsets))), 1)
        n_pairs = len(truth.score) * len(system.score) // n_frames
        every = max(1, -(-n_pairs // MAX_PAIRS))
        truth = truth.every(every)
        return replace(self, truth=truth, system=system, every=self.every * every, _by_layout={})

    def was(self, name: str) -> ReadAs:
        """Return how a source was read."""
        return self.dataset.read_as.get(name, ReadAs())

    def other_layouts(self, name: str) -> list[BoxLayout]:
        """Return other layouts that the numbers of the truth's or the system's boxes may have."""
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
        """Return the trial with the truth's boxes interpreted by another layout."""
        was = parse_layout(self.was(TRUTH_NAME).boxes)
        return replace(self, truth=self.truth.laid_out(self.dataset, was, layout))

    def boxes_under(self, transform: Transform) -> FrameBoxes:
        """Return the system's boxes in the transform's layout, without its other corrections."""
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
        """Find the best box of each sampled pedestrian under a transform.

        Returns
        -------
        iou, box
            IoU of each pedestrian's best box and the row of that, 0 and -1 without any; shape (n,).
        lo, hi
            Range of the system's rows that each sampled frame is compared with; shape (n_frames,).
        """
        system, key = self.boxes_under(transform), self.truth.key
        recording, frame = recording_and_frame(key)
        step, offset = transform.frame_step, transform.offset_frames
        # if several numbers give the same frame, the nearest counts, as in the correction
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
        (sx, sy), (ox, oy) = transform.scale, transform.offset_px
        scale, offset_px = (float(sx), float(sy)), (float(ox), float(oy))
        best_overlaps(of_frame, self.truth.box, lo, hi, system.box, scale, offset_px, iou, best)
        return iou, best, lo, hi

    def fit(self, transform: Transform) -> Fit:
        """Score a transform."""
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
        """Whether the pedestrians with a fitting box are spread over the picture."""
        is_fitting = self.overlaps(transform)[0] >= FIT_IOU
        x, y, w, _ = (side[is_fitting] for side in self.truth.box)
        spread = [np.ptp(np.percentile(side, [10, 90])) for side in (x, y) if len(side)]
        return bool(spread and max(spread) >= 0.5 * np.median(w))


def source_of(dataset: Dataset, name: str) -> SystemSource:
    """Return a system's entry in the session, or an empty one without a session."""
    settings = dataset.settings
    if not isinstance(settings, Session):
        return SystemSource(name)
    return settings.systems[dataset.systems.index(name)]


def rows_in_ranges(start: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Expand ranges of `n` rows from `start`. Returns range number and row, one entry per row."""
    end = np.cumsum(n)
    number = np.repeat(np.arange(len(n)), n)
    return number, np.arange(n.sum()) - np.repeat(end - n - start, n)


def above_threshold(boxes: BoxColumns, threshold: float | None) -> BoxColumns:
    """Select the detections that pass a threshold. Those without a score always do."""
    return boxes if threshold is None else boxes.only(~(boxes.score < threshold))


def recording_and_frame(key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split keys into the row of the recording and the frame number, which may be negative."""
    recording = (key + (1 << (_RECORDING - 1))) >> _RECORDING
    return recording, key - (recording << _RECORDING)


def _key(recording: np.ndarray, frame: np.ndarray) -> np.ndarray:
    key: np.ndarray = (recording.astype(np.int64) << _RECORDING) + frame
    return key


def _frozen(column: np.ndarray) -> np.ndarray:
    """Return the column as read-only float64, the type that kernels are compiled for."""
    column = np.ascontiguousarray(column, np.float64)
    column.flags.writeable = False
    return column
