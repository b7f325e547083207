"""Boxes of one source, and frames, as arrays: the inputs of `nvcore.metrics`."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from nvcore.dataset.schema import NO_TRACK


@dataclass(frozen=True)
class BoxColumns:
    """Boxes of one source as arrays sorted by frame: frame f is ``offsets[f]:offsets[f + 1]``.

    Attributes
    ----------
    x, y, w, h, score
        px (score: any scale), float64, shape (n,).
    track
        int64, shape (n,); NO_TRACK if none.
    ignore
        bool, shape (n,).
    distance_m
        metres, float64, shape (n,); NaN if unknown.
    label
        Index in `nvcore.dataset.Dataset.labels`, int32, shape (n,); NO_LABEL if unknown.
    frame_index
        Row of the frames table, int64, shape (n,).
    offsets
        int64, shape (n_frames + 1,).
    first_row
        Row of the boxes table at which this source starts.
    """

    x: np.ndarray
    y: np.ndarray
    w: np.ndarray
    h: np.ndarray
    score: np.ndarray
    track: np.ndarray
    ignore: np.ndarray
    distance_m: np.ndarray
    label: np.ndarray
    frame_index: np.ndarray
    offsets: np.ndarray
    first_row: int

    def __len__(self) -> int:
        return len(self.x)

    def only(self, is_kept: np.ndarray) -> BoxColumns:
        """Return the boxes for which `is_kept` (bool, shape (n,)) is true."""
        columns = {name: getattr(self, name)[is_kept] for name in BOX_COLUMNS}
        for column in columns.values():  # as a dataset's own: kernels are compiled for one kind
            column.flags.writeable = False
        n_before = np.concatenate([[0], np.cumsum(is_kept)])
        return replace(self, **columns, offsets=n_before[self.offsets])

    @property
    def arrays(self) -> BoxArrays:
        """The arrays for compiled loops."""
        return BoxArrays(*(getattr(self, name) for name in BoxArrays._fields))

    @property
    def xywh(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The four coordinates x, y, w, h, px."""
        return self.x, self.y, self.w, self.h

    def rows_of(self, start: int, stop: int) -> slice:
        """Return the slice of boxes that belong to frames ``start:stop``."""
        return slice(int(self.offsets[start]), int(self.offsets[stop]))

    def of_frames(self, start: int, stop: int) -> BoxColumns:
        """Return the boxes of frames ``start:stop``, without reading any other boxes.

        Their `frame_index` still counts all frames, while `offsets` only covers these frames.
        """
        rows = self.rows_of(start, stop)
        columns = {name: getattr(self, name)[rows] for name in BOX_COLUMNS}
        offsets = self.offsets[start : stop + 1] - rows.start
        return replace(self, **columns, offsets=offsets, first_row=self.first_row + rows.start)


class BoxArrays(NamedTuple):
    """Arrays of `BoxColumns` for compiled loops, which take tuples but no objects."""

    offsets: np.ndarray
    frame_index: np.ndarray
    x: np.ndarray
    y: np.ndarray
    w: np.ndarray
    h: np.ndarray
    score: np.ndarray
    track: np.ndarray
    ignore: np.ndarray
    distance_m: np.ndarray
    label: np.ndarray


BOX_COLUMNS = tuple(spec.name for spec in fields(BoxColumns))[:-2]
"""Columns of the boxes table that `BoxColumns` holds."""


def boxes_of_frame(xywh: np.ndarray, score: np.ndarray, label: np.ndarray) -> BoxColumns:
    """Return the boxes of a single frame, without tracks, distances or ignored boxes.

    Parameters
    ----------
    xywh
        px, float64, shape (n, 4).
    score, label
        See `BoxColumns`.
    """
    n = len(xywh)
    columns = {
        **dict(zip("xywh", np.ascontiguousarray(xywh.T), strict=True)),
        "score": score,
        "track": np.full(n, NO_TRACK, np.int64),
        "ignore": np.zeros(n, dtype=bool),
        "distance_m": np.full(n, np.nan),
        "label": label,
        "frame_index": np.zeros(n, np.int64),
    }
    own = {name: column.view() for name, column in columns.items()}
    for column in own.values():  # as a dataset's own: kernels are compiled for one kind
        column.flags.writeable = False
    return BoxColumns(**own, offsets=np.array([0, n]), first_row=0)


class Detectability(NamedTuple):
    """Estimated share of drivers who see each truth box unaided.

    Attributes
    ----------
    value
        0..1, 1 is surely seen; float64, shape (n_truth,); NaN if unknown.
    sd
        Standard deviation of the estimate; float64, shape (n_truth,); NaN if unknown.
    is_outside
        True if estimated outside the range of the training; bool, shape (n_truth,).
    is_adapted
        True if estimated for adapted eyes, because no earlier change from bright to dark is known;
        bool, shape (n_truth,).
    """

    value: np.ndarray
    sd: np.ndarray
    is_outside: np.ndarray
    is_adapted: np.ndarray


class FrameArrays(NamedTuple):
    """Arrays of `FrameColumns` for compiled loops."""

    recording: np.ndarray
    frame: np.ndarray
    gap: np.ndarray
    width: np.ndarray
    height: np.ndarray
    fps: np.ndarray


@dataclass(frozen=True)
class FrameColumns:
    """Properties of frames and recordings as arrays.

    Attributes
    ----------
    recording
        Recording of each frame, int32, shape (n_frames,).
    frame
        Frame number, int64, shape (n_frames,).
    gap
        Frames to the next listed frame (last one: the median gap), float64, shape (n_frames,).
    first
        First row of each recording, int64, shape (n_recordings + 1,).
    width, height, fps, horizon, context
        float64, shape (n_recordings,); horizon and context are NaN if unknown.
    speed_kmh
        Speed of the car in each frame, from its series or else from its recording; float64, shape
        (n_frames,); NaN if neither states it.
    """

    recording: np.ndarray
    frame: np.ndarray
    gap: np.ndarray
    first: np.ndarray
    width: np.ndarray
    height: np.ndarray
    fps: np.ndarray
    horizon: np.ndarray
    context: np.ndarray
    speed_kmh: np.ndarray

    def __len__(self) -> int:
        return len(self.frame)

    @cached_property
    def arrays(self) -> FrameArrays:
        """The arrays for compiled loops."""
        return FrameArrays(*(getattr(self, name) for name in FrameArrays._fields))

    def rows_of(self, recording: int) -> slice:
        """Return the slice of frames that belong to a recording."""
        return slice(int(self.first[recording]), int(self.first[recording + 1]))

    @cached_property
    def passed(self) -> np.ndarray:
        """Running sum of gaps before each frame, across recordings, float64, (n_frames + 1,)."""
        return np.concatenate([[0.0], np.cumsum(self.gap)])

    @cached_property
    def half_width(self) -> np.ndarray:
        """Half the width of each frame's picture, px, float64, shape (n_frames,)."""
        half: np.ndarray = 0.5 * self.width[self.recording]
        return half

    @cached_property
    def step_s(self) -> np.ndarray:
        """Time from each frame to the next listed one, seconds, float64, shape (n_frames,)."""
        steps: np.ndarray = self.gap / self.fps[self.recording]
        return steps

    @cached_property
    def duration_s(self) -> float:
        """Total recording time: the sum of all time steps, seconds."""
        gaps = np.bincount(self.recording, weights=self.gap, minlength=len(self.fps))
        return float((gaps / self.fps).sum())

    @cached_property
    def sampling_step(self) -> np.ndarray:
        """Median distance between listed frames of each recording, 1 if every frame is listed.

        A value above 1 means that the frames between were not evaluated. Events counted in listed
        frames (false alarms) are then too few per minute of recording time by about this factor.

        Returns
        -------
        float64, shape (n_recordings,); 1 for a recording of a single frame or none.
        """
        first = self.first
        return np.array(
            [
                _median_gap(self.gap[start:stop]) if stop > start else 1.0
                for start, stop in pairwise(first)
            ],
            dtype=np.float64,
        )

    def within(self, window_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Return for each frame the range of rows at most half a window away from it.

        Never across recordings. Frame numbers are compared, so that a frame exactly half a window
        away always counts. The latest window is cached: it is the same for all systems and alphas.

        Returns
        -------
        start, stop
            int64, shape (n_frames,).
        """
        rows = self._windows.get(window_s)
        if rows is None:
            reach = (0.5 * window_s * self.fps * (1 + 1e-9)).astype(np.int64)
            # one axis for all recordings, with more than a window between them; whole numbers, so
            # that results do not depend on its length
            is_other = np.concatenate([[False], np.diff(self.recording) != 0])
            step = np.concatenate([[0], np.diff(self.frame)])
            axis = np.cumsum(np.where(is_other, 2 * reach.max(initial=0) + 1, step))
            half_width = reach[self.recording]
            rows = (
                np.searchsorted(axis, axis - half_width, side="left"),
                np.searchsorted(axis, axis + half_width, side="right"),
            )
            self._windows.clear()
            self._windows[window_s] = rows
        return rows

    def sums(self, values: np.ndarray, start: np.ndarray, stop: np.ndarray) -> np.ndarray:
        """Sum the values over each range of frames ``start:stop``.

        No range is empty, and each lies within one recording. Each recording is summed by itself,
        so that results do not depend on the other recordings.

        Parameters
        ----------
        values
            Value of each frame; float64, shape (n_frames,).
        """
        running = np.empty(len(values))
        for first, end in pairwise(self.first):  # a loop over recordings
            np.cumsum(values[first:end], out=running[first:end])
        is_later = start > self.first[self.recording[start]]
        total: np.ndarray = running[stop - 1] - np.where(is_later, running[start - 1], 0.0)
        return total

    @cached_property
    def _windows(self) -> dict[float, tuple[np.ndarray, np.ndarray]]:
        return {}


def offsets_of(frame_index: np.ndarray, n_frames: int) -> np.ndarray:
    """Return the start of each frame's boxes in a sorted `frame_index`, int64, (n_frames + 1,)."""
    counts = np.bincount(frame_index, minlength=n_frames)
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def frame_gaps(frame: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Return the number of frames to the next listed frame.

    The last frame of a recording gets the recording's median gap.

    A recording of a single frame has a gap of 1.

    Parameters
    ----------
    frame
        Frame numbers, int64, shape (n_frames,), increasing in each recording.
    first
        First row of each recording, shape (n_recordings + 1,).
    """
    gap = np.ones(len(frame))
    if len(frame) > 1:
        gap[:-1] = np.diff(frame)
    for i in range(len(first) - 1):  # a loop over recordings: hundreds, not millions
        own = gap[first[i] : first[i + 1]]
        if len(own):
            own[-1] = _median_gap(own[:-1]) if len(own) > 1 else 1.0
    return gap


def _median_gap(gap: np.ndarray) -> float:
    """Return the median gap, with a shortcut if all gaps are equal, as they usually are."""
    return float(gap[0] if (gap == gap[0]).all() else np.median(gap))
