"""A simulated change of light in words: when the driver would see whom, and whether in time."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.wording import count_text

NOBODY_THERE: Final = "The pedestrian is in no frame after it: nothing changes."


def describe_change(
    course: pd.DataFrame,
    simulated: pd.DataFrame,
    *,
    threshold: float,
    change_s: float,
    caution: str = "",
) -> str:
    """What would be, had it become dark at `change_s`, beside what was.

    Parameters
    ----------
    course
        Of `nvcore.tables.encounters.driver.detectability_course`.
    simulated
        The same rows by `nvcore.driver.simulation.simulate_change`.
    threshold
        From which detectability on the driver is taken to see the pedestrian, 0..1.
    change_s
        Seconds from the recording's first frame, as those of the course.
    caution
        Whose answers the estimates rest on, where some were simulated
        (`nvcore.dataset.estimates.EstimateRecord.caution`).
    """
    is_after = simulated["is_simulated"].to_numpy(bool)
    head = f"Simulated: dark from {change_s:.2f} s on."
    if not is_after.any():
        return f"{head} {NOBODY_THERE}"
    later_s = course["time_s"].to_numpy(float)[is_after] - change_s
    was, would = (table["detectability"].to_numpy(float) for table in (course, simulated))
    before, soon = (_when(share[is_after], threshold, later_s) for share in (was, would))
    text = f"{head}{f' Estimates are {caution}.' if caution else ''} {_compared(soon, before)}"
    is_up_to = course["is_up_to_relevant"].to_numpy(bool)
    if not is_up_to.any():
        return f"{text} The encounter is distant: there is no frame by which he has to."
    relevant_s = float(course["time_s"].to_numpy(float)[is_up_to][-1])
    in_time = _in_time(_is_seen(was[is_up_to], threshold), _is_seen(would[is_up_to], threshold))
    return f"{text} By the first frame that counts, at {relevant_s:.2f} s, {in_time}"


def _when(share: NDArray[np.float64], threshold: float, later_s: NDArray[np.float64]) -> str:
    """After how many frames he sees the pedestrian first; empty: it is known of none of them."""
    is_known = np.isfinite(share)
    if not is_known.any():
        return ""
    sees = share >= threshold  # never where it is unknown
    n_known, n = int(is_known.sum()), len(share)
    if not sees.any():
        known = "" if n_known == n else f" in which it is known, of {n:,}"
        return f"in none of {count_text(n_known, 'frame')}{known}"
    n_frames = int(np.argmax(sees))
    if not n_frames:
        return "at once"
    sooner = "" if is_known[:n_frames].all() else "at the latest "
    return f"{sooner}{count_text(n_frames, 'frame')} ({later_s[n_frames]:.2f} s) later"


def _compared(soon: str, before: str) -> str:
    """When he would see the pedestrian, beside when he does; empty: it is not known."""
    if not soon:
        return "Whether the driver would see the pedestrian is not known in any frame after it."
    without = f"; without the change, {before or 'it is not known'}"
    same = ", as without the change"
    return (
        f"After it the driver would see the pedestrian {soon}{same if soon == before else without}."
    )


def _is_seen(share: NDArray[np.float64], threshold: float) -> bool | None:
    """Whether he sees the pedestrian in a frame; None: it is known of none of them."""
    return bool((share >= threshold).any()) if np.isfinite(share).any() else None


def _in_time(was: bool | None, would: bool | None) -> str:
    if would is None:
        return "it is not known whether he would have seen him."
    if was == would:
        negated = "" if would else "not "
        return f"he would {negated}have seen him, with the change or without."
    text = f"he would {'' if would else '**not** '}have seen him; without the change"
    if was is None:
        return f"{text} it is not known."
    return f"{text} he would {'have' if was else 'not have'}."
