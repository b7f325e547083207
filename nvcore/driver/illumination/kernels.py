"""The loop over light readings that finds changes from bright to dark."""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled


@compiled
def find_changes(time_s, level, held, is_first, factor, within_s, bright_for_s, start, end):
    """Readings at which it has become dark, and those at which the light is back; how many.

    Parameters
    ----------
    time_s, level
        Readings, smoothed.
    held
        Least level of the last `bright_for_s` seconds; NaN where less is known.
    is_first
        Whether a gap lies before a reading, or nothing: nothing is known then of what came before.
    factor, within_s, bright_for_s
        See `LightSettings`.
    start, end
        Out: rows of the readings; `end` is -1 where the light does not come back before the next
        change, or the next gap.
    """
    n_changes = 0
    is_dark = False  # since the last change, as far as is known
    since = -np.inf  # readings before are of what came before the last change
    darkest = np.inf
    risen = -1  # where the light rose that is still up
    for i in range(len(level)):
        now = time_s[i]
        if is_first[i]:
            since, is_dark = now, False
        before = -np.inf
        j = i
        # the reading before is looked at however long ago it was: more is not known
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
