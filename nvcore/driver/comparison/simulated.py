"""A simulated change of light in words: when the driver would see whom, and whether in time."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.objects import Objects
from nvcore.wording import count_text

NOBODY_THERE: Final = "The {one} is in no frame after it: nothing changes."
SEEN_BEFORE: Final = (
    "The driver had seen the {one} before, at {time_s:.2f} s: the change comes too late to matter "
    "for an alert."
)


def describe_change(
    course: pd.DataFrame,
    simulated: pd.DataFrame,
    *,
    threshold: float,
    change_s: float,
    caution: str = "",
    objects: Objects,
) -> str:
    """What would be, had it become dark at `change_s`, beside what was.

    Parameters
    ----------
    course
        Of `nvcore.driver.comparison.encounters.detectability_course`.
    simulated
        The same rows by `nvcore.driver.simulation.simulate_change`.
    threshold
        From which detectability on the driver is taken to see the pedestrian, 0..1.
    change_s
        Seconds from the recording's first frame, as those of the course.
    caution
        Whose answers the estimates rest on, where some were simulated
        (`nvcore.driver.inputs.record.EstimateRecord.caution`).
    objects
        What is to be seen.
    """
    noun, he, him = objects.singular, objects.say("{he}"), objects.say("{him}")
    is_after = simulated["is_simulated"].to_numpy(bool)
    head = f"Simulated: dark from {change_s:.2f} s on."
    if not is_after.any():
        return f"{head} {objects.say(NOBODY_THERE)}"
    time_s, is_up_to = course["time_s"].to_numpy(float), course["is_up_to_relevant"].to_numpy(bool)
    was, would = (table["detectability"].to_numpy(float) for table in (course, simulated))
    later_s = time_s[is_after] - change_s
    is_there = not is_after[0] or round(later_s[0], 6) <= 0
    until = "" if is_after[-1] else " until the next real change"
    before, soon = (
        _when(he, share[is_after], threshold, later_s, is_there=is_there, until=until)
        for share in (was, would)
    )
    seen = np.flatnonzero(was[: np.argmax(is_after)] >= threshold)
    parts = [head, f"Estimates are {caution}." if caution else ""]
    if len(seen) and is_up_to[seen[0]]:
        parts.append(objects.say(SEEN_BEFORE, time_s=time_s[seen[0]]))
    text = " ".join(filter(None, [*parts, _compared(noun, him, soon, before, again=len(seen) > 0)]))
    if not is_up_to.any():
        return f"{text} The encounter is distant: there is no frame by which that matters."
    relevant_s = float(time_s[is_up_to][-1])
    seen_was, seen_would = (_is_seen(share[is_up_to], threshold) for share in (was, would))
    in_time = _in_time(noun, seen_was, seen_would)
    return f"{text} By the first frame that counts, at {relevant_s:.2f} s, {in_time}"


def _when(
    he: str,
    share: NDArray[np.float64],
    threshold: float,
    later_s: NDArray[np.float64],
    *,
    is_there: bool,
    until: str,
) -> str:
    """After how many frames he sees the pedestrian first; empty: it is known of none of them.

    Parameters
    ----------
    later_s
        Seconds of the pedestrian's frames since the change.
    is_there
        Whether the pedestrian was there before, too; else frames count from where he appears.
    until
        What ends these frames before the pedestrian has gone; empty: nothing.
    """
    is_known = np.isfinite(share)
    if not is_known.any():
        return ""
    sees = share >= threshold  # never where it is unknown
    n_known, n = int(is_known.sum()), len(share)
    if not sees.any():
        known = "" if n_known == n else f" in which it is known, of {n:,}"
        return f"in none of {count_text(n_known, 'frame')}{known}{until}"
    n_frames = int(np.argmax(sees))
    seconds = f"{later_s[n_frames]:.2f} s"
    if not n_frames:
        return "at once" if is_there else f"as soon as {he} appears, {seconds} after the change"
    sooner = "" if is_known[:n_frames].all() else "at the latest "
    frames = count_text(n_frames, "frame")
    if is_there:
        return f"{sooner}{frames} ({seconds}) later"
    return f"{sooner}{frames} after {he} appears, {seconds} after the change"


def _compared(noun: str, him: str, soon: str, before: str, *, again: bool) -> str:
    """When he would see the pedestrian, beside when he does, and whether that is not the first."""
    if not soon:
        return f"Whether the driver would see the {noun} is not known in any frame after it."
    sees_then = f" the driver sees {him} {before}" if before else ", it is not known"
    without = f"; without the change{sees_then}"
    same = ", as without the change"
    sees = f"would see the {noun} again" if again else f"would see the {noun}"
    return f"After it the driver {sees} {soon}{same if soon == before else without}."


def _is_seen(share: NDArray[np.float64], threshold: float) -> bool | None:
    """Whether he sees the pedestrian in a frame; None: it is known of none of them."""
    return bool((share >= threshold).any()) if np.isfinite(share).any() else None


def _in_time(noun: str, was: bool | None, would: bool | None) -> str:
    if would is None:
        return f"it is not known whether the driver would have seen the {noun}."
    if was == would:
        negated = "" if would else "not "
        return f"the driver would {negated}have seen the {noun}, with the change or without."
    negated = "" if would else "**not** "
    text = f"the driver would {negated}have seen the {noun}; without the change"
    if was is None:
        return f"{text} it is not known."
    return f"{text} the driver would {'have' if was else 'not have'}."
