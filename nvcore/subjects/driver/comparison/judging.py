"""Judge whom the driver sees unaided, and combine that with what X and Y detect.

Detectability is the share of drivers, 0 to 1, who would see the pedestrian of a truth box unaided.
It is stated by the ground truth, or estimated from pictures.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.dataset.columns import Detectability
from nvcore.metrics.encounters import RELEVANT_K, Encounters
from nvcore.metrics.venn import Venn
from nvcore.settings.params import Params


class DriverRegion(StrEnum):
    """Region of the three-way Venn diagram of the encounters that the driver, X and Y see."""

    DRIVER_X_Y = "driver_x_y"
    DRIVER_X = "driver_x"
    DRIVER_Y = "driver_y"
    DRIVER = "driver"
    X_Y = "x_y"
    X = "x"
    Y = "y"
    NOBODY = "nobody"
    UNKNOWN = "unknown"
    DISTANT = "distant"


DRIVER_REGION_TEXT: Final[dict[DriverRegion, str]] = {
    DriverRegion.DRIVER_X_Y: "The driver and both systems: both warnings are redundant.",
    DriverRegion.DRIVER_X: "The driver and X, not Y: the warning of X is redundant.",
    DriverRegion.DRIVER_Y: "The driver and Y, not X: the warning of Y is redundant.",
    DriverRegion.DRIVER: "The driver, but neither X nor Y: a warning would be redundant.",
    DriverRegion.X_Y: "Not the driver, but both X and Y: either can warn.",
    DriverRegion.X: "Neither the driver nor Y, but X: only X can warn.",
    DriverRegion.Y: "Neither the driver nor X, but Y: only Y can warn.",
    DriverRegion.NOBODY: "Neither the driver nor X nor Y: the {one} is unprotected.",
    DriverRegion.UNKNOWN: "It is not known whether the driver sees the {one}.",
    DriverRegion.DISTANT: "The {one} never came near enough to count.",
}

SELDOM: Final = 0.5
"""Share of the known frames below which seeing a pedestrian is called seldom (ours)."""


def judge_driver(
    detectability: Detectability, encounters: Encounters, k_truth: np.ndarray, params: Params
) -> pd.DataFrame:
    """Judge whether the driver sees each pedestrian unaided by the first relevant frame.

    The driver sees a pedestrian if detectability reaches `driver_threshold` in a frame up to the
    first relevant one (``k >= 0.5``). The first such frame is the confirmation. Frames with unknown
    detectability are skipped.

    Parameters
    ----------
    k_truth
        Proximity weight of each truth box; float64, shape (n_truth,).

    Returns
    -------
    One row per encounter: detectability (the largest one up to the first relevant frame, 0..1, NaN
    if the encounter is distant or it is unknown in all of these frames), sd (of that value),
    is_within_sd (whether that value is within its sd of the threshold), n_known (number of these
    frames with known detectability), n_seen (number of these frames in which it reaches
    `driver_threshold`), is_outside (whether the decision rests on an estimate outside the training
    range: the largest one, or any of them if the largest is below the threshold), is_adapted
    (whether the largest one was estimated for adapted eyes, that is, no change from bright to dark
    is known before), seen_row (frame row of the confirmation, -1 if not seen or unknown),
    confirmed_row (first frame overall, including later ones, in which it reaches the threshold, -1
    if none), known_row (first frame overall in which it is known, -1 if none).

    References
    ----------
    ``docs/driver.md``, section on the comparison.
    ``docs/decisions/050-driver-in-the-comparison.md``.
    """
    n, threshold, order = len(encounters), params.driver_threshold, encounters.order
    encounter = np.repeat(np.arange(n), np.diff(encounters.offsets))
    frame, value = encounters.frame_index, detectability.value[order]
    frame_at = np.append(frame, -1)  # index -1 stands for none

    def first(is_member: np.ndarray) -> np.ndarray:
        """Return the first place of a member in each encounter, -1 for none."""
        places = np.flatnonzero(is_member)
        places = places[np.diff(encounter[places], prepend=-1) != 0]
        place = np.full(n, -1)
        place[encounter[places]] = places
        return place

    def n_frames(is_member: np.ndarray) -> np.ndarray:
        of, at = encounter[is_member], frame[is_member]
        is_new = (np.diff(of, prepend=-1) != 0) | (np.diff(at, prepend=-1) != 0)
        return np.bincount(of[is_new], minlength=n)

    relevant = frame_at[first(k_truth[order] >= RELEVANT_K)][encounter]
    is_known = ~np.isnan(value) & (relevant >= 0)
    is_before, sees = is_known & (frame <= relevant), is_known & (value >= threshold)
    highest = np.maximum.reduceat(np.where(is_before, value, -np.inf), encounters.offsets[:-1])
    place = first(is_before & (value == highest[encounter]))
    highest[place < 0] = np.nan
    row = np.append(order, -1)[place]
    sd = np.where(place < 0, np.nan, np.append(detectability.sd, np.nan)[row])
    is_outside, is_adapted = (
        np.append(of_boxes, False)[row] & (place >= 0)
        for of_boxes in (detectability.is_outside, detectability.is_adapted)
    )
    seen_row = frame_at[first(sees & is_before)]
    n_outside = n_frames(is_before & detectability.is_outside[order])
    return pd.DataFrame(
        {
            "detectability": highest,
            "sd": sd,
            "is_outside": is_outside | ((seen_row < 0) & (n_outside > 0)),
            "is_adapted": is_adapted,
            "is_within_sd": np.abs(highest - threshold) <= sd,  # False for NaN
            "n_known": n_frames(is_before),
            "n_seen": n_frames(is_before & sees),
            "seen_row": seen_row,
            "confirmed_row": frame_at[first(sees)],
            "known_row": frame_at[first(is_known)],
        }
    )


def weigh_unseen(dataset: Dataset, params: Params) -> np.ndarray | None:
    """Return factors by which `driver_weighting` multiplies the weight of each missed pedestrian.

    ``1 - detectability``, and 1 where that is unknown.

    Returns
    -------
    float64, shape (n_truth,), 0..1. None: 1 for all of them.
    """
    detectability = dataset.detectability.value
    if params.driver_weighting == "off" or np.isnan(detectability).all():
        return None
    weights: np.ndarray = 1 - np.nan_to_num(detectability, nan=0.0)
    return weights


def is_unknown(dataset: Dataset) -> np.ndarray:
    """Return which truth boxes are pedestrians of unknown detectability, bool, shape (n_truth,).

    With `driver_weighting` they have full weight.
    """
    is_missing: np.ndarray = np.isnan(dataset.detectability.value) & ~dataset.truth.ignore
    return is_missing


@dataclass(frozen=True, eq=False)
class DriverView:
    """Encounters by whether the driver sees them unaided, and whether X and Y detect them.

    Arrays have the shape (n_encounters,); masks are bool.

    Attributes
    ----------
    table
        Table from `judge_driver`.
    is_near, by_x, by_y
        Encounters that count, and those detected by X and Y.
    """

    table: pd.DataFrame
    is_near: np.ndarray
    by_x: np.ndarray
    by_y: np.ndarray

    @cached_property
    def is_known(self) -> np.ndarray:
        """Mask of near encounters with known detectability, shape (n_encounters,)."""
        is_known: np.ndarray = self.is_near & ~np.isnan(self.table["detectability"].to_numpy())
        return is_known

    @cached_property
    def has_any(self) -> bool:
        """Whether any near encounter has known detectability."""
        return bool(self.is_known.any())

    @property
    def is_seen(self) -> np.ndarray:
        """Mask of near encounters that the driver sees unaided."""
        return self._known(self.table["seen_row"] >= 0)

    @property
    def is_unseen(self) -> np.ndarray:
        """Mask of near encounters that the driver is known not to see."""
        return self._known(self.table["seen_row"] < 0)

    @cached_property
    def region(self) -> np.ndarray:
        """Region of each encounter in the Venn diagram, values of `DriverRegion`, object.

        Encounters that are not near are `distant`. Near ones with unknown detectability are
        `unknown`.
        """
        code = 4 * ~self.is_seen + 2 * ~self.by_x + ~self.by_y
        code = np.select([~self.is_near, ~self.is_known], [9, 8], default=code)
        regions: np.ndarray = np.array([of.value for of in DriverRegion], dtype=object)[code]
        return regions

    @cached_property
    def counts(self) -> dict[DriverRegion, int]:
        """Number of encounters in each region, including unknown and distant ones."""
        counts = Counter(self.region.tolist())
        return {kind: counts[kind.value] for kind in DriverRegion}

    @property
    def n_known(self) -> int:
        """Number of near encounters with known detectability."""
        return int(np.count_nonzero(self.is_known))

    @property
    def n_seen(self) -> int:
        """Number of near encounters that the driver sees unaided."""
        return int(np.count_nonzero(self.is_seen))

    @property
    def n_unseen(self) -> int:
        """Number of near encounters that the driver is known not to see and needs a warning of."""
        return self.n_known - self.n_seen

    @property
    def has_sd(self) -> np.ndarray:
        """Mask of near encounters whose detectability has a standard deviation."""
        return self._known(self.table["sd"].notna())

    @property
    def is_within_sd(self) -> np.ndarray:
        """Mask of near encounters whose detectability is within its sd of the threshold."""
        return self._known(self.table["is_within_sd"])

    @property
    def is_outside(self) -> np.ndarray:
        """Mask of near encounters decided by an estimate outside the training range."""
        return self._known(self.table["is_outside"])

    @property
    def is_adapted(self) -> np.ndarray:
        """Mask of near encounters decided by an estimate for adapted eyes."""
        return self._known(self.table["is_adapted"])

    def _known(self, is_member: pd.Series) -> np.ndarray:
        mask: np.ndarray = is_member.to_numpy() & self.is_known
        return mask

    @property
    def is_seldom_seen(self) -> np.ndarray:
        """Mask of near encounters that the driver sees in less than `SELDOM` of their known frames.

        Only frames up to the first relevant one count.
        """
        is_seldom = self.table["n_seen"] < SELDOM * self.table["n_known"]
        return self._known(is_seldom & (self.table["seen_row"] >= 0))


def split_unseen(driver: DriverView) -> Venn:
    """Return the Venn diagram of X and Y over the encounters that the driver does not see.

    All others count as distant.
    """
    kinds = DriverRegion.X_Y, DriverRegion.X, DriverRegion.Y, DriverRegion.NOBODY
    both, x_only, y_only, neither = (driver.counts[kind] for kind in kinds)
    return Venn(both, x_only, y_only, neither, len(driver.region) - driver.n_unseen)
