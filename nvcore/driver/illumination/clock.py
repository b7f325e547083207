"""How bright it was in each frame of a recording, and how long the eyes have had to adapt."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.illumination.changes import Changes, changes_of
from nvcore.driver.illumination.meter import Light, LightSource
from nvcore.driver.illumination.settings import LightSettings


@dataclass(frozen=True, eq=False)
class AdaptationClock:
    """Light and adaptation in the evaluated frames of a recording.

    Attributes
    ----------
    time_s
        When each frame begins, seconds from the first of them, float64, shape (n,): the times of
        the dataset's frames.
    level
        Last reading then, in the unit of the source (`LIGHT_UNIT`), float64, shape (n,); NaN: none.
    period_s
        Seconds from the last change from bright to dark to the end of the frame, float64, shape
        (n,). NaN: none is known, or the light is back, or the readings have ended.
    change_s
        When it became dark, on the same axis as `time_s`, float64, ascending.
    source
        What told how bright it was.
    simulated_s
        Which of the changes never was; None: all were.
    """

    time_s: NDArray[np.float64]
    level: NDArray[np.float64]
    period_s: NDArray[np.float64]
    change_s: NDArray[np.float64]
    source: LightSource
    simulated_s: float | None = None


def adaptation_clock(
    light: Light, frame: NDArray[np.int64], fps: float, settings: LightSettings | None = None
) -> AdaptationClock:
    """Light and adaptation in the frames of a recording.

    Parameters
    ----------
    light
        Readings over the recording, with times from frame 0.
    frame
        Numbers of its evaluated frames, int64, ascending, shape (n,).
    fps
        Frames per second.
    settings
        What counts as a change; None: our defaults.
    """
    changes: Changes = changes_of(light, settings or LightSettings())
    begin_s, end_s = frame / fps, (frame + 1) / fps
    period_s = np.where(begin_s <= light.end_s, changes.period_s(end_s), np.nan)
    first_s = begin_s[0] if len(frame) else 0.0
    return AdaptationClock(
        _from_first(frame, fps),
        light.at(begin_s),
        period_s,
        changes.start_s - first_s,
        light.source,
    )


def unknown_clock(frame: NDArray[np.int64], fps: float) -> AdaptationClock:
    """The clock where nothing is known of the light."""
    nothing = np.full(len(frame), np.nan)
    time_s = _from_first(frame, fps)
    return AdaptationClock(time_s, nothing, nothing, np.empty(0), LightSource.PICTURE)


def _from_first(frame: NDArray[np.int64], fps: float) -> NDArray[np.float64]:
    """When frames begin, as a dataset says it: seconds from the first of them."""
    time_s: NDArray[np.float64] = (frame - frame[:1].sum()) / fps
    return time_s


def with_change(clock: AdaptationClock, fps: float, change_s: float) -> AdaptationClock:
    """The clock as it would be, had it become dark at `change_s`, too.

    The light stays what it was: nobody knows how bright it would have been.

    Parameters
    ----------
    fps
        Frames per second.
    change_s
        Seconds from the first frame, as `clock.time_s`.
    """
    period_s, _ = period_after(clock.period_s, clock.time_s + 1 / fps, change_s)
    times = np.sort(np.append(clock.change_s, change_s))
    return replace(clock, period_s=period_s, change_s=times, simulated_s=change_s)


def period_after(
    period_s: NDArray[np.float64], end_s: NDArray[np.float64], change_s: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Adaptation periods had it become dark at `change_s`, and which of them run from then.

    Frames that end before or at the change keep theirs; so do those that a real change comes
    before, after the simulated one.

    Parameters
    ----------
    period_s
        As they are, seconds, NaN none, float64, shape (n,).
    end_s
        When the frames end, on the axis of `change_s`, seconds, float64, shape (n,).
    """
    since_s = Changes(np.array([change_s]), np.array([np.nan])).period_s(end_s)
    is_simulated = np.isfinite(since_s) & ~(period_s < since_s)
    return np.where(is_simulated, since_s, period_s), is_simulated
