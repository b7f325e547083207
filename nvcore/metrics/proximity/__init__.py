"""Proximity: a box's weight by its apparent distance (paper, weighting function)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.common.errors import ParameterError
from nvcore.common.findings import Remedy, Step
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.settings.params import SETTINGS, Params
from nvcore.settings.params.traffic import UNSTATED

BLOCK: Final = 262_144
"""Boxes weighed at a time, which limits the memory of intermediate results. With smaller blocks the
two systems' threads wait for each other."""


LARGEST_EXPONENT: Final = 700.0
"""Largest exponent, to keep ``exp`` from overflowing. The weight there is 1e-304, practically 0."""


@dataclass(frozen=True)
class Weights:
    """Proximity weights of one source.

    Attributes
    ----------
    k
        Weights in (0, 1), larger is nearer (all 1 without proximity); float64, shape (n,).
    n_without_distance
        Number of boxes in G or S that are weighted by height because proximity is by distance and
        they have none.
    """

    k: np.ndarray
    n_without_distance: int


def sigmoid(z: np.ndarray) -> np.ndarray:
    """Compute ``1 / (1 + exp(-z))`` without overflow."""
    e: np.ndarray = np.negative(z)
    np.clip(e, -LARGEST_EXPONENT, LARGEST_EXPONENT, out=e)
    np.exp(e, out=e)
    e += 1
    np.divide(1, e, out=e)
    return e


def weigh_proximity(
    boxes: BoxColumns, is_counted: np.ndarray, frames: FrameColumns, params: Params
) -> Weights:
    """Compute the proximity weight of every box. Near ones count more.

    By height: ``k = 1 / (1 + exp(-(h - midpoint) / spread))``. By horizon: the same with the depth
    of the foot point below the horizon instead of h. By distance:
    ``k = 1 / (1 + exp((distance - midpoint_m) / spread_m))``, with boxes without a distance
    weighted by height.

    Parameters
    ----------
    boxes
        Boxes of one source, px, sorted by frame.
    is_counted
        Boxes that belong to G or S; bool, shape (n,). All boxes are weighed.

    Raises
    ------
    ParameterError
        If proximity is by horizon and neither the parameter nor a recording gives the horizon.

    References
    ----------
    Paper 11-0360, weighting function; ``docs/metrics.md``, proximity.
    """
    if params.proximity == "none":
        return Weights(np.ones(len(boxes)), 0)
    midpoint, spread = in_use(params, "midpoint", frames), in_use(params, "spread", frames)
    horizon = in_use(params, "horizon", frames)
    by_horizon = params.proximity == "horizon"
    if by_horizon and np.isnan(horizon).any():
        raise ParameterError(
            "proximity by horizon needs the row of the horizon, for all recordings or for each "
            "(horizon in the session file); nvcore check estimates it from the boxes",
            steps=(Step(Remedy.OPTION, "", "horizon"),),
        )
    zero = horizon + midpoint if by_horizon else midpoint
    k = np.empty(len(boxes))
    for rows, recording in _blocks(boxes, frames, np.column_stack([zero, spread])):
        size = boxes.y[rows] + boxes.h[rows] if by_horizon else boxes.h[rows]
        z = (size - zero[recording]) / spread[recording]
        if params.proximity == "distance":
            metres = boxes.distance_m[rows]
            by_distance = (params.midpoint_m - metres) / params.spread_m
            z = np.where(np.isnan(metres), z, by_distance)
        k[rows] = sigmoid(z)
    n_without = 0
    if params.proximity == "distance":
        n_without = int(np.count_nonzero(np.isnan(boxes.distance_m) & is_counted))
    return Weights(k, n_without)


def _blocks(
    boxes: BoxColumns, frames: FrameColumns, settings: np.ndarray
) -> Iterator[tuple[slice, int]]:
    """Yield the rows of boxes in blocks, each with a recording whose settings apply to the block.

    Parameters
    ----------
    settings
        Settings of each recording, shape (n_recordings, n_settings); consecutive recordings with
        the same settings share blocks.
    """
    if not len(settings):
        return
    changes = np.flatnonzero((settings[1:] != settings[:-1]).any(axis=1)) + 1
    first_recordings = np.concatenate([[0], changes])
    edges = boxes.offsets[frames.first[np.concatenate([first_recordings, [len(settings)]])]]
    for i, recording in enumerate(first_recordings):  # a loop over blocks: thousands of boxes each
        for start in range(int(edges[i]), int(edges[i + 1]), BLOCK):
            yield slice(start, min(start + BLOCK, int(edges[i + 1]))), int(recording)


def in_use(params: Params, name: str, frames: FrameColumns) -> np.ndarray:
    """Return a setting's value for each recording: the recording's own if `params` gives none.

    Parameters
    ----------
    name
        ``midpoint``, ``spread`` or ``horizon`` (px, NaN where unknown), or ``edge_weight``.
    """
    value, share = getattr(params, name), SETTINGS[name].height_share
    if value is not None:
        return np.full(len(frames.fps), float(value))
    if name == "edge_weight":
        stated: np.ndarray = np.nan_to_num(frames.context, nan=UNSTATED)
        return stated
    return frames.horizon if share is None else share * frames.height
