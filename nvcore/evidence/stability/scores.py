"""A criterion's measure of each system at another setting, repeating only what that changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, Final, Literal

import numpy as np

from nvcore.comparison.compare import TRUTH_STEPS, Result
from nvcore.comparison.measures.table import measure_of
from nvcore.comparison.scoring import STEPS, Inputs, Made, Memo, SystemInputs, steps_of
from nvcore.dataset.schema import DetectionState
from nvcore.evidence.stability.axes import Axis
from nvcore.metrics.matching import Matches, match_system
from nvcore.settings.params import settings_for
from nvcore.settings.stages import MATCH

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
) -> dict[Letter, tuple[float, float]]:
    """Return the measure of some systems at alpha 0 and at alpha 1. Between them it is linear.

    Mean similarity (1 is best), number of encounters detected, or saliency in seconds (0 is best);
    as `nvcore.comparison.compare.compare` gives at that setting, up to rounding. NaN without frames
    and, for encounters, if none is near enough to count.

    Parameters
    ----------
    letters
        "x", "y" or both; the truth is weighed once for both.
    full
        From `match_fully`.
    """
    changes: dict[str, Any] = dict(key)
    dataset, params = result.dataset, replace(result.params, **changes)
    inputs = (dataset, params, result.tracks, result.encounters)
    truth = Made(steps_of("truth", TRUTH_STEPS), Inputs(*inputs), Memo(params, result.stages))
    scores: dict[Letter, tuple[float, float]] = {}
    for letter in letters:
        name, threshold = result.system(letter).name, getattr(params, f"threshold_{letter}")
        at, owner = SystemInputs(*inputs, name, threshold), (dataset.systems.index(name), threshold)
        known = dict(result.stages)
        if letter in full:
            matches = _above(full[letter], at.detections.score, threshold)
            known["matches", *owner, *params.values_for(MATCH)] = matches
        steps, memo = steps_of("system", STEPS), Memo(params, known)
        made = Made(steps, at, memo, owner=owner, before=truth.__getitem__)
        scores[letter] = _ends(criterion, made, at) if len(at.frames) else (np.nan, np.nan)
    return scores


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


def _ends(criterion: Criterion, made: Made, at: SystemInputs) -> tuple[float, float]:
    """Compute the measure at alpha 0 and at alpha 1 from the steps that it needs."""
    if criterion == "similarity":  # only false alarms at 0, only misses at 1
        distances, half_width = made["distances"], at.frames.half_width
        of_false, of_miss = distances.d_false / half_width, distances.d_miss / half_width
        return 1 - float(np.mean(of_false)), 1 - float(np.mean(of_miss))
    if criterion == "saliency":
        value: float = made["saliency_s"]
    else:
        outcomes = made["encounters"]
        has_near = (outcomes["n_relevant"] > 0).any()
        value = float(outcomes["is_detected"].sum()) if has_near else np.nan
    return value, value
