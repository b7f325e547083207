"""How bright it was in each frame of a recording, and how long the eyes have had to adapt."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.illumination.changes import Changes, LightSettings, changes_of
from nvcore.driver.illumination.meter import Light, LightSource
from nvcore.schema import SAME_S


@dataclass(frozen=True, eq=False)
class AdaptationClock:
    """Light and adaptation in the evaluated frames of a recording.

    Attributes
    ----------
    time_s
        When each frame begins, seconds from the first of them, float64, shape (n,): the times of
        the dataset's frames.
    level
        Last reading then, lx by a meter, mean luminance (0 to 1) by pictures, float64, shape (n,);
        NaN: none, or in a gap of the readings (`Light`).
    period_s
        Seconds from the last change from bright to dark to the end of the frame, float64, shape
        (n,). NaN: the eyes are adapted, or it is not known.
    is_known
        Whether a change would be known, bool, shape (n,): not before there were readings for long
        enough without a gap, nor after they have ended.
    change_s
        When it became dark, on the same axis as `time_s`, float64, ascending.
    source
        What told how bright it was.
    simulated_s
        Which of the changes never was; None: all were.
    is_simulated
        Frames whose period runs from that one, bool, shape (n,); None: no frame's does.
    """

    time_s: NDArray[np.float64]
    level: NDArray[np.float64]
    period_s: NDArray[np.float64]
    is_known: NDArray[np.bool_]
    change_s: NDArray[np.float64]
    source: LightSource
    simulated_s: float | None = None
    is_simulated: NDArray[np.bool_] | None = None

    @property
    def seen_s(self) -> NDArray[np.float64]:
        """Periods in which adapted eyes are those of long ago, inf; NaN: not known."""
        return np.where(self.is_known & np.isnan(self.period_s), np.inf, self.period_s)


def adaptation_clock(
    light: Light | None,
    frame: NDArray[np.int64],
    fps: float,
    settings: LightSettings | None = None,
) -> AdaptationClock:
    """Light and adaptation in the frames of a recording.

    Parameters
    ----------
    light
        Readings over the recording, with times from frame 0; None: nothing is known of the light.
    frame
        Numbers of its evaluated frames, int64, ascending, shape (n,).
    fps
        Frames per second.
    settings
        What counts as a change; None: our defaults.
    """
    settings = settings or LightSettings()
    light = light or Light(np.empty(0), np.empty(0), LightSource.PICTURE)
    changes = changes_of(light, settings)
    begin_s, end_s = frame / fps, (frame + 1) / fps
    since_s = light.since_s(begin_s)
    period_s = changes.period_s(end_s)
    # what was before a gap may have ended in it
    period_s = np.where(end_s - period_s >= since_s, period_s, np.nan)
    is_in_time = begin_s >= since_s + settings.bright_for_s - SAME_S
    first_s = begin_s[0] if len(frame) else 0.0
    return AdaptationClock(
        (frame - frame[:1].sum()) / fps,  # as a dataset says it
        light.at(begin_s),
        period_s,
        is_in_time | ~np.isnan(period_s),
        changes.start_s - first_s,
        light.source,
    )


def with_change(clock: AdaptationClock, fps: float, change_s: float) -> AdaptationClock:
    """The clock as it would be, had it become dark at `change_s`, too.

    It runs from there until the next real change; that one's end does not bring it back. The light
    stays what it was: nobody knows how bright it would have been.

    Parameters
    ----------
    fps
        Frames per second.
    change_s
        Seconds from the first frame, as `clock.time_s`.
    """
    end_s = clock.time_s + 1 / fps
    period_s, is_simulated = period_after(clock.period_s, end_s, change_s, real_s=clock.change_s)
    times = np.sort(np.append(clock.change_s, change_s))
    return replace(
        clock,
        period_s=period_s,
        is_known=clock.is_known | is_simulated,
        change_s=times,
        simulated_s=change_s,
        is_simulated=is_simulated,
    )


def period_after(
    period_s: NDArray[np.float64],
    end_s: NDArray[np.float64],
    change_s: float,
    *,
    real_s: NDArray[np.float64] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Adaptation periods had it become dark at `change_s`, and which of them run from then.

    Frames that end before or at the change keep theirs; so do all from the next real change on,
    also where the light is back.

    Parameters
    ----------
    period_s
        As they are, seconds, NaN none, float64, shape (n,).
    end_s
        When the frames end, on the axis of `change_s`, seconds, float64, shape (n,).
    real_s
        When it really became dark, on that axis, float64; None: only what the periods say of it.
    """
    since_s = Changes(np.array([change_s]), np.array([np.nan])).period_s(end_s)
    changes_s = np.append(end_s - period_s, [] if real_s is None else real_s)
    next_s = np.min(changes_s, where=changes_s > change_s + SAME_S, initial=np.inf)
    is_simulated = np.isfinite(since_s) & (end_s <= next_s + SAME_S)
    return np.where(is_simulated, since_s, period_s), is_simulated
