"""Fusion what-if: the systems ``X or Y`` and ``X and Y``, from the detections of both."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.dataset.schema import DATASET_BOX_DTYPES, DETECTABILITY_COLUMNS, TRUTH, conform
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.pairs import pair_frames
from nvcore.metrics.proximity.borrowing import share_borrowed
from nvcore.settings.defaults import Settings


def pair_detections(
    x: BoxColumns,
    y: BoxColumns,
    is_kept_x: np.ndarray,
    is_kept_y: np.ndarray,
    frames: FrameColumns,
    *,
    iou: float = 0.5,
) -> np.ndarray:
    """Return the row of Y's detection paired with each of X's, or -1, int64, shape (n_x,).

    Within each frame, detections are paired greedily by descending IoU, down to `iou`.

    Parameters
    ----------
    is_kept_x, is_kept_y
        Detections that pass their own system's threshold; bool.
    """
    partner = np.full(len(x), -1, np.int64)
    pairs = x.arrays, is_kept_x, y.arrays, is_kept_y
    over_ranges(pair_frames, len(frames), *pairs, float(iou), partner)
    return partner


def fuse(
    dataset: Dataset,
    x_name: str,
    y_name: str,
    is_kept_x: np.ndarray,
    is_kept_y: np.ndarray,
    *,
    iou: float = 0.5,
) -> Dataset:
    """Return the dataset with ``X or Y`` and ``X and Y`` as its two systems.

    ``X or Y`` has X's box of every pair and all unpaired boxes of both. ``X and Y`` has only X's
    box of every pair. Fused boxes carry no score.
    """
    x, y = dataset.system(x_name), dataset.system(y_name)
    partner = pair_detections(x, y, is_kept_x, is_kept_y, dataset.frame_columns, iou=iou)
    is_paired_y = np.zeros(len(y), dtype=bool)
    is_paired_y[partner[partner >= 0]] = True
    unpaired_y = y.first_row + np.flatnonzero(is_kept_y & ~is_paired_y)
    either = np.concatenate([x.first_row + np.flatnonzero(is_kept_x), unpaired_y])
    both = x.first_row + np.flatnonzero(partner >= 0)
    frame_index = dataset.boxes["frame_index"].to_numpy()
    either = either[np.argsort(frame_index[either], kind="stable")]  # in a frame X's before Y's
    n_truth = len(dataset.truth)
    rows = np.concatenate([np.arange(n_truth), either, both])
    # column by column: every box is copied once
    unknown = () if dataset.has_detectability else DETECTABILITY_COLUMNS
    columns: dict[str, Any] = {
        str(name): dataset.boxes[name].to_numpy()[rows]
        for name in dataset.boxes
        if name not in unknown
    }
    columns["source"] = np.repeat([TRUTH, 1, 2], [n_truth, len(either), len(both)])
    columns["score"][n_truth:] = np.nan
    fused = replace(
        dataset,
        boxes=conform(columns, DATASET_BOX_DTYPES, n_rows=len(rows)),
        systems=(f"{x_name} or {y_name}", f"{x_name} and {y_name}"),
        settings=Settings(),
    )
    # borrow from the original systems, or pedestrians would weigh differently for the fused ones
    share_borrowed(dataset, fused)
    return fused
