"""Lost similarity and worst window of both systems, by recording and over all recordings."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.values import lost_per_minute_by_recording
from nvcore.notes import Note

ALL: Final = "all recordings"
"""Name in the row over all recordings."""


def windows_table(result: Result) -> pd.DataFrame:
    """Return lost similarity per minute and the worst window of each recording and of all.

    Returns
    -------
    The row over all recordings first, if there are several, then those with frames, most lost per
    minute by either system on top: recording (``all recordings`` in the first), recording_index (-1
    in the first); for each system lost_s_per_min (seconds per minute, 0 is best), window_similarity
    (mean of the worst window, 1 is best), window_lost_s (its loss, seconds), window_row (its middle
    frame, a row of the frames table), window_recording (name) and window_time_s of
    that frame. Empty without frames.
    """
    frames = result.dataset.frame_columns
    names = result.dataset.recordings["name"].to_numpy(dtype=object)
    time_s = result.dataset.frames["time_s"].to_numpy()
    with_frames = np.flatnonzero(np.diff(frames.first)).tolist()
    n_all = int(len(with_frames) > 1)  # rows over all recordings
    columns: dict[str, Any] = {
        "recording": n_all * [ALL] + names[with_frames].tolist(),
        "recording_index": n_all * [-1] + with_frames,
    }
    for letter, system in result.sides:
        lost = lost_per_minute_by_recording(result, system)[with_frames]
        windows = n_all * [system.worst_window]
        windows += [system.worst_window_of_recordings[recording] for recording in with_frames]
        middle = np.array([window.row for window in windows], dtype=np.int64)
        columns |= {
            f"lost_s_per_min_{letter}": n_all * [system.lost_s_per_min] + lost.tolist(),
            f"window_similarity_{letter}": [window.mean for window in windows],
            f"window_lost_s_{letter}": [window.lost_s for window in windows],
            f"window_row_{letter}": middle,
            f"window_recording_{letter}": names[frames.recording[middle]],
            f"window_time_s_{letter}": time_s[middle],
        }
    table = pd.DataFrame(columns)
    worse = table[["lost_s_per_min_x", "lost_s_per_min_y"]].max(axis=1).to_numpy()
    order = np.argsort(-worse[n_all:], kind="stable") + n_all
    by_loss: pd.DataFrame = table.iloc[[*range(n_all), *order]].reset_index(drop=True)
    return by_loss


def worst_windows_note(table: pd.DataFrame) -> Note:
    """Return where each system's worst window of all recordings is.

    Parameters
    ----------
    table
        `windows_table` with at least one row.
    """
    of_all = table.iloc[0]
    recordings = {letter: of_all[f"window_recording_{letter}"] for letter in "xy"}
    times_s = {f"{letter}_s": float(of_all[f"window_time_s_{letter}"]) for letter in "xy"}
    return Note("moments.worst_windows", **recordings, **times_s)
