"""Steps that score a system against the truth, and their combined result."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison.scoring.result import SystemResult
from nvcore.comparison.scoring.step import Made, Memo, ScoringStep, SystemInputs, steps_of
from nvcore.dataset import Dataset
from nvcore.metrics.encounters import judge_encounters
from nvcore.metrics.false_alarms import FalseAlarmSummary, find_episodes, summarise_false_alarms
from nvcore.metrics.matching import Matches, count_per_frame, match_system
from nvcore.metrics.proximity import Weights, in_use, weigh_proximity
from nvcore.metrics.saliency import find_events, mean_saliency, qualify
from nvcore.metrics.severity import weigh_failures
from nvcore.metrics.similarity import (
    Nearest,
    SetDistances,
    find_nearest,
    measure_matched,
    measure_sets,
    summarise_similarity,
    trace_similarity,
)
from nvcore.settings.params import Params
from nvcore.settings.stages import (
    DISTANCES,
    ENCOUNTERS,
    EVENTS,
    LOW,
    MATCH,
    NEAREST,
    PROXIMITY,
    SALIENCY,
    SALIENT,
    SEVERITY,
    SIMILARITY,
)


def nearest_of(dataset: Dataset, name: str, matches: Matches, params: Params) -> Nearest:
    """Compute distances between the truth and a system's counted detections, by `pairing`."""
    boxes, frames = (dataset.truth, dataset.system(name)), dataset.frame_columns
    if params.pairing == "matched":
        return measure_matched(*boxes, matches.truth_det, frames, distance=params.distance)
    return find_nearest(*boxes, matches.is_counted, frames, distance=params.distance)


def _measure_sets(
    at: SystemInputs, k_miss: np.ndarray, weights: Weights, is_counted: np.ndarray, nearest: Nearest
) -> SetDistances:
    return measure_sets(
        at.truth,
        k_miss,
        at.detections,
        weights.k,
        is_counted,
        nearest,
        at.frames,
        edge_weight=in_use(at.params, "edge_weight", at.frames),
        track=at.tracks.track,
    )


def _find_events(
    at: SystemInputs,
    k_truth: Weights,
    k_miss: np.ndarray,
    nearest: Nearest,
    distances: SetDistances,
    salient_row: np.ndarray,
) -> pd.DataFrame:
    return find_events(
        at.truth,
        k_truth.k,
        nearest.truth,
        distances.d_miss,
        salient_row,
        at.tracks.track,
        at.encounters,
        at.frames,
        in_use(at.params, "edge_weight", at.frames),
        at.params,
        k_miss=k_miss,
    )


def _judge_encounters(at: SystemInputs, k_truth: Weights, matches: Matches) -> pd.DataFrame:
    return judge_encounters(at.encounters, k_truth.k, matches.is_matched, at.frames, at.params)


def _weigh_failures(
    at: SystemInputs, k_truth: Weights, cost: np.ndarray, matches: Matches
) -> pd.DataFrame:
    return weigh_failures(at.truth, at.encounters, k_truth.k, cost, matches.is_matched, at.frames)


def _summarise_alarms(
    at: SystemInputs, false_alarms: np.ndarray, episodes: pd.DataFrame
) -> FalseAlarmSummary:
    return summarise_false_alarms(
        int(false_alarms.sum()), episodes, n_frames=len(at.frames), duration_s=at.frames.duration_s
    )


STEPS: Final[tuple[ScoringStep, ...]] = (
    ScoringStep(
        "matches", lambda at: match_system(at.dataset, at.name, at.threshold, at.params), (MATCH,)
    ),
    ScoringStep("is_counted", lambda _, matches: matches.is_counted, (MATCH,), ("matches",)),
    ScoringStep(
        "n_det",
        lambda at, is_counted: count_per_frame(at.detections, is_counted),
        (MATCH,),
        ("is_counted",),
    ),
    ScoringStep(
        "matched",
        lambda at, matches: count_per_frame(at.truth, matches.is_matched),
        (MATCH,),
        ("matches",),
    ),
    ScoringStep(
        "false_alarms", lambda _, n_det, matched: n_det - matched, (MATCH,), ("n_det", "matched")
    ),
    ScoringStep(
        "episodes",
        lambda at, matches: find_episodes(at.detections, matches.is_false_alarm, at.frames),
        (MATCH,),
        ("matches",),
    ),
    ScoringStep("false_alarm_summary", _summarise_alarms, (MATCH,), ("false_alarms", "episodes")),
    ScoringStep(
        "nearest",
        lambda at, matches: nearest_of(at.dataset, at.name, matches, at.params),
        (NEAREST,),
        ("matches",),
    ),
    ScoringStep(
        "weights",
        lambda at, is_counted: weigh_proximity(at.detections, is_counted, at.frames, at.params),
        (MATCH, PROXIMITY),
        ("is_counted",),
    ),
    ScoringStep(
        "distances", _measure_sets, (DISTANCES,), ("k_miss", "weights", "is_counted", "nearest")
    ),
    ScoringStep(
        "similarity",
        lambda at, distances: trace_similarity(distances, at.frames, alpha=at.params.alpha),
        (SIMILARITY,),
        ("distances",),
    ),
    ScoringStep(
        "summary",
        lambda at, similarity: summarise_similarity(similarity, low=at.params.low),
        (LOW,),
        ("similarity",),
    ),
    ScoringStep(
        "salient_row",
        lambda at, distances: qualify(distances, at.frames, tolerance=at.params.tolerance),
        (SALIENT,),
        ("distances",),
    ),
    ScoringStep(
        "events",
        _find_events,
        (EVENTS,),
        ("k_truth", "k_miss", "nearest", "distances", "salient_row"),
    ),
    ScoringStep(
        "saliency_s",
        lambda at, events: mean_saliency(events, at.frames, aggregate=at.params.saliency_aggregate),
        (SALIENCY,),
        ("events",),
    ),
    ScoringStep("encounters", _judge_encounters, (ENCOUNTERS,), ("k_truth", "matches")),
    ScoringStep("failures", _weigh_failures, (SEVERITY,), ("k_truth", "cost", "matches")),
)
"""The core's own steps. Those of subjects follow (`steps_of`)."""


def score_system(
    at: SystemInputs, truth: Made, memo: Memo, owner: tuple[int, float | None]
) -> SystemResult:
    """Compute all results of one system, without reference to the other.

    Parameters
    ----------
    truth
        Results of the steps about the truth.
    owner
        Number of the system, which survives renaming, and its threshold.
    """
    made = dict(Made(steps_of("system", STEPS), at, memo, owner=owner, before=truth.__getitem__))
    return SystemResult(
        name=at.name,
        threshold=at.threshold,
        made=made,
        _dataset=at.dataset,
        _params=at.params,
        **{step.name: made[step.name] for step in STEPS if step.name != "is_counted"},
    )
