"""Changes from bright to dark, and how long the driver's eyes have had to adapt in each frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.driver.illumination.kernels import find_changes
from nvcore.driver.illumination.meter import PICTURE_LEAST, Light, LightSource
from nvcore.driver.shapes import check_ranges
from nvcore.schema import SAME_S

if TYPE_CHECKING:
    from pandas.core.window import Rolling

_APART_S: Final = 1000.0
"""Added to the length of each gap for windows over readings: more than any is wide."""


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
        By so much the light of a light meter falls at least: 1,000 lx to 100 lx with 10. (In the
        paper's experiment it falls from 1,000 lx to 10 lx.)
    picture_drop_factor
        By so much the mean luminance of the picture falls, where it stands in for a light meter;
        less, as the camera's exposure follows the light.
    within_s
        In so many seconds, or from one reading to the next where these are further apart.
    bright_for_s
        So long the light must have been there before: what passes sooner, such as an oncoming
        lamp, is not what the eye was adapted to. After a change, the light must be back for as
        long to end the adaptation.
    smooth_s
        Width of the running median that flicker and single shadows are taken out with.
    least_lux
        What a light meter reads below that counts as that.
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
    """Changes from bright to dark of a recording.

    Attributes
    ----------
    start_s
        When it had become dark, seconds from frame 0, float64, ascending, shape (n,).
    end_s
        When the light was back; NaN: not before the next change, not before the readings end or
        have a gap, or not at all.
    """

    start_s: NDArray[np.float64]
    end_s: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.start_s)

    def period_s(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Seconds since the last change at these times, float64, shape (n,).

        NaN until the first, and after the light is back until the next: the eyes are then adapted,
        as far as is known. That readings end, or have a gap, is for
        `nvcore.driver.illumination.clock.adaptation_clock` to know. The moment of a change still
        belongs to what was before it: a frame that ends there lies wholly before.
        """
        time_s = np.asarray(time_s, np.float64)
        last = np.searchsorted(self.start_s, time_s - SAME_S, side="left") - 1
        period_s = np.full(len(time_s), np.nan)
        after = np.flatnonzero(last >= 0)
        start_s, end_s = self.start_s[last[after]], self.end_s[last[after]]
        is_over = time_s[after] > end_s + SAME_S  # never where the end is NaN
        period_s[after] = np.where(is_over, np.nan, time_s[after] - start_s)
        return period_s


def changes_of(light: Light, settings: LightSettings) -> Changes:
    """When it became dark, and when the light was back.

    Readings are smoothed by a running median. It has become dark where the light is below what it
    was by the factor: the most that it had been for `bright_for_s` without a break, up to
    `within_s` ago, or at the reading before where that is longer ago. The light is back where it
    rises by the factor above the darkest since, and stays so for `bright_for_s`.

    Flicker is taken out by the median, and by the least of `bright_for_s`. A tunnel entered is a
    change, a tunnel left is none and ends the adaptation. An oncoming lamp neither begins nor ends
    one, unless it shines for longer than `bright_for_s`. The first `bright_for_s` of the readings,
    and of those after a gap, are needed to know what the eye is adapted to.

    Parameters
    ----------
    light
        Readings of a light meter, or of pictures: each has its own factor and least level.
    settings
        What counts as a change.

    Returns
    -------
    Changes, ascending; none without readings.

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
    """Median of the readings at most half a width away."""
    if width_s <= 0:
        return light.level
    return np.asarray(_windows(light, light.level, width_s, center=True).median(), np.float64)


def _held(light: Light, level: NDArray[np.float64], width_s: float) -> NDArray[np.float64]:
    """Least level of the last seconds; NaN where the readings, or their stretch, began later."""
    if width_s <= 0:
        return level
    is_known = light.time_s - light.since_s(light.time_s) >= width_s * (1 - 1e-9)
    return np.where(is_known, _windows(light, level, width_s).min().to_numpy(), np.nan)


def _windows(
    light: Light, level: NDArray[np.float64], width_s: float, *, center: bool = False
) -> Rolling[pd.Series[float]]:
    """Windows over levels by time, with gaps so long that no window reaches over one."""
    passed_s = light.time_s - light.time_s[0] + _APART_S * (np.cumsum(light.is_first) - 1)
    levels = pd.Series(level, index=pd.to_timedelta(passed_s, unit="s"))
    return levels.rolling(pd.Timedelta(seconds=width_s), center=center, closed="both")


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
