"""A criterion's measure of each system at another setting, repeating only what that changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final, Literal

import numpy as np

from nvcore.comparison import Result
from nvcore.measures.table import measure_of
from nvcore.metrics.encounters import judge_encounters
from nvcore.metrics.matching import Matches, match_system
from nvcore.metrics.proximity import in_use, weigh_proximity
from nvcore.metrics.proximity.borrowing import weighing_truth
from nvcore.metrics.saliency import find_events, mean_saliency, qualify
from nvcore.metrics.similarity import Nearest, SetDistances, measure_sets
from nvcore.params import Params, settings_for
from nvcore.schema import DetectionState
from nvcore.scoring import nearest_of, weigh_misses
from nvcore.stability.axes import Axis
from nvcore.stages import MATCH, PROXIMITY, Stage

Criterion = Literal["similarity", "encounters", "saliency"]
Letter = Literal["x", "y"]
LETTERS: Final[tuple[Letter, Letter]] = ("x", "y")

MEASURE_OF: Final[dict[Criterion, str]] = {
    "similarity": "mean_similarity",
    "encounters": "encounters_detected",
    "saliency": "saliency",
}
"""Key of the measure in which each criterion compares X and Y."""

Key = tuple[tuple[str, float | str], ...]
"""Settings by name that differ from the analysed ones; alpha is never among them."""


@dataclass(frozen=True)
class Score:
    """A system's measure as a function of alpha: a straight line between two ends.

    Attributes
    ----------
    at_0, at_1
        The measure at alpha 0 and 1; equal where alpha does not matter. NaN: undefined.
    """

    at_0: float
    at_1: float


def enters(name: str, criterion: Criterion, letter: Letter, result: Result) -> bool:
    """Whether a setting can change the criterion's measure of a system."""
    if name.startswith("threshold_"):
        return name == f"threshold_{letter}"
    is_by_sets = criterion != "encounters" and result.params.pairing == "nearest"
    if name in settings_for(MATCH) and is_by_sets:
        # the sets depend on matching only through what ignore regions absorb
        return bool(result.dataset.truth.ignore.any())
    return measure_of(MEASURE_OF[criterion]).depends_on(name)


def keys_of(
    result: Result, criterion: Criterion, letter: Letter, axes: Sequence[Axis]
) -> np.ndarray:
    """Return the settings that a system's measure depends on in each cell, object, one `Key` each.

    The map's shape, with 1 for axes that do not change it and for alpha.
    """
    moved = [axis.name != "alpha" and enters(axis.name, criterion, letter, result) for axis in axes]
    shape = tuple(len(axis) if is_moved else 1 for axis, is_moved in zip(axes, moved, strict=True))
    keys = np.empty(shape, dtype=object)
    for indices in product(*map(range, shape)):  # a loop over settings, not over frames
        settings = [
            (axis.name, axis.setting_at(axis.values[i]))
            for axis, i, is_moved in zip(axes, indices, moved, strict=True)
            if is_moved
        ]
        if ("match", "lateral") in settings:  # matching by lateral position ignores overlap
            settings = [setting for setting in settings if setting[0] != "iou"]
        keys[indices] = tuple(settings)
    return keys


def match_fully(result: Result, names: Sequence[str]) -> dict[Letter, Matches]:
    """Matching of all detections of the systems whose thresholds change.

    Detections take pedestrians in descending score, so a threshold changes nothing for those
    above it: one matching serves all thresholds. A system that has detections without a score,
    which come last and may take what a threshold sets free, is matched again at each threshold.
    """
    full: dict[Letter, Matches] = {}
    for letter in LETTERS:
        system = result.system(letter)
        score = result.dataset.system(system.name).score
        if f"threshold_{letter}" not in names or np.isnan(score).any():
            continue
        is_full = system.threshold is None
        full[letter] = (
            system.matches
            if is_full
            else match_system(result.dataset, system.name, None, result.params)
        )
    return full


def score_setting(
    result: Result,
    criterion: Criterion,
    key: Key,
    letters: Sequence[Letter],
    full: Mapping[Letter, Matches],
) -> dict[Letter, Score]:
    """The criterion's measure of some systems at one setting.

    Mean similarity (1 is best), number of encounters detected, or saliency in seconds (0 is best);
    as `nvcore.comparison.compare` gives at that setting, up to rounding. NaN without frames and,
    for encounters, if none is near enough to count.

    Parameters
    ----------
    letters
        "x", "y" or both; the truth is weighed once for both.
    full
        From `match_fully`.
    """
    changes: dict[str, Any] = dict(key)
    params = replace(result.params, **changes)
    dataset = result.dataset
    frames = dataset.frame_columns
    has_new_weights = _is_changed(PROXIMITY, changes)
    k_truth, k_miss = result.k_truth.k, result.k_miss
    if has_new_weights:
        truth = weighing_truth(dataset, params)
        k_truth = weigh_proximity(truth, ~truth.ignore, frames, params).k
        k_miss = weigh_misses(k_truth, dataset, params)
    scores: dict[Letter, Score] = {}
    for letter in letters:
        matches = _matches(result, letter, params, changes, full)
        if not len(frames):
            value = np.nan
        elif criterion == "encounters":
            value = _count_detected(result, k_truth, matches, params)
        else:
            nearest, distances = _distances(
                result, letter, params, changes, matches, k_miss, criterion
            )
            if criterion == "similarity":
                scores[letter] = _similarity(distances, result)
                continue
            value = _saliency(k_truth, k_miss, nearest, distances, result, params)
        scores[letter] = Score(value, value)
    return scores


def _is_changed(stage: Stage, changes: Mapping[str, Any]) -> bool:
    """Whether the changes affect a stage's result, thresholds aside."""
    return not changes.keys().isdisjoint(settings_for(stage))


def _matches(
    result: Result,
    letter: Letter,
    params: Params,
    changes: Mapping[str, Any],
    full: Mapping[Letter, Matches],
) -> Matches:
    system, name = result.system(letter), f"threshold_{letter}"
    if name in changes and letter in full:
        score = result.dataset.system(system.name).score
        return _above(full[letter], score, changes[name])
    if name in changes or _is_changed(MATCH, changes):
        threshold = changes.get(name, system.threshold)
        return match_system(result.dataset, system.name, threshold, params)
    return system.matches


def _above(full: Matches, score: np.ndarray, threshold: float) -> Matches:
    """Apply a score threshold to a matching of all detections."""
    is_below = score < threshold
    is_kept = full.truth_det >= 0
    is_kept &= ~is_below[full.truth_det]
    return Matches(
        state=np.where(is_below, np.int8(DetectionState.BELOW), full.state),
        det_truth=np.where(is_below, -1, full.det_truth),
        truth_det=np.where(is_kept, full.truth_det, -1),
    )


def _distances(
    result: Result,
    letter: Letter,
    params: Params,
    changes: Mapping[str, Any],
    matches: Matches,
    k_miss: np.ndarray,
    criterion: Criterion,
) -> tuple[Nearest, SetDistances]:
    system, dataset = result.system(letter), result.dataset
    if not changes:
        return system.nearest, system.distances
    truth, detections = dataset.truth, dataset.system(system.name)
    frames, is_counted = dataset.frame_columns, matches.is_counted
    nearest, k = system.nearest, system.weights.k
    if matches is not system.matches or "pairing" in changes:
        nearest = nearest_of(dataset, system.name, matches, params)
    # saliency considers misses only: the weights of detections do not matter
    if criterion == "similarity" and _is_changed(PROXIMITY, changes):
        k = weigh_proximity(detections, is_counted, frames, params).k
    edge_weight = in_use(params, "edge_weight", frames)
    return nearest, measure_sets(
        *(truth, k_miss, detections, k, is_counted, nearest, frames),
        edge_weight=edge_weight,
        track=result.tracks.track,
    )


def _similarity(distances: SetDistances, result: Result) -> Score:
    """Mean similarity, a straight line in alpha: only misses at 1, only false alarms at 0."""
    half_width = result.dataset.frame_columns.half_width
    return Score(
        at_0=1 - float(np.mean(distances.d_false / half_width)),
        at_1=1 - float(np.mean(distances.d_miss / half_width)),
    )


def _count_detected(result: Result, k_truth: np.ndarray, matches: Matches, params: Params) -> float:
    outcomes = judge_encounters(
        result.encounters, k_truth, matches.is_matched, result.dataset.frame_columns, params
    )
    if not (outcomes["n_relevant"] > 0).any():
        return np.nan
    return float(outcomes["is_detected"].sum())


def _saliency(
    k_truth: np.ndarray,
    k_miss: np.ndarray,
    nearest: Nearest,
    distances: SetDistances,
    result: Result,
    params: Params,
) -> float:
    frames = result.dataset.frame_columns
    salient_row = qualify(distances, frames, tolerance=params.tolerance)
    events = find_events(
        *(result.dataset.truth, k_truth, nearest.truth, distances.d_miss, salient_row),
        *(result.tracks.track, result.encounters, frames),
        *(in_use(params, "edge_weight", frames), params),
        k_miss=k_miss,
    )
    return mean_saliency(events, frames, aggregate=params.saliency_aggregate)
