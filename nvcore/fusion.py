"""Fusion what-if: the systems ``X or Y`` and ``X and Y``, from the detections of both."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd

from nvcore.dataset import BoxColumns, Dataset, FrameColumns, dataset_from_tables
from nvcore.kernels import over_ranges, pair_frames


def pair_detections(
    x: BoxColumns,
    y: BoxColumns,
    is_kept_x: np.ndarray,
    is_kept_y: np.ndarray,
    frames: FrameColumns,
    *,
    iou: float = 0.5,
) -> np.ndarray:
    """Row of Y's detection paired with each of X's, -1 none; int64, shape (n_x,).

    In each frame pairs are made greedily by descending IoU, down to `iou`.

    Parameters
    ----------
    is_kept_x, is_kept_y
        Detections that pass their own system's threshold; bool.
    """
    partner = np.full(len(x), -1, np.int64)
    over_ranges(
        pair_frames, len(frames), x.offsets, x.x, x.y, x.w, x.h, is_kept_x,
        y.offsets, y.x, y.y, y.w, y.h, is_kept_y, float(iou), partner,
    )  # fmt: skip
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
    """The dataset with ``X or Y`` and ``X and Y`` as its two systems.

    ``X or Y``: every pair once, by X's box, and all unpaired boxes of both; ``X and Y``: the pairs
    only, by X's box. Fused boxes carry no score.
    """
    x, y = dataset.system(x_name), dataset.system(y_name)
    partner = pair_detections(x, y, is_kept_x, is_kept_y, dataset.frame_columns, iou=iou)
    is_paired_y = np.zeros(len(y), dtype=bool)
    is_paired_y[partner[partner >= 0]] = True
    either_x, either_y = np.flatnonzero(is_kept_x), np.flatnonzero(is_kept_y & ~is_paired_y)
    paired_x = np.flatnonzero(partner >= 0)
    parts = [dataset.boxes.iloc[: dataset.source_starts[1]]]
    for source, boxes, rows in (
        (1, x, either_x),
        (1, y, either_y),
        (2, x, paired_x),
    ):
        part = dataset.boxes.iloc[boxes.first_row + rows]
        parts.append(part.assign(source=np.int16(source), score=np.nan))
    listed = dataset.frames["frame"].to_numpy()
    first = dataset.frame_columns.first
    return dataset_from_tables(
        dataset.recordings,
        [listed[a:b] for a, b in pairwise(first)],
        pd.concat(parts, ignore_index=True),
        (f"{x_name} or {y_name}", f"{x_name} and {y_name}"),
        fingerprint=dataset.fingerprint,
    )
