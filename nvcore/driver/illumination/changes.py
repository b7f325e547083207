"""Changes from bright to dark, and how long the driver's eyes have had to adapt."""

from __future__ import annotations

from dataclasses import dataclass
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
