"""Which row of the frames table each box belongs to."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

REASONS: Final = (
    "",
    "unknown recording",
    "frame not listed",
    "not a number",
    "no area",
)
"""Why a box has no place, in the order in which they are looked for; none where it has one."""
DENSE: Final = 4
"""Frame numbers for each listed one up to which a table of all of them is quickest."""
BLOCK: Final = 1 << 15
"""Boxes that are placed at a time."""


class Places:
    """Where the evaluated frames of all recordings are in the frames table."""

    def __init__(self, names: pd.Series[str], frames: list[np.ndarray]) -> None:
        self._names = pd.Index(names)
        # one number per recording and frame; frames outside the list share the places at its ends,
        # so that a frame number of any size fits
        self._before = np.array([listed[0] - 1 for listed in frames])
        self._span = np.array([listed[-1] - listed[0] + 3 for listed in frames])
        self._start = np.cumsum(self._span) - self._span
        self._listed = np.concatenate(
            [self._start[i] + (f - self._before[i]) for i, f in enumerate(frames)]
        )
        self._row_of: np.ndarray | None = None
        n_keys, n_rows = int(self._span.sum()), len(self._listed)
        if n_keys <= DENSE * n_rows:  # else few frames of long recordings
            self._row_of = np.full(n_keys, -1, np.int64)
            self._row_of[self._listed] = np.arange(n_rows)

    def of(self, boxes: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
        """Row of the frames table of each box, and its fault: a place in `REASONS`; int8."""
        names = boxes["recording"].array
        of_name = self._names.get_indexer(names.categories)
        codes, frame = names.codes, boxes["frame"].to_numpy()
        x, y, w, h = (boxes[name].to_numpy() for name in "xywh")
        position, fault = np.empty(len(boxes), np.int64), np.zeros(len(boxes), np.int8)
        last = self._before + self._span - 1
        shift = self._start - self._before
        # block by block, so that what is computed on the way stays in the processor's memory
        for begin in range(0, len(boxes), BLOCK):
            rows = slice(begin, begin + BLOCK)
            of_row = of_name[codes[rows]]
            key = np.clip(frame[rows], self._before[of_row], last[of_row]) + shift[of_row]
            position[rows], is_listed = self._rows_of(key)
            finite = np.isfinite(x[rows]) & np.isfinite(y[rows])
            finite &= np.isfinite(w[rows]) & np.isfinite(h[rows])
            has_area = (w[rows] > 0) & (h[rows] > 0)
            if not (is_listed & finite & has_area).all() or of_row.min() < 0:
                fault[rows] = np.select([of_row < 0, ~is_listed, ~finite, ~has_area], range(1, 5))
        return position, fault

    def _rows_of(self, key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Row of each key in the frames table, and whether it is there."""
        if self._row_of is None:
            position = np.minimum(np.searchsorted(self._listed, key), len(self._listed) - 1)
            return position, self._listed[position] == key
        position = self._row_of[key]
        return position, position >= 0
