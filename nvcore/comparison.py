"""The one call that command line and web share: ``analyse(dataset, params) -> Result``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset, compared_names
from nvcore.errors import InputError
from nvcore.metrics.encounters import (
    Encounters,
    find_encounters,
    judge_encounters,
    mostly_one_frame,
)
from nvcore.metrics.false_alarms import FalseAlarmSummary, find_episodes, summarise_false_alarms
from nvcore.metrics.fusion import fuse
from nvcore.metrics.linking import TruthTracks, track_truth
from nvcore.metrics.matching import Matches, count_per_frame, match_boxes
from nvcore.metrics.proximity import Weights, weigh_proximity
from nvcore.metrics.saliency import aggregate_saliency, find_events, qualify
from nvcore.metrics.similarity import (
    Nearest,
    SetDistances,
    SimilaritySummary,
    find_low_intervals,
    find_nearest,
    measure_sets,
    smooth,
    summarise_similarity,
    trace_similarity,
)
from nvcore.metrics.venn import (
    BoxVenn,
    Exclusivity,
    Venn,
    categorise,
    count_boxes,
    count_categories,
    measure_exclusivity,
)
from nvcore.params import Params
from nvcore.schema import Category, DetectionState

T = TypeVar("T")


class Memo:
    """Results of the stages by what they depend on; a new parameter set repeats what changed."""

    def __init__(self, known: Mapping[tuple[Any, ...], Any]):
        self._known = known
        self.used: dict[tuple[Any, ...], Any] = {}

    def get(self, key: tuple[Any, ...], make: Callable[[], T]) -> T:
        """The stage's result, from before if nothing in `key` has changed."""
        value = self._known[key] if key in self._known else make()
        self.used[key] = value
        return value


@dataclass(frozen=True, eq=False)
class SystemResult:
    """Everything about one system.

    Attributes
    ----------
    name
        The system's name.
    threshold
        Score threshold that was applied; None: every detection counts.
    matches, weights, nearest, distances
        See `nvcore.metrics.matching`, `nvcore.metrics.proximity` and `nvcore.metrics.similarity`.
    similarity
        Similarity of every frame, 0..1, 1 is best; float64, shape (n_frames,).
    salient_row
        Truth row of the pedestrian that qualifies for saliency, -1 none; int64, (n_frames,).
    n_det, matched, false_alarms
        Per frame: counted detections, matched pedestrians, ``n_det - matched``; int64.
    events
        Saliency events (`nvcore.metrics.saliency.find_events`).
    encounters
        How it did in each encounter (`nvcore.metrics.encounters.judge_encounters`).
    episodes
        False-alert episodes (`nvcore.metrics.false_alarms.find_episodes`).
    summary
        Aggregates of similarity over all frames.
    false_alarm_summary
        Rates of false alarms over all recordings.
    saliency_s
        Saliency over all recordings: the largest of them, or their sum (`saliency_aggregate`).
    """

    name: str
    threshold: float | None
    matches: Matches
    weights: Weights
    nearest: Nearest
    distances: SetDistances
    similarity: np.ndarray
    salient_row: np.ndarray
    n_det: np.ndarray
    matched: np.ndarray
    false_alarms: np.ndarray
    events: pd.DataFrame
    encounters: pd.DataFrame
    episodes: pd.DataFrame
    summary: SimilaritySummary
    false_alarm_summary: FalseAlarmSummary
    saliency_s: float
    _dataset: Dataset = field(repr=False)
    _params: Params = field(repr=False)

    @cached_property
    def similarity_window(self) -> np.ndarray:
        """Moving mean of similarity, 1 is best; float64, shape (n_frames,)."""
        return smooth(self.similarity, self._dataset.frame_columns, window=self._params.window)

    @cached_property
    def intervals(self) -> pd.DataFrame:
        """Low-similarity intervals (`nvcore.metrics.similarity.find_low_intervals`)."""
        return find_low_intervals(
            self.similarity, self._dataset.frame_columns, low=self._params.low
        )


@dataclass(frozen=True, eq=False)
class Result:
    """Comparison of two systems. Tables for people are made by `nvcore.tables.result`.

    Attributes
    ----------
    dataset, params
        What was analysed, and how.
    x, y
        The two systems.
    tracks
        Tracks of the truth, and where they were made by linking.
    encounters
        The encounters of the ground truth.
    k_truth
        Proximity weight of every truth box.
    category
        Venn category of every encounter; object, shape (n_encounters,).
    venn, exclusivity, boxes
        Counts of encounters, how exclusive the misses are, counts of boxes.
    duration_s
        Recording time of all recordings.
    stages
        What `analyse` can take over when only some settings change.
    """

    dataset: Dataset
    params: Params
    x: SystemResult
    y: SystemResult
    tracks: TruthTracks
    encounters: Encounters
    k_truth: Weights
    n_truth: np.ndarray
    category: np.ndarray
    venn: Venn
    exclusivity: Exclusivity
    boxes: BoxVenn
    duration_s: float
    stages: Mapping[tuple[Any, ...], Any] = field(repr=False)

    @property
    def sides(self) -> tuple[tuple[str, SystemResult], tuple[str, SystemResult]]:
        """The two systems with the letter that their columns end in."""
        return ("x", self.x), ("y", self.y)

    @property
    def is_short(self) -> bool:
        """Whether most encounters that count are a single frame long."""
        is_near = self.category != Category.DISTANT.value
        return mostly_one_frame(self.encounters.n_frames[is_near])

    def saliency_of_recordings(self, system: SystemResult) -> np.ndarray:
        """Saliency of every recording by itself, s, 0 is best; float64, shape (n_recordings,)."""
        saliency = np.zeros(len(self.dataset.recordings))
        add = np.maximum if self.params.saliency_aggregate == "max" else np.add
        events = system.events
        add.at(
            saliency,
            events["recording"].to_numpy(dtype=np.int64),
            events["saliency_s"].to_numpy(dtype=float),
        )
        return saliency

    @property
    def lead_time_s(self) -> np.ndarray:
        """Lead of X over Y per encounter, lag(Y) - lag(X), seconds; NaN unless both match."""
        lead: np.ndarray = (self.y.encounters["lag_s"] - self.x.encounters["lag_s"]).to_numpy()
        return lead

    @cached_property
    def fusion(self) -> Result:
        """The fused systems: ``X or Y`` as `x`, ``X and Y`` as `y`."""
        fused = fuse(
            self.dataset,
            self.x.name,
            self.y.name,
            self.x.matches.state != DetectionState.BELOW,
            self.y.matches.state != DetectionState.BELOW,
            iou=self.params.iou,
        )
        return compare(fused, replace(self.params, threshold_x=None, threshold_y=None))


def compare(
    dataset: Dataset,
    params: Params | None = None,
    *,
    x: str | None = None,
    y: str | None = None,
    previous: Result | None = None,
) -> Result:
    """Compare two systems of a dataset.

    Parameters
    ----------
    dataset
        Recordings, ground truth, systems.
    params
        Settings; None: the defaults.
    x, y
        Names of the systems; None: the dataset's first that is not the other one.
    previous
        A result of the same dataset: stages whose settings are the same are taken from it, so
        that moving alpha or the sigmoid costs little. The figures do not depend on it.

    Raises
    ------
    InputError
        If there are fewer than two systems, or none of a given name.
    ParameterError
        If proximity by horizon lacks the horizon.

    Examples
    --------
    >>> result = analyse(dataset, Params(alpha=0.8))  # doctest: +SKIP
    >>> result.venn.dominant  # doctest: +SKIP
    """
    params = params or Params()
    names = _pick(dataset, x, y)
    known = previous.stages if previous and previous.dataset is dataset else {}
    stages = Memo(known)
    truth, frames = dataset.truth, dataset.frame_columns
    occlusion = dataset.boxes["occlusion"].to_numpy()[: len(truth)]
    tracks = stages.get(("tracks",), lambda: track_truth(truth, frames))
    encounters = stages.get(
        ("encounters",), lambda: find_encounters(truth, tracks.track, occlusion, frames)
    )
    n_truth = stages.get(("n_truth",), lambda: count_per_frame(truth, ~truth.ignore))
    k_truth = stages.get(
        ("k_truth", *_proximity_key(params)),
        lambda: weigh_proximity(truth, ~truth.ignore, frames, params),
    )
    shared = (dataset, params, tracks, encounters, k_truth)
    # numpy and the kernels release the lock: the two systems run side by side
    pairs = list(zip(names, (params.threshold_x, params.threshold_y), strict=True))
    with ThreadPoolExecutor(2) as pool:
        jobs = [
            pool.submit(score_system, name, threshold, *shared, stages) for name, threshold in pairs
        ]
        result_x, result_y = (job.result() for job in jobs)
    judged_keys = [_judged_key(*pair, params) for pair in pairs]
    category = stages.get(
        ("category", *judged_keys),
        lambda: categorise(
            result_x.encounters["n_relevant"].to_numpy() == 0,
            result_x.encounters["is_detected"].to_numpy(),
            result_y.encounters["is_detected"].to_numpy(),
        ),
    )
    venn = stages.get(("venn", *judged_keys), lambda: count_categories(category))
    boxes = stages.get(
        ("boxes", *(_match_key(*pair, params) for pair in pairs)),
        lambda: count_boxes(
            ~truth.ignore, result_x.matches.is_matched, result_y.matches.is_matched
        ),
    )
    return Result(
        dataset=dataset,
        params=params,
        x=result_x,
        y=result_y,
        tracks=tracks,
        encounters=encounters,
        k_truth=k_truth,
        n_truth=n_truth,
        category=category,
        venn=venn,
        exclusivity=measure_exclusivity(venn),
        boxes=boxes,
        duration_s=frames.duration_s,
        stages=stages.used,
    )


def _pick(dataset: Dataset, x: str | None, y: str | None) -> tuple[str, str]:
    x, y = compared_names(dataset.systems, x, y)
    if x is None or y is None:
        raise InputError(
            f"a comparison needs two systems; there is {len(dataset.systems)} "
            f"({', '.join(dataset.systems) or 'none'}): give a second one"
        )
    for name in (x, y):
        dataset.system(name)
    return x, y


def _proximity_key(params: Params) -> tuple[Any, ...]:
    return (params.proximity, params.midpoint, params.spread, params.midpoint_m,
            params.spread_m, params.horizon)  # fmt: skip


def _match_key(name: str, threshold: float | None, params: Params) -> tuple[Any, ...]:
    return (name, threshold, params.match, params.iou, params.lateral_tolerance)


def _judged_key(name: str, threshold: float | None, params: Params) -> tuple[Any, ...]:
    return (*_match_key(name, threshold, params), *_proximity_key(params), params.coverage,
            params.lag_s, params.gap_s)  # fmt: skip


def score_system(
    name: str,
    threshold: float | None,
    dataset: Dataset,
    params: Params,
    tracks: TruthTracks,
    encounters: Encounters,
    k_truth: Weights,
    stages: Memo,
) -> SystemResult:
    """Everything about one system, without reference to the other."""
    truth, frames, detections = dataset.truth, dataset.frame_columns, dataset.system(name)
    match_key = _match_key(name, threshold, params)
    proximity_key = _proximity_key(params)
    matches = stages.get(
        ("matches", *match_key),
        lambda: match_boxes(
            truth, detections, frames, threshold=threshold, match=params.match, iou=params.iou,
            lateral_tolerance=params.lateral_tolerance,
        ),
    )  # fmt: skip
    is_counted = stages.get(("is_counted", *match_key), lambda: matches.is_counted)
    n_det = stages.get(("n_det", *match_key), lambda: count_per_frame(detections, is_counted))
    matched = stages.get(
        ("matched", *match_key), lambda: count_per_frame(truth, matches.is_matched)
    )
    episodes = stages.get(
        ("episodes", *match_key),
        lambda: find_episodes(detections, matches.is_false_alarm, frames),
    )
    nearest = stages.get(
        ("nearest", *match_key, params.distance),
        lambda: find_nearest(truth, detections, is_counted, frames, distance=params.distance),
    )
    weights = stages.get(
        ("weights", *match_key, *proximity_key),
        lambda: weigh_proximity(detections, is_counted, frames, params),
    )
    distances_key = (*match_key, params.distance, *proximity_key, params.edge_weight)
    distances = stages.get(
        ("distances", *distances_key),
        lambda: measure_sets(
            truth, k_truth.k, detections, weights.k, is_counted, nearest, frames,
            track=tracks.track, edge_weight=params.edge_weight,
        ),
    )  # fmt: skip
    similarity = trace_similarity(distances, frames, alpha=params.alpha)
    salient_key = (*distances_key, params.tolerance)
    salient_row = stages.get(
        ("salient_row", *salient_key),
        lambda: qualify(distances, frames, tolerance=params.tolerance),
    )
    events = stages.get(
        ("events", *salient_key, params.recency_midpoint, params.recency_spread,
         params.saliency_scope),
        lambda: find_events(
            salient_row, encounters.encounter_of, tracks.track,
            (encounters.first_row, encounters.last_row), frames, params,
        ),
    )  # fmt: skip
    judged = stages.get(
        ("judged", *_judged_key(name, threshold, params)),
        lambda: judge_encounters(encounters, k_truth.k, matches.is_matched, frames, params),
    )
    false_alarms = stages.get(("false_alarms", *match_key), lambda: n_det - matched)
    return SystemResult(
        name=name,
        threshold=threshold,
        matches=matches,
        weights=weights,
        nearest=nearest,
        distances=distances,
        similarity=similarity,
        salient_row=salient_row,
        n_det=n_det,
        matched=matched,
        false_alarms=false_alarms,
        events=events,
        encounters=judged,
        episodes=episodes,
        summary=summarise_similarity(similarity, low=params.low),
        false_alarm_summary=summarise_false_alarms(
            int(false_alarms.sum()), episodes, n_frames=len(frames), duration_s=frames.duration_s
        ),
        saliency_s=aggregate_saliency(
            events["saliency_s"].to_numpy(), aggregate=params.saliency_aggregate
        ),
        _dataset=dataset,
        _params=params,
    )
