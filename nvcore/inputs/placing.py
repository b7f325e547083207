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
"""Frame numbers for each box and listed frame up to which a table of all of them is quickest."""


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

    def of(self, boxes: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
        """Row of the frames table of each box, and its fault: a place in `REASONS`; int8."""
        names = boxes["recording"].array
        codes = self._names.get_indexer(names.categories)[names.codes]
        fault = np.zeros(len(boxes), np.int8)
        if codes.min(initial=0) < 0:
            fault[codes < 0] = 1
        if len(self._span) == 1:
            codes = np.zeros(1, np.int64)  # the same for all
        last = self._before + self._span - 1
        key = np.clip(boxes["frame"].to_numpy(), self._before[codes], last[codes])
        key += (self._start - self._before)[codes]
        position, is_listed = self._rows_of(key)
        x, y, w, h = (boxes[name].to_numpy() for name in "xywh")
        for reason, is_good in (
            (2, is_listed),
            (3, np.isfinite(x) & np.isfinite(y) & np.isfinite(w) & np.isfinite(h)),
            (4, (w > 0) & (h > 0)),
        ):
            if not is_good.all():
                fault[~is_good & (fault == 0)] = reason
        return position, fault

    def _rows_of(self, key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Row of each key in the frames table, and whether it is there."""
        n_keys, n_rows = int(self._span.sum()), len(self._listed)
        if n_keys > DENSE * (n_rows + len(key)):  # few frames of long recordings
            position = np.minimum(np.searchsorted(self._listed, key), n_rows - 1)
            return position, self._listed[position] == key
        row_of = np.full(n_keys, -1, np.int64)
        row_of[self._listed] = np.arange(n_rows)
        position = row_of[key]
        return position, position >= 0
