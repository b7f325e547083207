"""Changes from bright to dark, and the time that the driver's eyes had to adapt in each frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.dataset.schema import SAME_S
from nvcore.subjects.driver.illumination.kernels import find_changes
from nvcore.subjects.driver.illumination.meter import PICTURE_LEAST, Light, LightSource
from nvcore.subjects.driver.illumination.shapes import check_ranges

if TYPE_CHECKING:
    from pandas.core.window import Rolling

_APART_S: Final = 1000.0
"""Extra length of each gap for windows over readings. It exceeds the width of any window."""


_RANGES: Final = {
    "drop_factor": (1.1, 1e6),
    "picture_drop_factor": (1.1, 1e6),
    "within_s": (0.0, 60.0),
    "bright_for_s": (0.0, 600.0),
    "smooth_s": (0.0, 10.0),
    "least_lux": (1e-6, 1e5),
}


@dataclass(frozen=True, kw_only=True)
class LightSettings:
    """Criteria for a change of the light from bright to dark. All of them are our choice.

    Attributes
    ----------
    drop_factor
        Minimum factor by which the light of a meter drops, for example 10 from 1,000 lx to 100 lx.
        (In the paper's experiment it drops from 1,000 lx to 10 lx.)
    picture_drop_factor
        Minimum factor by which the mean luminance of the picture drops, if it replaces a light
        meter. It is lower, because the camera's exposure follows the light.
    within_s
        Time within which the light drops, s. Consecutive readings may be further apart.
    bright_for_s
        Minimum duration of bright light before the change, s. Eyes do not adapt to shorter light,
        such as an oncoming lamp. Light must return for the same time to end the adaptation.
    smooth_s
        Width of the running median that removes flicker and single shadows, s.
    least_lux
        Minimum for readings of a light meter. Lower ones are raised to it.
    """

    drop_factor: float = 10.0
    picture_drop_factor: float = 3.0
    within_s: float = 2.0
    bright_for_s: float = 3.0
    smooth_s: float = 0.5
    least_lux: float = 0.1

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES)


@dataclass(frozen=True)
class Changes:
    """Changes from bright to dark in a recording.

    Attributes
    ----------
    start_s
        Times at which it had become dark, seconds from frame 0, float64, ascending, shape (n,).
    end_s
        Times at which the light was back. NaN if it did not come back before the next change, the
        end of the readings or a gap.
    """

    start_s: NDArray[np.float64]
    end_s: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.start_s)

    def period_s(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the seconds since the last change at these times, float64, shape (n,).

        NaN before the first change, and from the return of the light until the next change: the
        eyes are then adapted as far as known.
        `nvcore.subjects.driver.illumination.clock.adaptation_clock` accounts for gaps and the end
        of the readings. At the exact time of a change, the previous state still counts, because a
        frame that ends then lies wholly before it.
        """
        time_s = np.asarray(time_s, np.float64)
        last = np.searchsorted(self.start_s, time_s - SAME_S, side="left") - 1
        period_s = np.full(len(time_s), np.nan)
        after = np.flatnonzero(last >= 0)
        start_s, end_s = self.start_s[last[after]], self.end_s[last[after]]
        is_over = time_s[after] > end_s + SAME_S  # false if the end is NaN
        period_s[after] = np.where(is_over, np.nan, time_s[after] - start_s)
        return period_s


def changes_of(light: Light, settings: LightSettings) -> Changes:
    """Find the times at which it became dark, and at which the light was back.

    Readings are smoothed by a running median. It has become dark if the light is below its former
    level by the factor. The former level is the highest that was held for `bright_for_s` without a
    break, at most `within_s` ago, or at the previous reading if that is longer ago. The light is
    back when it rises by the factor above the darkest reading since, and stays there for
    `bright_for_s`.

    The median and the minimum over `bright_for_s` remove flicker. Entering a tunnel is a change.
    Leaving it is no change and ends the adaptation. An oncoming lamp starts or ends an adaptation
    only if it shines for longer than `bright_for_s`. No change is found in the first `bright_for_s`
    of the readings or after a gap, because the adaptation before is unknown.

    Parameters
    ----------
    light
        Readings of a light meter, or of pictures. Each source has its own factor and minimum level.
    settings
        Criteria for a change.

    Returns
    -------
    Changes, ascending. There are none without readings.

    Examples
    --------
    Four seconds of 1,000 lx, then 10 lx for three:

    >>> time_s = np.arange(0, 7, 0.1)
    >>> light = Light(time_s, np.where(time_s < 3.95, 1000.0, 10.0))
    >>> changes_of(light, LightSettings()).start_s.round(3).tolist()
    [4.0]
    """
    if not len(light.time_s):
        return Changes(np.empty(0), np.empty(0))
    is_meter = light.source is LightSource.METER
    level = _smooth(light, settings.smooth_s)
    level = np.maximum(level, settings.least_lux if is_meter else PICTURE_LEAST)
    start, end = np.empty((2, len(level)), np.int64)
    n_changes = find_changes(
        light.time_s,
        level,
        _held(light, level, settings.bright_for_s),
        light.is_first,
        settings.drop_factor if is_meter else settings.picture_drop_factor,
        settings.within_s,
        settings.bright_for_s,
        start,
        end,
    )
    start, end = start[:n_changes], end[:n_changes]
    return Changes(light.time_s[start], np.where(end >= 0, light.time_s[end], np.nan))


def _smooth(light: Light, width_s: float) -> NDArray[np.float64]:
    """Return the median of the readings within half a width of each reading."""
    if width_s <= 0:
        return light.level
    return np.asarray(_windows(light, light.level, width_s, center=True).median(), np.float64)


def _held(light: Light, level: NDArray[np.float64], width_s: float) -> NDArray[np.float64]:
    """Return the minimum level over the last seconds, NaN if the readings cover less."""
    if width_s <= 0:
        return level
    is_known = light.time_s - light.since_s(light.time_s) >= width_s * (1 - 1e-9)
    return np.where(is_known, _windows(light, level, width_s).min().to_numpy(), np.nan)


def _windows(
    light: Light, level: NDArray[np.float64], width_s: float, *, center: bool = False
) -> Rolling[pd.Series[float]]:
    """Return rolling windows over levels by time that never span a gap."""
    passed_s = light.time_s - light.time_s[0] + _APART_S * (np.cumsum(light.is_first) - 1)
    levels = pd.Series(level, index=pd.to_timedelta(passed_s, unit="s"))
    return levels.rolling(pd.Timedelta(seconds=width_s), center=center, closed="both")


@dataclass(frozen=True, eq=False)
class AdaptationClock:
    """Light and adaptation in the evaluated frames of a recording.

    Attributes
    ----------
    time_s
        Start of each frame, seconds from the first frame, float64, shape (n,), as in the dataset.
    level
        Last reading at that time, lx for a meter, mean luminance (0 to 1) for pictures, float64,
        shape (n,). NaN without a reading or in a gap (`Light`).
    period_s
        Seconds from the last change from bright to dark to the end of the frame, float64, shape
        (n,). NaN: the eyes are adapted, or it is unknown.
    is_known
        Whether a change would be known, bool, shape (n,). False until the readings have lasted long
        enough without a gap, and after their end.
    change_s
        Times at which it became dark, on the same axis as `time_s`, float64, ascending.
    source
        Source of the brightness.
    simulated_s
        Time of the simulated change. None: all changes are real.
    is_simulated
        Frames whose period runs from the simulated change, bool, shape (n,). None: no frame's does.
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
        """Periods, with inf for eyes known to be adapted, and NaN for unknown."""
        return np.where(self.is_known & np.isnan(self.period_s), np.inf, self.period_s)


def adaptation_clock(
    light: Light | None, frame: NDArray[np.int64], fps: float, settings: LightSettings | None = None
) -> AdaptationClock:
    """Compute light and adaptation in the frames of a recording.

    Parameters
    ----------
    light
        Readings over the recording, with times from frame 0. None: the light is unknown.
    frame
        Numbers of the evaluated frames, int64, ascending, shape (n,).
    fps
        Frames per second.
    settings
        Criteria for a change. None: our defaults.
    """
    settings = settings or LightSettings()
    light = light or Light(np.empty(0), np.empty(0), LightSource.PICTURE)
    changes = changes_of(light, settings)
    begin_s, end_s = frame / fps, (frame + 1) / fps
    since_s = light.since_s(begin_s)
    period_s = changes.period_s(end_s)
    # a change before a gap may have ended within it
    period_s = np.where(end_s - period_s >= since_s, period_s, np.nan)
    is_in_time = begin_s >= since_s + settings.bright_for_s - SAME_S
    first_s = begin_s[0] if len(frame) else 0.0
    return AdaptationClock(
        (frame - frame[:1].sum()) / fps,  # same rounding as in a dataset
        light.at(begin_s),
        period_s,
        is_in_time | ~np.isnan(period_s),
        changes.start_s - first_s,
        light.source,
    )


def with_change(clock: AdaptationClock, fps: float, change_s: float) -> AdaptationClock:
    """Return the clock as if it had also become dark at `change_s`.

    The simulated adaptation lasts until the next real change, and does not resume when the light is
    back after that. The light stays the same, since its simulated level is unknown.

    Parameters
    ----------
    fps
        Frames per second.
    change_s
        Time of the simulated change in seconds from the first frame, as in `clock.time_s`.
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
    """Return periods as if it had become dark at `change_s`, and a mask of the changed ones.

    Frames that end at or before the change keep their periods. So do all frames from the next real
    change on, even after the light is back.

    Parameters
    ----------
    period_s
        Real periods, seconds, NaN for none, float64, shape (n,).
    end_s
        Ends of the frames on the axis of `change_s`, seconds, float64, shape (n,).
    real_s
        Times of real changes on that axis, float64. None: derive them from the periods.
    """
    since_s = Changes(np.array([change_s]), np.array([np.nan])).period_s(end_s)
    changes_s = np.append(end_s - period_s, [] if real_s is None else real_s)
    next_s = np.min(changes_s, where=changes_s > change_s + SAME_S, initial=np.inf)
    is_simulated = np.isfinite(since_s) & (end_s <= next_s + SAME_S)
    return np.where(is_simulated, since_s, period_s), is_simulated
