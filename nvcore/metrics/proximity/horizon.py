"""Row of the horizon, estimated from pedestrians' heights and foot rows.

On flat ground a person's height in the picture is proportional to the depth of the feet below the
horizon: ``h = k * (foot - horizon)``, where k is the person's height over that of the camera.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

from nvcore.common.wording import minus
from nvcore.dataset import Dataset
from nvcore.dataset.schema import EDGE_PX
from nvcore.metrics.encounters import encounters_of

LEAST_BOXES: Final = 30
LEAST_PEDESTRIANS: Final = 3
"""With fewer pedestrians, the error of the estimate is unknown."""
LEAST_R2: Final = 0.5
"""Least share of the variance that heights and foot rows have in common."""
ONE_LINE: Final = 0.9999
"""Share from which both regressions count as the same line."""
LARGEST_MARGIN: Final = 0.1
"""Largest margin of an accepted estimate, as a share of the picture's height."""
GROUPS: Final = 20
"""Largest number of groups of pedestrians that are left out in turn (jackknife)."""
MOST_BOXES: Final = 5_000
"""Most boxes used for fitting; of more boxes every n-th is used."""
_HUBER: Final = 1.345
_MOST_STEPS: Final = 20


@dataclass(frozen=True)
class Horizon:
    """Estimate of the horizon.

    Attributes
    ----------
    row_px
        Row of the horizon, px from the picture's top; negative above the picture.
    margin_px
        Half the width of the 95 % interval, px.
    n_boxes, n_pedestrians
        Numbers of boxes and pedestrians that the estimate is based on.
    """

    row_px: float
    margin_px: float
    n_boxes: int
    n_pedestrians: int

    @property
    def text(self) -> str:
        """Template with row, interval and basis of the estimate.

        For example: "row 155 (95 %: 148 to 162; 1,216 boxes of 18 {many})".
        """
        ends = self.row_px, self.row_px - self.margin_px, self.row_px + self.margin_px
        row, low, high = (minus(f"{end:z.0f}") for end in ends)
        return (
            f"row {row} (95 %: {low} to {high}; {self.n_boxes:,} boxes of "
            f"{self.n_pedestrians:,} {{many}})"
        )


def estimate_horizons(dataset: Dataset) -> tuple[Horizon | None, ...]:
    """Estimate each recording's horizon from the boxes of its truth, or None if uncertain.

    The result is cached. Occluded boxes are left out, as are those within 1 px of the picture's
    edge, which may be cut.
    """
    if not dataset.objects.is_on_road:
        return (None,) * len(dataset.recordings)
    return dataset.kept("horizons", _estimate_all)


def _estimate_all(dataset: Dataset) -> tuple[Horizon | None, ...]:
    truth, frames = dataset.truth, dataset.frame_columns
    _, encounters = encounters_of(dataset)
    rows = encounters.order
    occlusion = dataset.boxes["occlusion"].to_numpy()[rows]
    x, y, w, h = (side[rows] for side in truth.xywh)
    recording = frames.recording[encounters.frame_index]
    is_whole = (x > EDGE_PX) & (y > EDGE_PX) & (occlusion <= 0)
    is_whole &= (x + w < frames.width[recording] - EDGE_PX) & (
        y + h < frames.height[recording] - EDGE_PX
    )
    pedestrian = encounters.encounter_of[rows]
    horizons = []
    for row, height in enumerate(frames.height):  # a loop over recordings
        own = np.flatnonzero(is_whole & (recording == row))
        horizon = estimate_horizon(y[own] + h[own], h[own], pedestrian[own])
        is_sure = horizon is not None and horizon.margin_px <= LARGEST_MARGIN * height
        horizons.append(horizon if is_sure else None)
    return tuple(horizons)


def estimate_horizon(
    foot_px: np.ndarray, height_px: np.ndarray, pedestrian: np.ndarray
) -> Horizon | None:
    """Estimate the horizon by a robust line of heights over foot rows.

    The line lies half way (by the geometric mean of the slopes) between the regression of heights
    on rows and that of rows on heights, because both are uncertain: people differ in stature, and
    the camera pitches. Both regressions weigh outliers down (Huber). The interval comes from a
    jackknife over pedestrians, by Student's t.

    Parameters
    ----------
    foot_px, height_px
        Row of the feet and height of boxes; float64, shape (n,).
    pedestrian
        Pedestrian that each box belongs to; int64, shape (n,).

    Returns
    -------
    None with fewer than `LEAST_BOXES` boxes or `LEAST_PEDESTRIANS`, or where the heights do not
    grow with the rows.

    References
    ----------
    ``docs/metrics.md``, horizon.
    """
    people, person = np.unique(pedestrian, return_inverse=True)
    n_boxes = len(foot_px)
    if n_boxes < LEAST_BOXES or len(people) < LEAST_PEDESTRIANS:
        return None
    step = -(-n_boxes // MOST_BOXES)
    foot_px, height_px, group = foot_px[::step], height_px[::step], person[::step] % GROUPS
    row_px = _zero_of_line(foot_px, height_px)
    n_groups = min(len(people), GROUPS)
    without = np.array(
        [
            _zero_of_line(foot_px[group != left_out], height_px[group != left_out])
            for left_out in range(n_groups)
        ]
    )
    variance = (n_groups - 1) / n_groups * ((without - without.mean()) ** 2).sum()
    margin = float(scipy.special.stdtrit(n_groups - 1, 0.975) * np.sqrt(variance))
    if not np.isfinite(row_px + margin):
        return None
    return Horizon(row_px, margin, n_boxes, len(people))


def _zero_of_line(foot_px: np.ndarray, height_px: np.ndarray) -> float:
    """Return the foot row at which the height is 0, or NaN if heights do not grow with the rows."""
    if len(foot_px) < LEAST_BOXES:
        return np.nan
    foot_at_zero, foot_slope = _robust_line(height_px, foot_px)
    height_at_zero, height_slope = _robust_line(foot_px, height_px)
    shared = foot_slope * height_slope  # 1 where all points lie on a line
    if not (foot_slope > 0 and shared >= LEAST_R2):
        return np.nan
    if shared >= ONE_LINE:
        return foot_at_zero
    middle_px = (foot_at_zero + foot_slope * height_at_zero) / (1 - shared)  # where they cross
    middle_height = height_at_zero + height_slope * middle_px
    return float(middle_px - np.sqrt(foot_slope / height_slope) * middle_height)


def _robust_line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Return value at 0 and slope of y over x, weighing outliers down (iterated Huber weights)."""
    weight = np.ones(len(x))
    at_zero = slope = np.nan
    for _ in range(_MOST_STEPS):
        total = weight.sum()
        x_mean, y_mean = (weight * x).sum() / total, (weight * y).sum() / total
        spread = (weight * (x - x_mean) ** 2).sum()
        if not spread > 0:
            return np.nan, np.nan
        before = slope
        slope = float((weight * (x - x_mean) * (y - y_mean)).sum() / spread)
        at_zero = float(y_mean - slope * x_mean)
        off = np.abs(y - at_zero - slope * x)
        scale = 1.4826 * np.median(off)
        if abs(slope - before) <= 1e-6 * abs(slope) or not scale > 0:
            break
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(off, 1e-12))
    return at_zero, slope
