"""Loop over the frames of tracks that switches alerts on and off."""

from __future__ import annotations

from nvcore.dataset.schema import SAME_S
from nvcore.metrics.kernels import compiled


@compiled
def last_frame(on, held, final, time_s, off_s, least_s):
    """Return the last frame row of an alert that began at `on` and was last sustained in `held`."""
    row = held
    while row < final and (
        time_s[row + 1] - time_s[held] <= off_s + SAME_S
        or time_s[row + 1] - time_s[on] < least_s - SAME_S
    ):
        row += 1
    return row


@compiled
def switch_alerts(
    key, frame_row, final_row, time_s, end_s, on_s, off_s, least_s, pause_s, step, onset, end, first
):
    """Find the alerts of tracks and return their number.

    Parameters
    ----------
    key, frame_row
        Track and frame of each box that meets the policy, sorted by both.
    final_row, time_s, end_s
        For each frame: last frame row of its recording; its begin and end, seconds.
    step
        Number of listed frames after the last box within which another box continues its run.
    onset, end, first
        Filled for each alert: its first and last frame row, and the position of its first box.
    """
    n, on, run, held, free_s = 0, -1, 0, 0, 0.0
    for i in range(len(key)):
        row = frame_row[i]
        is_new = i == 0 or key[i] != key[i - 1]
        if on >= 0:
            last = last_frame(on, held, final_row[on], time_s, off_s, least_s)
            # a box in the frame after the last one: the alert was on in every frame
            if not is_new and row <= max(last + 1, held + step):
                held = row
                continue
            end[n], n, on, free_s = last, n + 1, -1, end_s[last]
            run = row
        elif is_new or row > held + step:
            run = row
        held = row
        is_free = n == 0 or key[i] != key[first[n - 1]] or time_s[row] - free_s >= pause_s - SAME_S
        if is_free and time_s[row] - time_s[run] >= on_s - SAME_S:
            on, onset[n], first[n] = row, row, i
    if on >= 0:
        end[n] = last_frame(on, held, final_row[on], time_s, off_s, least_s)
        n += 1
    return n
