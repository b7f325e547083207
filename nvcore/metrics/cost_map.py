"""Cost of missing a pedestrian at each position in the picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from nvcore.common.errors import ParameterError
from nvcore.common.wording import count_text
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.metrics.proximity import in_use, sigmoid
from nvcore.metrics.similarity import border_at
from nvcore.settings.params import Params

N_COLUMNS: Final = 128
N_ROWS: Final = 96
LEAST_BOXES: Final = 10
"""Fewest boxes through which a line is fitted."""
LEAST_SPREAD: Final = 0.01
"""Least standard deviation of the foot rows for fitting a line, as a share of the picture's height.
"""

Basis = Literal["height", "horizon", "distance", "none", "one height"]


@dataclass(frozen=True, eq=False)
class CostMap:
    """Cost of missing a pedestrian, ``k * border / (W/2)``, on a grid over one recording's picture.

    The weight k depends only on the row of the feet, the border only on the lateral position.

    Attributes
    ----------
    centre_px
        Lateral positions: centres of equally wide columns; float64, (n_columns,).
    foot_px
        Foot rows: centres of equally high rows; float64, (n_rows,).
    border
        Border of each position as a share of W/2, 0 to 1; float64, (n_columns,).
    k
        Weight of a pedestrian with their feet in each row, in (0, 1); NaN at and above the horizon,
        where nobody can stand; float64, (n_rows,).
    basis
        Source of k: ``height`` (typical height of this recording's pedestrians with their feet in
        that row), ``distance`` (their typical distance), ``horizon`` (the row itself), ``none`` (k
        is 1) or ``one height`` (no line fits the boxes, so every row uses `height_px`).
    n_boxes
        Number of boxes that the line was fitted to.
    height_px
        Height used with ``one height``, px; otherwise NaN.
    """

    centre_px: np.ndarray
    foot_px: np.ndarray
    border: np.ndarray
    k: np.ndarray
    basis: Basis
    n_boxes: int
    height_px: float

    @property
    def cost(self) -> np.ndarray:
        """Cost at each position, 0 to 1, float64, (n_rows, n_columns).

        NaN where nobody can stand.
        """
        cost: np.ndarray = np.outer(self.k, self.border)
        return cost

    @property
    def text(self) -> str:
        """Explanation of the weight's source, as a template with words for the objects."""
        boxes = count_text(self.n_boxes, "box", "boxes")
        return {
            "height": f"height by foot row, a line through {boxes} of this recording",
            "distance": f"distance by foot row, a line through {boxes} of this recording",
            "horizon": "depth of the {feet} below the horizon",
            "none": "{everybody} weighs the same",
            "one height": f"by lateral position only, for {{a_one}} {self.height_px:.0f} px tall: "
            "no line goes through the boxes of this recording",
        }[self.basis]


class FootLine(NamedTuple):
    """Straight line of a value against the foot row: ``at_zero + slope * foot row``."""

    at_zero: float
    slope: float

    def at(self, foot_px: np.ndarray) -> np.ndarray:
        """Return the line's value at these foot rows."""
        values: np.ndarray = self.at_zero + self.slope * foot_px
        return values


def fit_line(foot_px: np.ndarray, value: np.ndarray, *, height: float) -> FootLine | None:
    """Fit a least-squares line of a value against the foot row, or return None if unreliable.

    The line is unreliable with fewer than `LEAST_BOXES` boxes, if all feet are in about the same
    row, or if the value does not grow downwards.

    Parameters
    ----------
    foot_px, value
        float64, shape (n,).
    height
        Height of the picture, px.
    """
    if len(foot_px) < LEAST_BOXES or foot_px.std() < LEAST_SPREAD * height:
        return None
    centred = foot_px - foot_px.mean()
    slope = float((centred * (value - value.mean())).sum() / (centred**2).sum())
    if slope <= 0:
        return None
    return FootLine(float(value.mean()) - slope * float(foot_px.mean()), slope)


def map_cost(
    truth: BoxColumns,
    frames: FrameColumns,
    params: Params,
    recording: int,
    *,
    n_rows: int = N_ROWS,
    n_columns: int = N_COLUMNS,
) -> CostMap:
    """Compute the cost of missing a pedestrian at each position in a recording's picture.

    With proximity by height, a straight line through the recording's boxes gives the height in each
    foot row, because height grows linearly with the foot row on flat ground. Boxes cut by the
    picture's upper or lower edge are left out. With proximity by distance, the line gives the
    inverse of the distance; recordings without distances use the height, as the boxes themselves
    do. If no line is reliable, every row has the boxes' median height (the midpoint if there are no
    boxes), and the cost varies only with the lateral position.

    Parameters
    ----------
    truth
        Boxes of all recordings; ignored boxes are skipped.
    recording
        Row in the table of recordings.
    n_rows, n_columns
        Size of the grid.

    Raises
    ------
    ParameterError
        If proximity is by horizon and neither the parameter nor the recording gives one.

    References
    ----------
    ``docs/metrics.md``, severity.
    """
    width, height = float(frames.width[recording]), float(frames.height[recording])
    centre_px = (np.arange(n_columns) + 0.5) * width / n_columns
    foot_px = (np.arange(n_rows) + 0.5) * height / n_rows
    rho = float(in_use(params, "edge_weight", frames)[recording])
    k, basis, n_boxes, height_px = _weigh_rows(truth, frames, params, recording, foot_px)
    return CostMap(
        centre_px=centre_px,
        foot_px=foot_px,
        border=border_at(centre_px, width, rho) / (0.5 * width),
        k=k,
        basis=basis,
        n_boxes=n_boxes,
        height_px=height_px,
    )


def _weigh_rows(
    truth: BoxColumns, frames: FrameColumns, params: Params, recording: int, foot_px: np.ndarray
) -> tuple[np.ndarray, Basis, int, float]:
    """Return `k`, `basis`, `n_boxes` and `height_px` of `CostMap` for these foot rows."""
    nan = float("nan")
    if params.proximity == "none":
        return np.ones(len(foot_px)), "none", 0, nan
    midpoint, spread, horizon = (
        float(in_use(params, name, frames)[recording]) for name in ("midpoint", "spread", "horizon")
    )
    if params.proximity == "horizon":
        if np.isnan(horizon):
            raise ParameterError("proximity by horizon needs the row of the horizon")
        depth = foot_px - horizon
        k = sigmoid((depth - midpoint) / spread)
        return np.where(depth > 0, k, np.nan), "horizon", 0, nan
    picture_height = float(frames.height[recording])
    rows = truth.rows_of(*frames.first[recording : recording + 2])
    is_pedestrian = ~truth.ignore[rows]
    top, tall, metres = (
        values[rows][is_pedestrian] for values in (truth.y, truth.h, truth.distance_m)
    )
    foot = top + tall
    if params.proximity == "distance":
        is_known = np.isfinite(metres) & (metres > 0)
        line = fit_line(foot[is_known], 1 / metres[is_known], height=picture_height)
        if line is not None:
            nearness = line.at(foot_px)
            is_ground = nearness > 0
            away_m = 1 / np.where(is_ground, nearness, 1)
            k = sigmoid((params.midpoint_m - away_m) / params.spread_m)
            return np.where(is_ground, k, np.nan), "distance", int(is_known.sum()), nan
    is_whole = (top > 1) & (foot < picture_height - 1)
    line = fit_line(foot[is_whole], tall[is_whole], height=picture_height)
    if line is not None:
        tall_there = line.at(foot_px)
        k = sigmoid((tall_there - midpoint) / spread)
        return np.where(tall_there > 0, k, np.nan), "height", int(is_whole.sum()), nan
    chosen = float(np.median(tall)) if len(tall) else midpoint
    k = sigmoid(np.full(len(foot_px), (chosen - midpoint) / spread))
    return k, "one height", 0, chosen
