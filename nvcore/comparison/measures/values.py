"""Values of measures by recording, and the summands that are resampled for evidence."""

from __future__ import annotations

from collections.abc import Callable
from math import nan

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Parts
from nvcore.comparison.scoring import SystemResult


def per_recording(result: Result, values: np.ndarray | None, recording: np.ndarray) -> np.ndarray:
    """Sum `values` over each recording, float64, shape (n_recordings,)."""
    return np.bincount(recording, weights=values, minlength=len(result.dataset.recordings))


def duration_of_recordings(result: Result) -> np.ndarray:
    """Return the duration of each recording (sum of its time steps), s, shape (n_recordings,)."""
    frames = result.dataset.frame_columns
    duration_s: np.ndarray = per_recording(result, frames.gap, frames.recording) / frames.fps
    return duration_s


def ratio_of(numerator: float, denominator: float) -> float:
    """Divide, giving NaN for a denominator of 0."""
    return float(numerator) / denominator if denominator else nan


def largest_event(system: SystemResult) -> float:
    """Return the saliency of the most salient event, s, 0 without any, NaN without frames."""
    if not len(system.similarity):
        return nan
    return float(system.events["saliency_s"].max()) if len(system.events) else 0.0


def relevant_share(system: SystemResult) -> float:
    """Return the share of the events' time in which the pedestrian counts, NaN without events."""
    return ratio_of(system.events["relevant_s"].sum(), float(system.events["duration_s"].sum()))


def saliency_values(result: Result, system: SystemResult) -> np.ndarray:
    """Return the saliency of each recording, s, NaN without frames, shape (n_recordings,)."""
    has_frames = np.diff(result.dataset.frame_columns.first) > 0
    return np.where(has_frames, result.saliency_of_recordings(system), nan)


def severity_parts(result: Result, system: SystemResult) -> Parts:
    """Return the severity of each encounter, s."""
    severity_s = system.failures["severity_s"].to_numpy(dtype=float)
    return Parts(result.encounters.first_row, severity_s)


def severity_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    """Return the severity of each recording's encounters, s, float64, shape (n_recordings,)."""
    return per_recording(result, severity_parts(result, system).value, result.encounters.recording)


def lost_parts(result: Result, system: SystemResult) -> Parts:
    """Return the similarity lost in each frame, s."""
    step_s = result.dataset.frame_columns.step_s
    return Parts(np.arange(len(step_s)), (1 - system.similarity) * step_s)


def lost_per_minute_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    """Return the similarity lost per minute of each recording, s, shape (n_recordings,)."""
    lost_s = per_recording(
        result, lost_parts(result, system).value, result.dataset.frame_columns.recording
    )
    with np.errstate(invalid="ignore"):  # a recording without frames has no rates
        rates: np.ndarray = 60 * lost_s / duration_of_recordings(result)
    return rates


def worst_windows(name: str) -> Callable[[Result, SystemResult], list[float]]:
    """Return a function for an attribute of each recording's worst window."""

    def values(_: Result, system: SystemResult) -> list[float]:
        return [getattr(window, name) for window in system.worst_window_of_recordings]

    return values


def saliency_parts(result: Result, system: SystemResult) -> Parts | None:
    """Return the saliency of each event, s, or None if only the largest event counts."""
    if result.params.saliency_aggregate == "max":
        return None
    events = system.events
    return Parts(
        events["first_row"].to_numpy(dtype=np.int64), events["saliency_s"].to_numpy(dtype=float)
    )


def similarity_parts(_: Result, system: SystemResult) -> Parts:
    """Return the similarity of each frame."""
    return Parts(np.arange(len(system.similarity)), system.similarity)


def low_parts(result: Result, system: SystemResult) -> Parts:
    """Return which frames have a similarity below `low`."""
    return Parts(np.arange(len(system.similarity)), system.similarity < result.params.low)


def detected_parts(result: Result, system: SystemResult) -> Parts:
    """Return the near encounters that the system detects."""
    is_detected = system.encounters["is_detected"].to_numpy(dtype=bool) & result.is_near
    return Parts(result.encounters.first_row[is_detected], None)


def episode_parts(_: Result, system: SystemResult) -> Parts:
    """Return the false-alert episodes."""
    return Parts(system.episodes["first_row"].to_numpy(dtype=np.int64), None)


def detected_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    """Count the detected encounters, int64, shape (n_recordings,)."""
    is_detected = system.encounters["is_detected"].to_numpy()
    return per_recording(result, is_detected, result.encounters.recording).astype(np.int64)


def alarms_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    """Count the false alarms, int64, shape (n_recordings,)."""
    recording = result.dataset.frame_columns.recording
    return per_recording(result, system.false_alarms, recording).astype(np.int64)


def episodes_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    """Count the false-alert episodes, int64, shape (n_recordings,)."""
    recording = system.episodes["recording"].to_numpy()
    return per_recording(result, np.ones(len(recording)), recording).astype(np.int64)


def rate_by_recording(
    counts: Callable[[Result, SystemResult], np.ndarray], *, per_s: float
) -> Callable[[Result, SystemResult], np.ndarray]:
    """Return a function for the counts of each recording per `per_s` seconds."""

    def rate(result: Result, system: SystemResult) -> np.ndarray:
        with np.errstate(invalid="ignore"):  # a recording without frames has no rates
            rates: np.ndarray = counts(result, system) / duration_of_recordings(result) * per_s
        return rates

    return rate


def similarity_by_recording(name: str) -> Callable[[Result, SystemResult], list[float]]:
    """Return a function for an attribute of each recording's similarity summary."""

    def values(_: Result, system: SystemResult) -> list[float]:
        return [getattr(summary, name) for summary in system.summary_of_recordings]

    return values
