"""Result of scoring one system. Rarely used values are computed on demand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.metrics.false_alarms import FalseAlarmSummary
from nvcore.metrics.losses import NO_WINDOW, Window, find_worst_windows, lost_per_minute
from nvcore.metrics.matching import Matches
from nvcore.metrics.proximity import Weights
from nvcore.metrics.similarity import (
    Nearest,
    SetDistances,
    SimilaritySummary,
    find_low_intervals,
    smooth,
    summarise_similarity,
)
from nvcore.settings.params import Params


@dataclass(frozen=True, eq=False)
class SystemResult:
    """Result of scoring one system.

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
        Performance in each encounter (`nvcore.metrics.encounters.judge_encounters`).
    failures
        Weight of its failures in each encounter (`nvcore.metrics.severity.weigh_failures`).
    episodes
        False-alert episodes (`nvcore.metrics.false_alarms.find_episodes`).
    summary
        Aggregates of similarity over all frames.
    false_alarm_summary
        Rates of false alarms over all recordings.
    saliency_s
        Mean saliency over recordings, each with its most salient event or the sum of all
        (`saliency_aggregate`); NaN without frames.
    made
        Results of all steps, including those of subjects, by step name.
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
    failures: pd.DataFrame
    episodes: pd.DataFrame
    summary: SimilaritySummary
    false_alarm_summary: FalseAlarmSummary
    saliency_s: float
    made: Mapping[str, Any] = field(repr=False)
    _dataset: Dataset = field(repr=False)
    _params: Params = field(repr=False)

    @cached_property
    def similarity_window(self) -> np.ndarray:
        """Moving mean of similarity, 1 is best, float64, shape (n_frames,)."""
        return smooth(self.similarity, self._dataset.frame_columns, window=self._params.window)

    @cached_property
    def loss_miss(self) -> np.ndarray:
        """Loss of each frame to misses, ``alpha * D(G, S) / (W/2)``, float64, (n_frames,)."""
        half_width = self._dataset.frame_columns.half_width
        lost: np.ndarray = self._params.alpha * self.distances.d_miss / half_width
        return lost

    @cached_property
    def loss_false(self) -> np.ndarray:
        """Loss of each frame to false alarms, ``(1 - alpha) * D(S, G) / (W/2)``, (n_frames,)."""
        half_width = self._dataset.frame_columns.half_width
        lost: np.ndarray = (1 - self._params.alpha) * self.distances.d_false / half_width
        return lost

    @cached_property
    def lost_s_per_min(self) -> float:
        """Lost similarity, seconds per minute (`nvcore.metrics.losses.lost_per_minute`)."""
        return lost_per_minute(self.similarity, self._dataset.frame_columns.step_s)

    @cached_property
    def worst_window_of_recordings(self) -> tuple[Window, ...]:
        """Window with the lowest moving mean in every recording."""
        return find_worst_windows(
            self.similarity,
            self.similarity_window,
            self._dataset.frame_columns,
            window=self._params.window,
        )

    @cached_property
    def worst_window(self) -> Window:
        """Window with the lowest moving mean of all recordings, `NO_WINDOW` without frames."""
        windows = [window for window in self.worst_window_of_recordings if window.row >= 0]
        return min(windows, key=lambda window: window.mean, default=NO_WINDOW)

    @cached_property
    def intervals(self) -> pd.DataFrame:
        """Low-similarity intervals (`nvcore.metrics.similarity.find_low_intervals`)."""
        return find_low_intervals(
            self.similarity, self._dataset.frame_columns, low=self._params.low
        )

    @cached_property
    def summary_of_recordings(self) -> tuple[SimilaritySummary, ...]:
        """Aggregates of similarity over the frames of every recording."""
        # a loop over recordings: percentiles need each recording's own sorted frames
        return tuple(
            summarise_similarity(self.similarity[start:end], low=self._params.low)
            for start, end in pairwise(self._dataset.frame_columns.first)
        )
