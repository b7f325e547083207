"""Compiled loop over light readings that finds changes from bright to dark."""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled


@compiled
def find_changes(time_s, level, held, is_first, factor, within_s, bright_for_s, start, end):
    """Find the readings at which it becomes dark and at which light is back, and count the changes.

    Parameters
    ----------
    time_s, level
        Smoothed readings.
    held
        Minimum level of the last `bright_for_s` seconds, NaN if less is known.
    is_first
        Whether a reading is the first one or follows a gap, so that nothing is known before it.
    factor, within_s, bright_for_s
        See `LightSettings`.
    start, end
        Output: rows of the readings. `end` is -1 if the light does not come back before the next
        change or gap.
    """
    n_changes = 0
    is_dark = False  # since the last change, as far as known
    since = -np.inf  # earlier readings belong to the time before the last change
    darkest = np.inf
    risen = -1  # start of a rise that has lasted until now
    for i in range(len(level)):
        now = time_s[i]
        if is_first[i]:
            since, is_dark = now, False
        before = -np.inf
        j = i
        # the previous reading counts however old it is, as nothing else is known
        while j >= 0 and (time_s[j] >= now - within_s or j == i - 1) and time_s[j] >= since:
            if held[j] > before:
                before = held[j]
            j -= 1
        if before > -np.inf and level[i] * factor <= before:
            start[n_changes], end[n_changes] = i, -1
            n_changes += 1
            since, darkest, risen, is_dark = now + bright_for_s, level[i], -1, True
            continue
        if not is_dark:
            continue
        darkest = min(darkest, level[i])
        if level[i] < darkest * factor:
            risen = -1
        elif risen < 0:
            risen = i
        if risen >= 0 and now - time_s[risen] >= bright_for_s:
            end[n_changes - 1], is_dark = risen, False
    return n_changes
