"""False alarms, and episodes of false alarms that a driver would notice as a single alert."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.metrics.linking import link_boxes

EPISODE_COLUMNS = ("recording", "first_row", "last_row", "n_boxes", "duration_s")


def link_alarms(
    detections: BoxColumns, is_false_alarm: np.ndarray, frames: FrameColumns
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of one system's unmatched detections, and the episode of each, int64."""
    rows = np.flatnonzero(is_false_alarm)
    return rows, link_boxes(detections, frames, rows)


def find_episodes(
    detections: BoxColumns, is_false_alarm: np.ndarray, frames: FrameColumns
) -> pd.DataFrame:
    """Link one system's unmatched detections over frames into false-alert episodes.

    Returns
    -------
    One row per episode, by first frame: recording, first_row, last_row (of the frames), n_boxes,
    duration_s (time steps from its first to its last frame, seconds).
    """
    rows, episode = link_alarms(detections, is_false_alarm, frames)
    frame_index = detections.frame_index[rows]
    n_episodes = int(episode.max()) + 1 if len(episode) else 0
    first_row = np.empty(n_episodes, np.int64)
    last_row = np.empty(n_episodes, np.int64)
    first_row[episode[::-1]] = frame_index[::-1]
    last_row[episode] = frame_index
    passed = frames.passed
    recording = frames.recording[first_row]
    return pd.DataFrame(
        {
            "recording": recording,
            "first_row": first_row,
            "last_row": last_row,
            "n_boxes": np.bincount(episode, minlength=n_episodes).astype(np.int64),
            "duration_s": (passed[last_row + 1] - passed[first_row]) / frames.fps[recording],
        },
        columns=list(EPISODE_COLUMNS),
    )


@dataclass(frozen=True)
class FalseAlarmSummary:
    """False alarms of one system. 0 is best, NaN if nothing was recorded.

    Attributes
    ----------
    count
        Unmatched detections not absorbed by ignore regions.
    per_frame, per_minute
        Rates by listed frames and by recording time.
    episodes, episodes_per_hour
        Runs that a driver would notice as a single false alert.
    mean_episode_s, longest_episode_s
        Duration; NaN without episodes.
    """

    count: int
    per_frame: float
    per_minute: float
    episodes: int
    episodes_per_hour: float
    mean_episode_s: float
    longest_episode_s: float


def summarise_false_alarms(
    count: int, episodes: pd.DataFrame, *, n_frames: int, duration_s: float
) -> FalseAlarmSummary:
    """Compute false-alarm rates over `n_frames` listed frames and `duration_s` of recording."""
    nan = float("nan")
    lengths = episodes["duration_s"]
    return FalseAlarmSummary(
        count=count,
        per_frame=count / n_frames if n_frames else nan,
        per_minute=count / duration_s * 60 if duration_s else nan,
        episodes=len(episodes),
        episodes_per_hour=len(episodes) / duration_s * 3600 if duration_s else nan,
        mean_episode_s=float(lengths.mean()) if len(episodes) else nan,
        longest_episode_s=float(lengths.max()) if len(episodes) else nan,
    )
