"""Distances of pedestrians that only the systems know, borrowed from the matches.

Borrowed distances depend only on the data, not on any setting: neither on thresholds nor on the
matching rule, nor on the two systems being compared (docs/decisions/041-borrowed-distances.md).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from nvcore.common.wording import count_text, listed, percent
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.metrics.encounters import Encounters, encounters_of
from nvcore.metrics.matching import match_boxes
from nvcore.settings.params import Params

LONGEST_GAP_S: Final = 2.0
"""Largest time between two known distances of a pedestrian for interpolating between them."""
_DERIVED: Final = "borrowed_distances"
"""Key in `Dataset.derived`."""
LENDING: Final = Params()
"""Matching rule: IoU of at least 0.5, in the order of the scores."""


@dataclass(frozen=True, eq=False)
class Borrowed:
    """Distances of the truth boxes, including borrowed ones.

    Attributes
    ----------
    distance_m
        The box's own distance, or else a borrowed one, NaN if unknown; float64, (n_truth,).
    n_own, n_reported, n_between, n_unknown
        Numbers of pedestrians' boxes by source of the distance: their own, reported by a match,
        interpolated along the track, none.
    lent
        Number of boxes for which each system reports a distance, by system name.
    n_compared
        Boxes without a distance of their own for which several systems report one.
    spread
        Median over the compared boxes of the reports' range as a share of their mean; NaN without
        any.
    """

    distance_m: np.ndarray
    n_own: int
    n_reported: int
    n_between: int
    n_unknown: int
    lent: dict[str, int]
    n_compared: int
    spread: float

    @property
    def n_borrowed(self) -> int:
        """Number of boxes with a borrowed distance."""
        return self.n_reported + self.n_between

    @property
    def text(self) -> str:
        """Sentence with the number of borrowed distances, their lenders and their disagreement."""
        lenders = [f"{name} ({n:,})" for name, n in self.lent.items() if n]
        if not lenders:
            return "no match reports a distance that could be borrowed"
        text = (
            f"{count_text(self.n_borrowed, 'truth box', 'truth boxes')} borrowed a distance: "
            f"{self.n_reported:,} as {listed(lenders)} "
            f"{'reports' if len(lenders) == 1 else 'report'}, {self.n_between:,} between those"
        )
        if not self.n_compared:
            return text
        return (
            f"{text}; where several report one ({self.n_compared:,}) they differ by "
            f"{percent(self.spread)} (median)"
        )


def weighing_truth(dataset: Dataset, params: Params) -> BoxColumns:
    """Return the truth with the distances used for its weights, borrowed if `params` say so."""
    if not borrows(params):
        return dataset.truth
    return replace(dataset.truth, distance_m=borrowed_distances(dataset).distance_m)


def borrows(params: Params) -> bool:
    """Whether pedestrians without a distance are weighed by a borrowed one."""
    return params.proximity == "distance" and params.missing_distance == "borrow"


def borrowed_distances(dataset: Dataset) -> Borrowed:
    """Return the distances of a dataset's truth, borrowing those that are missing.

    The result is cached: no setting changes it. A truth box without a distance takes the median of
    the distances that its matches of all systems report, whatever their scores. Between two boxes
    of the same pedestrian with an own or reported distance, at most `LONGEST_GAP_S` apart, the
    distance is interpolated linearly in time. Nothing is extrapolated.
    """
    borrowed = _known(dataset)
    if borrowed is None:
        borrowed = dataset.derived[_DERIVED] = _borrow(dataset)
    return borrowed


def share_borrowed(dataset: Dataset, other: Dataset) -> None:
    """Copy the borrowed distances of a dataset, if any, to another one with the same truth."""
    borrowed = _known(dataset)
    if borrowed is not None:
        other.derived[_DERIVED] = borrowed


def _known(dataset: Dataset) -> Borrowed | None:
    borrowed: Borrowed | None = dataset.derived.get(_DERIVED)
    return borrowed


def _borrow(dataset: Dataset) -> Borrowed:
    truth, frames = dataset.truth, dataset.frame_columns
    _, encounters = encounters_of(dataset)
    is_pedestrian, has_own = ~truth.ignore, np.isfinite(truth.distance_m)
    reports = reported_distances(dataset)
    has_report = np.isfinite(reports) & (is_pedestrian & ~has_own)
    n_reports = has_report.sum(axis=0)
    known = truth.distance_m.copy()
    rows = np.flatnonzero(n_reports)
    known[rows] = np.nanmedian(reports[:, rows], axis=0) if len(rows) else np.nan
    time_s = frames.frame / frames.fps[frames.recording]
    distance_m = _between(known, encounters, time_s)
    distance_m.flags.writeable = False
    several = np.flatnonzero(n_reports > 1)
    of_several = reports[:, several]
    with np.errstate(invalid="ignore"):
        apart = np.nanmax(of_several, axis=0) - np.nanmin(of_several, axis=0) if len(several) else 0
        spread = np.median(apart / np.nanmean(of_several, axis=0)) if len(several) else np.nan
    is_known = np.isfinite(distance_m)
    n_own = int(np.count_nonzero(has_own & is_pedestrian))
    n_known = int(np.count_nonzero(is_known & is_pedestrian))
    return Borrowed(
        distance_m=distance_m,
        n_own=n_own,
        n_reported=len(rows),
        n_between=n_known - n_own - len(rows),
        n_unknown=int(np.count_nonzero(is_pedestrian)) - n_known,
        lent=dict(zip(dataset.systems, has_report.sum(axis=1).tolist(), strict=True)),
        n_compared=len(several),
        spread=float(spread),
    )


def reported_distances(dataset: Dataset) -> np.ndarray:
    """Return the distance reported by each system's match of a truth box, m, NaN if none.

    Returns
    -------
    float64, shape (n_systems, n_truth).
    """
    truth = dataset.truth
    reports = np.full((len(dataset.systems), len(truth)), np.nan)
    for row, name in enumerate(dataset.systems):  # a loop over systems: a handful
        detections = dataset.system(name)
        if not (detections.distance_m > 0).any():
            continue
        matches = match_boxes(truth, detections, dataset.frame_columns, LENDING)
        matched = np.flatnonzero(matches.is_matched)
        metres = detections.distance_m[matches.truth_det[matched]]
        reports[row, matched] = np.where(metres > 0, metres, np.nan)
    return reports


def _between(known: np.ndarray, encounters: Encounters, time_s: np.ndarray) -> np.ndarray:
    """Return the known distances of truth rows, interpolated within each encounter."""
    distance_m = known.copy()
    rows = encounters.order
    n = len(rows)
    values, place = known[rows], np.arange(n)
    is_known = np.isfinite(values)
    before = np.maximum.accumulate(np.where(is_known, place, -1))
    after = np.minimum.accumulate(np.where(is_known, place, n)[::-1])[::-1]
    open_places = np.flatnonzero(~is_known & (before >= 0) & (after < n))
    first, last = before[open_places], after[open_places]
    encounter = encounters.encounter_of[rows]
    times = time_s[encounters.frame_index]
    gap_s = times[last] - times[first]
    fits = (encounter[first] == encounter[last]) & (gap_s <= LONGEST_GAP_S * (1 + 1e-9))
    open_places, first, last, gap_s = open_places[fits], first[fits], last[fits], gap_s[fits]
    # a track twice in a frame has no time between its two boxes
    share = np.divide(
        times[open_places] - times[first], gap_s, out=np.zeros(len(gap_s)), where=gap_s > 0
    )
    distance_m[rows[open_places]] = values[first] + share * (values[last] - values[first])
    return distance_m
