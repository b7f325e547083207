"""A criterion's figure of each system at another setting, by repeating only what it changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final, Literal

import numpy as np

from nvcore.comparison import Result, SystemResult
from nvcore.metrics.encounters import judge_encounters
from nvcore.metrics.matching import Matches, match_system
from nvcore.metrics.proximity import weigh_proximity
from nvcore.metrics.saliency import aggregate_saliency, find_events, qualify
from nvcore.metrics.similarity import SetDistances, find_nearest, measure_sets
from nvcore.params import Params, settings_for
from nvcore.params.metadata import ENCOUNTERS, MATCH, PROXIMITY, SALIENCY, SIMILARITY, Stage
from nvcore.schema import DetectionState
from nvcore.stability.axes import Axis

Criterion = Literal["similarity", "encounters", "saliency"]
Letter = Literal["x", "y"]
LETTERS: Final[tuple[Letter, Letter]] = ("x", "y")

STAGE_OF: Final[dict[Criterion, Stage]] = {
    "similarity": SIMILARITY,
    "encounters": ENCOUNTERS,
    "saliency": SALIENCY,
}
"""The stage of the comparison that gives each criterion."""

Key = tuple[tuple[str, float | str], ...]
"""Settings by name that differ from the analysed ones; alpha is never among them."""


@dataclass(frozen=True)
class Score:
    """A system's figure as a function of alpha: a straight line between two ends.

    Attributes
    ----------
    at_0, at_1
        The figure at alpha 0 and 1; equal where alpha does not enter. NaN: undefined.
    """

    at_0: float
    at_1: float


def enters(name: str, criterion: Criterion, letter: Letter, result: Result) -> bool:
    """Whether a setting can change the criterion's measure of a system."""
    if name.startswith("threshold_"):
        return name == f"threshold_{letter}"
    if name in settings_for(MATCH) and criterion != "encounters":
        # the sets depend on the matching only by who is absorbed by ignore regions
        return bool(result.dataset.truth.ignore.any())
    return name in settings_for(STAGE_OF[criterion])


def keys_of(
    result: Result, criterion: Criterion, letter: Letter, axes: Sequence[Axis]
) -> np.ndarray:
    """What a system's figure depends on in each cell; object, one `Key` each.

    Shape: that of the map, with 1 for axes that do not change it, and for alpha.
    """
    moved = [axis.name != "alpha" and enters(axis.name, criterion, letter, result) for axis in axes]
    shape = tuple(len(axis) if is_moved else 1 for axis, is_moved in zip(axes, moved, strict=True))
    keys = np.empty(shape, dtype=object)
    for at in product(*map(range, shape)):  # a loop over settings, not over frames
        at_each = zip(axes, at, moved, strict=True)
        named = [(axis.name, axis.setting(i)) for axis, i, is_moved in at_each if is_moved]
        if ("match", "lateral") in named:  # by lateral position no overlap is asked for
            named = [one for one in named if one[0] != "iou"]
        keys[at] = tuple(named)
    return keys


def match_fully(result: Result, names: Sequence[str]) -> dict[Letter, Matches]:
    """Matching of all detections of the systems whose thresholds move.

    Detections take pedestrians in descending score, so a threshold changes nothing for those
    above it: one matching serves all thresholds. Only a system that has detections without a
    score, which come last and may take what a threshold sets free, is matched anew at each.
    """
    full: dict[Letter, Matches] = {}
    for letter in LETTERS:
        system = _system(result, letter)
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
    """The criterion's figure of some systems at one setting.

    Mean similarity (1 is best), number of encounters detected, or saliency in seconds (0 is best);
    the same as `nvcore.comparison.compare` gives at that setting, to rounding. NaN without frames,
    and for encounters where none is near enough to count.

    Parameters
    ----------
    letters
        "x", "y" or both: what the truth weighs is found once for them.
    full
        From `match_fully`.
    """
    changes: dict[str, Any] = dict(key)
    params = replace(result.params, **changes)
    dataset = result.dataset
    frames = dataset.frame_columns
    is_weighed_anew = _is_changed(PROXIMITY, changes)
    k_truth = result.k_truth.k
    if is_weighed_anew:
        k_truth = weigh_proximity(dataset.truth, ~dataset.truth.ignore, frames, params).k
    scores: dict[Letter, Score] = {}
    for letter in letters:
        matches = _matches(result, letter, params, changes, full)
        if not len(frames):
            value = np.nan
        elif criterion == "encounters":
            value = _count_detected(result, k_truth, matches, params)
        else:
            distances = _distances(result, letter, params, changes, matches, k_truth, criterion)
            if criterion == "similarity":
                scores[letter] = _similarity(distances, result)
                continue
            value = _saliency(distances, result, params)
        scores[letter] = Score(value, value)
    return scores


def _system(result: Result, letter: Letter) -> SystemResult:
    return result.x if letter == "x" else result.y


def _is_changed(stage: Stage, changes: Mapping[str, Any]) -> bool:
    """Whether a change moves the result of a stage; thresholds aside."""
    return not changes.keys().isdisjoint(settings_for(stage))


def _matches(
    result: Result,
    letter: Letter,
    params: Params,
    changes: Mapping[str, Any],
    full: Mapping[Letter, Matches],
) -> Matches:
    system, name = _system(result, letter), f"threshold_{letter}"
    if name in changes and letter in full:
        score = result.dataset.system(system.name).score
        return _above(full[letter], score, changes[name])
    if name in changes or _is_changed(MATCH, changes):
        threshold = changes.get(name, system.threshold)
        return match_system(result.dataset, system.name, threshold, params)
    return system.matches


def _above(full: Matches, score: np.ndarray, threshold: float) -> Matches:
    """What a threshold leaves of the matching of all detections."""
    is_below = score < threshold
    kept = full.truth_det >= 0
    kept &= ~is_below[full.truth_det]
    return Matches(
        state=np.where(is_below, np.int8(DetectionState.BELOW), full.state),
        det_truth=np.where(is_below, -1, full.det_truth),
        truth_det=np.where(kept, full.truth_det, -1),
    )


def _distances(
    result: Result,
    letter: Letter,
    params: Params,
    changes: Mapping[str, Any],
    matches: Matches,
    k_truth: np.ndarray,
    criterion: Criterion,
) -> SetDistances:
    if not changes:
        return _system(result, letter).distances
    system, dataset = _system(result, letter), result.dataset
    truth, detections = dataset.truth, dataset.system(system.name)
    frames, is_counted = dataset.frame_columns, matches.is_counted
    nearest, k = system.nearest, system.weights.k
    if matches is not system.matches:
        nearest = find_nearest(truth, detections, is_counted, frames, distance=params.distance)
    # saliency looks at misses only: the weights of detections do not enter
    if criterion == "similarity" and _is_changed(PROXIMITY, changes):
        k = weigh_proximity(detections, is_counted, frames, params).k
    return measure_sets(
        truth,
        k_truth,
        detections,
        k,
        is_counted,
        nearest,
        frames,
        track=result.tracks.track,
        edge_weight=params.edge_weight,
    )


def _similarity(distances: SetDistances, result: Result) -> Score:
    """Mean similarity is a straight line in alpha: misses only at 1, false alarms only at 0."""
    frames = result.dataset.frame_columns
    half_width = 0.5 * frames.width
    per_frame = half_width[0] if len(half_width) == 1 else half_width[frames.recording]
    return Score(
        at_0=1 - float(np.mean(distances.d_false / per_frame)),
        at_1=1 - float(np.mean(distances.d_miss / per_frame)),
    )


def _count_detected(result: Result, k_truth: np.ndarray, matches: Matches, params: Params) -> float:
    judged = judge_encounters(
        result.encounters, k_truth, matches.is_matched, result.dataset.frame_columns, params
    )
    if not (judged["n_relevant"] > 0).any():
        return np.nan
    return float(judged["is_detected"].sum())


def _saliency(distances: SetDistances, result: Result, params: Params) -> float:
    frames, encounters = result.dataset.frame_columns, result.encounters
    salient_row = qualify(distances, frames, tolerance=params.tolerance)
    rows = encounters.first_row, encounters.last_row
    events = find_events(
        salient_row, encounters.encounter_of, result.tracks.track, rows, frames, params
    )
    saliency_s = events["saliency_s"].to_numpy()
    return aggregate_saliency(saliency_s, aggregate=params.saliency_aggregate)
