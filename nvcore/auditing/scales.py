"""At which resolutions detections are commonly made, and which one the data point to."""

from __future__ import annotations

from fractions import Fraction
from typing import Final

import numpy as np

from nvcore.auditing.overlaps import Correction, Sample

RATIOS: Final = tuple(
    Fraction(a, b)
    for a, b in ((1, 4), (1, 3), (2, 5), (1, 2), (3, 5), (5, 8), (2, 3), (3, 4), (4, 5), (5, 6))
)
"""Usual ratios of two picture sizes, the smaller one over the larger one."""
SIZES: Final = (
    (300, 300), (320, 320), (416, 416), (512, 512), (608, 608), (640, 640), (1024, 1024),
    (320, 240), (320, 256), (384, 288), (640, 480), (640, 512), (1024, 768), (1280, 720),
    (1280, 1024), (1920, 1080),
)  # fmt: skip
"""Usual input sizes of networks and picture sizes, px."""
INPUT_SIDES: Final = (300, 320, 416, 512, 608, 640, 768, 800, 960, 1024, 1280, 1536)
"""Longer sides of inputs into which pictures are fitted with bars, px."""
STRIDE: Final = 32
"""By which the sides of inputs can be divided."""
MIN_BAR: Final = 1.0
"""Narrower bars, in px of the input, make no difference."""
SNAP: Final = 0.015
"""A measured ratio that is as near to a usual one as this is taken for it."""
MIN_ASPECT: Final = 0.1
"""Measured factors for x and y that differ by less than this are one factor and an offset."""


def scale_candidates(sample: Sample) -> list[tuple[float, float]]:
    """Factors (for x and w, for y and h) that may bring the detections to the picture's size.

    The usual ratios, the usual sizes (where all recordings are of one size), and the ratio that
    the centres of pedestrians and detections have to one another.
    """
    factors = [float(factor) for ratio in RATIOS for factor in (ratio, 1 / ratio)]
    pairs = [(factor, factor) for factor in factors]
    frames = sample.dataset.frame_columns
    if np.ptp(frames.width) == 0 and np.ptp(frames.height) == 0:
        W, H = float(frames.width[0]), float(frames.height[0])
        pairs += [(W / w, H / h) for w, h in SIZES]
    measured = _measure_scale(sample)
    if measured is not None:
        pairs.append(measured)
    doubles = {(round(x, 6), round(y, 6)) for x, y in pairs} - {(1.0, 1.0)}
    return sorted(doubles)


def letterboxes(sample: Sample) -> list[Correction]:
    """What undoes a resizing to a network's input that keeps the shape and fills the rest by bars.

    Of the square inputs, and of those whose shorter side is the next multiple of `STRIDE`.
    """
    frames = sample.dataset.frame_columns
    if np.ptp(frames.width) or np.ptp(frames.height):
        return []
    W, H = float(frames.width[0]), float(frames.height[0])
    corrections = []
    for side in INPUT_SIDES:
        factor = max(W, H) / side
        across, down = (side - W / factor) / 2, (side - H / factor) / 2
        bars = (across, down), (across % (STRIDE / 2), down % (STRIDE / 2))
        corrections += [
            Correction((factor, factor), (0.0 - factor * across, 0.0 - factor * down))
            for across, down in bars
            if max(across, down) >= MIN_BAR
        ]
    return corrections


def _measure_scale(sample: Sample) -> tuple[float, float] | None:
    """Median ratio of the centres of pedestrians and detections in the same order."""
    truth, det = sample.dataset.truth, sample.detections
    g, d = sample.pairs_by_order
    centres = np.stack(
        [
            truth.x[g] + truth.w[g] / 2,
            truth.y[g] + truth.h[g] / 2,
            det.x[d] + det.w[d] / 2,
            det.y[d] + det.h[d] / 2,
        ]
    )
    inside = np.all(centres > 1, axis=0)
    if not inside.any():
        return None
    sx, sy = np.median(centres[:2, inside] / centres[2:, inside], axis=1).tolist()
    if abs(sx / sy - 1) < 2 * SNAP:
        sx = sy = (sx * sy) ** 0.5
    elif abs(sx / sy - 1) < MIN_ASPECT:
        return None
    return _snapped(sx), _snapped(sy)


def _snapped(factor: float) -> float:
    for ratio in RATIOS:
        for usual in (float(ratio), float(1 / ratio)):
            if abs(factor / usual - 1) < SNAP:
                return usual
    return round(factor, 3)


def scale_text(sx: float, sy: float) -> str:
    """The factors in words, such as ``2`` or ``1.5 across and 1.2 down``."""
    return f"{sx:.4g}" if sx == sy else f"{sx:.4g} across and {sy:.4g} down"
