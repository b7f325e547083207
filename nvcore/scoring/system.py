"""Scoring a system stage by stage; what no new setting changes is taken over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np
import pandas as pd

from nvcore.columns import BoxColumns
from nvcore.dataset import Dataset
from nvcore.metrics.encounters import Encounters, judge_encounters
from nvcore.metrics.false_alarms import find_episodes, summarise_false_alarms
from nvcore.metrics.linking import TruthTracks
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
from nvcore.metrics.time_left import Contact, Judgement, confirm
from nvcore.params import Params
from nvcore.params.metadata import (
    CONFIRMED,
    CONTACT,
    DISTANCES,
    ENCOUNTERS,
    EVENTS,
    MATCH,
    NEAREST,
    PROXIMITY,
    SALIENT,
    SEVERITY,
    TIME_LEFT,
    Stage,
)
from nvcore.scoring.memo import Memo
from nvcore.scoring.result import SystemResult

T = TypeVar("T")


def nearest_of(dataset: Dataset, name: str, matches: Matches, params: Params) -> Nearest:
    """Distances between the truth and a system's counted detections, as `pairing` says."""
    boxes, frames = (dataset.truth, dataset.system(name)), dataset.frame_columns
    if params.pairing == "matched":
        return measure_matched(*boxes, matches.truth_det, frames, distance=params.distance)
    return find_nearest(*boxes, matches.is_counted, frames, distance=params.distance)


def score_system(
    name: str,
    threshold: float | None,
    dataset: Dataset,
    params: Params,
    tracks: TruthTracks,
    encounters: Encounters,
    k_truth: Weights,
    k_miss: np.ndarray,
    cost: np.ndarray,
    contact: Contact,
    urgency: pd.DataFrame,
    memo: Memo,
) -> SystemResult:
    """Everything about one system, without reference to the other."""
    scoring = _Scoring(
        *(name, threshold, dataset, params, tracks, encounters, k_truth, k_miss, cost),
        *(contact, urgency, memo),
    )
    frames = dataset.frame_columns
    matches = scoring.matches()
    counts = scoring.counts(matches)
    nearest, weights, distances = scoring.sets(matches)
    similarity = trace_similarity(distances, frames, alpha=params.alpha)
    salient_row, events = scoring.salient(nearest, distances)
    outcomes, failures = scoring.outcomes(matches)
    confirmed, judgement = scoring.time_left(matches)
    return SystemResult(
        name=name,
        threshold=threshold,
        matches=matches,
        weights=weights,
        nearest=nearest,
        distances=distances,
        similarity=similarity,
        salient_row=salient_row,
        n_det=counts.n_det,
        matched=counts.matched,
        false_alarms=counts.false_alarms,
        events=events,
        encounters=outcomes,
        failures=failures,
        confirmed=confirmed,
        episodes=counts.episodes,
        summary=summarise_similarity(similarity, low=params.low),
        false_alarm_summary=summarise_false_alarms(
            int(counts.false_alarms.sum()),
            counts.episodes,
            n_frames=len(frames),
            duration_s=frames.duration_s,
        ),
        saliency_s=mean_saliency(events, frames, aggregate=params.saliency_aggregate),
        _judgement=judgement,
        _dataset=dataset,
        _params=params,
    )


class _Counts(NamedTuple):
    """Detections, matches and false alarms per frame, int64, (n_frames,); false-alert episodes."""

    n_det: np.ndarray
    matched: np.ndarray
    false_alarms: np.ndarray
    episodes: pd.DataFrame


@dataclass(frozen=True, eq=False)
class _Scoring:
    """What a system is scored by, and its stages; each is repeated only where a setting changed."""

    name: str
    threshold: float | None
    dataset: Dataset
    params: Params
    tracks: TruthTracks
    encounters: Encounters
    k_truth: Weights
    k_miss: np.ndarray
    cost: np.ndarray
    contact: Contact
    urgency: pd.DataFrame
    memo: Memo

    def _get(self, what: str, make: Callable[[], T], *stages: Stage) -> T:
        number = self.dataset.systems.index(self.name)  # it stays when a system is renamed
        return self.memo.get((what, number, self.threshold), make, *stages)

    @cached_property
    def _detections(self) -> BoxColumns:
        return self.dataset.system(self.name)

    def matches(self) -> Matches:
        """Which detections count, and whom they match."""
        return self._get(
            "matches",
            lambda: match_system(self.dataset, self.name, self.threshold, self.params),
            MATCH,
        )

    def counts(self, matches: Matches) -> _Counts:
        """What follows from the matches alone."""
        truth, frames, detections = (
            self.dataset.truth,
            self.dataset.frame_columns,
            self._detections,
        )
        is_counted = self._is_counted(matches)
        n_det = self._get("n_det", lambda: count_per_frame(detections, is_counted), MATCH)
        matched = self._get("matched", lambda: count_per_frame(truth, matches.is_matched), MATCH)
        return _Counts(
            n_det,
            matched,
            self._get("false_alarms", lambda: n_det - matched, MATCH),
            self._get(
                "episodes", lambda: find_episodes(detections, matches.is_false_alarm, frames), MATCH
            ),
        )

    def _is_counted(self, matches: Matches) -> np.ndarray:
        return self._get("is_counted", lambda: matches.is_counted, MATCH)

    def sets(self, matches: Matches) -> tuple[Nearest, Weights, SetDistances]:
        """Truth and detections as sets: nearest boxes, weights of detections, distances."""
        dataset, params, detections = self.dataset, self.params, self._detections
        frames, is_counted = dataset.frame_columns, self._is_counted(matches)
        nearest = self._get(
            "nearest", lambda: nearest_of(dataset, self.name, matches, params), NEAREST
        )
        weights = self._get(
            "weights",
            lambda: weigh_proximity(detections, is_counted, frames, params),
            MATCH,
            PROXIMITY,
        )
        distances = self._get(
            "distances",
            lambda: measure_sets(
                dataset.truth,
                self.k_miss,
                detections,
                weights.k,
                is_counted,
                nearest,
                frames,
                edge_weight=in_use(params, "edge_weight", frames),
                track=self.tracks.track,
            ),
            DISTANCES,
        )
        return nearest, weights, distances

    def salient(self, nearest: Nearest, distances: SetDistances) -> tuple[np.ndarray, pd.DataFrame]:
        """The pedestrian of each frame that qualifies for saliency, and the saliency events."""
        truth, frames, params = self.dataset.truth, self.dataset.frame_columns, self.params
        salient_row = self._get(
            "salient_row", lambda: qualify(distances, frames, tolerance=params.tolerance), SALIENT
        )
        edge_weight = in_use(params, "edge_weight", frames)
        events = self._get(
            "events",
            lambda: find_events(
                *(truth, self.k_truth.k, nearest.truth, distances.d_miss, salient_row),
                *(self.tracks.track, self.encounters, frames, edge_weight, params),
                k_miss=self.k_miss,
            ),
            EVENTS,
        )
        return salient_row, events

    def outcomes(self, matches: Matches) -> tuple[pd.DataFrame, pd.DataFrame]:
        """How the system did in each encounter, and what its failures weigh there."""
        truth, frames, k = self.dataset.truth, self.dataset.frame_columns, self.k_truth.k
        encounters, is_matched = self.encounters, matches.is_matched
        outcomes = self._get(
            "outcomes",
            lambda: judge_encounters(encounters, k, is_matched, frames, self.params),
            ENCOUNTERS,
        )
        failures = self._get(
            "failures",
            lambda: weigh_failures(truth, encounters, k, self.cost, is_matched, frames),
            SEVERITY,
        )
        return outcomes, failures

    def time_left(self, matches: Matches) -> tuple[pd.DataFrame, Judgement]:
        """When the system confirms each pedestrian, and whether that is in time."""
        frames, params = self.dataset.frame_columns, self.params
        confirmed = self._get(
            "confirmed",
            lambda: confirm(self.contact, self.encounters, matches.is_matched, params),
            *(CONTACT, CONFIRMED),
        )
        judgement = Judgement(self.urgency, confirmed, frames, params)
        return confirmed, self._get("time_left", lambda: judgement, TIME_LEFT)
