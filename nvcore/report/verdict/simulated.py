"""A simulated change of light in words: when the driver would see whom, and whether in time."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.wording import count_text

NOBODY_THERE: Final = "The pedestrian is in no frame after it: nothing changes."


def describe_change(
    course: pd.DataFrame, simulated: pd.DataFrame, *, threshold: float, change_s: float
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
        Seconds from frame 0.
    """
    is_after = simulated["is_simulated"].to_numpy(bool)
    head = f"Simulated: dark from {change_s:.2f} s on."
    if not is_after.any():
        return f"{head} {NOBODY_THERE}"
    time_s = course["time_s"].to_numpy(float)[is_after]
    was, would = (
        table["detectability"].to_numpy(float) >= threshold for table in (course, simulated)
    )
    soon = _first(would[is_after], time_s, change_s)
    before = _first(was[is_after], time_s, change_s)
    as_it_was = "; so he does as it was" if soon == before else f"; as it was, {before}"
    text = f"{head} After it the driver sees the pedestrian {soon}{as_it_was}."
    is_up_to = course["is_up_to_relevant"].to_numpy(bool)
    if not is_up_to.any():
        return f"{text} The encounter is distant: there is no frame by which he has to."
    relevant_s = float(course["time_s"].to_numpy(float)[is_up_to][-1])
    return f"{text} {_in_time(bool(was[is_up_to].any()), bool(would[is_up_to].any()), relevant_s)}"


def _first(sees: NDArray[np.bool_], time_s: NDArray[np.float64], change_s: float) -> str:
    """After how many frames he sees the pedestrian first."""
    if not sees.any():
        return f"in none of {count_text(len(sees), 'frame')}"
    n_frames = int(np.argmax(sees))
    if not n_frames:
        return "at once"
    later_s = float(time_s[n_frames]) - change_s
    return f"{count_text(n_frames, 'frame')} ({later_s:.2f} s) later"


def _in_time(was: bool, would: bool, relevant_s: float) -> str:
    by = f"By the first frame that counts, at {relevant_s:.2f} s,"
    if was == would:
        return f"{by} he {'would have seen' if would else 'would not have seen'} him, as it was."
    if would:
        return f"{by} he would have seen him; as it was, he had not."
    return f"{by} he would **not** have seen him; as it was, he had."
