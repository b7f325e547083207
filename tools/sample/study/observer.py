"""Simulated observer whose contrast sensitivity recovers after the light was turned down.

This is a model of whether somebody who looks at the middle of a picture sees its pedestrian within
half a second, `time_s` after the illumination fell from 1,000 to 10 lx. It compares the picture
with the same picture without the pedestrian, both seen through a contrast-sensitivity filter. It is
no substitute for people: nobody was asked, no parameter was fitted to people, and it knows neither
colour nor meaning. A bag that looks like a pedestrian is as visible to it.

Its parts are all published. Their combination is ours:

- Picture to light: sRGB, shown on a screen of `SCREEN_CD_M2` in 10 lx.
- Local band-limited contrast in octaves (Peli, "Contrast in complex images", J. Opt. Soc. Am. A 7,
  1990, 2032-2040).
- The luminance to which the eye is adapted `t` seconds after entering the dark. The slow part is
  the one used for tunnel lighting, `L(0) (1.9 + t)^-1.4` (CIE 88:2004, after Schreuder). The rest
  of `L(0)` fades exponentially with a time constant of `FAST_S` (a fast part comes first: Baker,
  J. Opt. Soc. Am. 43, 1953, 798-803; its form is ours). The excess over the picture's own
  luminance lies over the picture as an equivalent veiling light (Crawford, Proc. R. Soc. B 134,
  1947, 283-302).
- Contrast sensitivity by spatial frequency, luminance and size (Barten, "Formula for the contrast
  sensitivity of the human eye", Proc. SPIE 5294, 2004, 231-238).
- Away from the point of fixation, everything acts as if it were smaller by `1 + E / E2`
  (M-scaling; Virsu and Rovamo, Exp. Brain Res. 37, 1979, 475-494).
- The street's own contrast at the same place and frequency masks (Legge and Foley, J. Opt. Soc.
  Am. 70, 1980, 1458-1471).
- Differences are pooled over place and frequency with an exponent, and the chance of seeing rises
  with the sum by Quick's function (Quick, Kybernetik 16, 1974, 65-67). Observers who do not know
  where to look need several times the threshold (visibility level; Adrian, Lighting Res. Technol.
  21, 1989, 181-188).
- A visible pedestrian must also be picked out in one glance of 0.5 s. The smaller and the farther
  from the fixation, the less likely that is, in any light (critical height by M-scaling, again).

The constants of the last two steps, and the variation between people, are our choice. They make the
share of those who see rise over the first periods, as the paper reports, without ending at 1, and
let estimators of single periods do better than one for all from 3 s on (decision 053).
"""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.sample.camera import Floats
from tools.sample.visible.light import LUMA

PERIODS_S: Final = (0.5, 1.5, 3.0, 4.5, 6.0, 7.5)
"""Seconds from the change of light to the end of the picture."""
PIXELS_PER_DEGREE: Final = 40.0
"""Resolution such that 200 px are 5 degrees, as in the paper: 960 px, 22.6 cm wide, at 52 cm."""
SCREEN_CD_M2: Final = 110.0
BRIGHT_CD_M2: Final = 255.0
"""Luminance of a white wall in 1,000 lx."""
REFLECTED_CD_M2: Final = 0.13
"""Light reflected by the screen's glass in 10 lx."""
FAST_S: Final = 1.5
"""Time constant of the fast part of adaptation. (Our choice.)"""
E2_DEG: Final = 3.0
POOLING: Final = 3.0
CRITERION: Final = 7.0
"""Multiple of the threshold at which a pedestrian in an unknown place is seen. (Our choice.)"""
STEEPNESS: Final = 4.0
CRITICAL_DEG: Final = 0.4
PICKING: Final = 4.0
"""Exponent of the height relative to the critical height."""

_SIGMAS_PX: Final = (0.5, 1.0, 2.0, 4.0, 8.0)
_PEAK: Final = 0.153
"""Peak frequency of a difference of Gaussians of s and 2 s, cycles per pixel times s."""
_MARGIN_PX: Final = 40
_MASKING: Final = 0.7


def luminance(picture: NDArray[np.uint8]) -> Floats:
    """Return the screen luminance, cd/m2, of an sRGB picture of shape (height, width, 3)."""
    value = picture / 255.0
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return np.asarray(SCREEN_CD_M2 * (linear @ LUMA) + REFLECTED_CD_M2)


def adapted_luminance(time_s: float) -> float:
    """Return the luminance, cd/m2, to which the eye is adapted `time_s` after the change."""
    slow = (1.9 + time_s) ** -1.4
    fast = (1 - 1.9**-1.4) * np.exp(-time_s / FAST_S)
    return float(BRIGHT_CD_M2 * (slow + fast))


def sensitivity(frequency: Floats, luminance_cd_m2: Floats, size_deg: float) -> Floats:
    """Return the contrast sensitivity of the human eye (Barten 2004, the short formula).

    Parameters
    ----------
    frequency
        Cycles per degree.
    luminance_cd_m2
        Luminance of the adapting field, broadcast with `frequency`.
    size_deg
        Side of the target, degrees.
    """
    u = np.asarray(frequency, dtype=np.float64)
    optics = np.exp(-0.0016 * u**2 * (1 + 100 / luminance_cd_m2) ** 0.08)
    summation = 1 + 144 / size_deg**2 + 0.64 * u**2
    noise = 63 / np.asarray(luminance_cd_m2) ** 0.83 + 1 / (1 - np.exp(-0.02 * u**2))
    return np.asarray(5200 * optics / np.sqrt(summation * noise))


def visibility(
    picture: NDArray[np.uint8],
    empty: NDArray[np.uint8],
    box: tuple[float, float, float, float],
    fixation: tuple[float, float],
) -> Floats:
    """Return the visibility of the pedestrian as a multiple of the threshold, at each `PERIODS_S`.

    Parameters
    ----------
    picture, empty
        With and without the pedestrian, RGB, shape (height, width, 3).
    box
        x, y, w, h in pixels. It only gives position and size of the target.
    fixation
        Point of fixation, pixels.
    """
    x, y, w, h = box
    shrunk = 1 + eccentricity_deg(box, fixation) / E2_DEG
    size_deg = float(np.sqrt(w * h)) / PIXELS_PER_DEGREE / shrunk
    left, top = (max(int(v) - _MARGIN_PX, 0) for v in (x, y))
    part = np.s_[top : int(y + h) + _MARGIN_PX, left : int(x + w) + _MARGIN_PX]
    shown, street = luminance(picture)[part], luminance(empty)[part]
    mean = float(luminance(empty).mean())
    sums = np.zeros(len(PERIODS_S))
    for sigma in _SIGMAS_PX:
        frequency = np.array(_PEAK / sigma * PIXELS_PER_DEGREE * shrunk)
        shown_band, shown_mean = _band(shown, sigma)
        street_band, street_mean = _band(street, sigma)
        for step, time_s in enumerate(PERIODS_S):
            veil = max(adapted_luminance(time_s) - mean, 0.0)
            gain = sensitivity(frequency, street_mean + veil, size_deg)
            mask = np.abs(street_band) / (street_mean + veil) * gain
            target = shown_band / (shown_mean + veil) - street_band / (street_mean + veil)
            response = np.abs(target) * gain / (1 + mask**_MASKING)
            # Neighbouring pixels of a coarse band are not independent, so count places instead of
            # pixels.
            sums[step] += (response**POOLING).sum() / (2 * np.pi * (2 * sigma) ** 2)
    return np.asarray(sums ** (1 / POOLING))


def eccentricity_deg(
    box: tuple[float, float, float, float], fixation: tuple[float, float]
) -> float:
    """Return the angle between the fixation and the middle of a box."""
    x, y, w, h = box
    away = np.hypot(x + w / 2 - fixation[0], y + h / 2 - fixation[1])
    return float(away) / PIXELS_PER_DEGREE


def picking(box: tuple[float, float, float, float], fixation: tuple[float, float]) -> float:
    """Return the chance to pick out a visible pedestrian in one glance, 0 to 1, in any light."""
    critical = CRITICAL_DEG * (1 + eccentricity_deg(box, fixation) / E2_DEG)
    ratio = (box[3] / PIXELS_PER_DEGREE / critical) ** PICKING
    return float(ratio / (1 + ratio))


def seeing(visible: Floats, *, gain: float = 1.0) -> Floats:
    """Return the chance of seeing an object at `visible` times the threshold, 0 to 1.

    Parameters
    ----------
    gain
        Sensitivity of the observer relative to the model's.
    """
    return np.asarray(1 - np.exp(-((gain * visible / CRITERION) ** STEEPNESS)))


def _band(light: Floats, sigma: float) -> tuple[Floats, Floats]:
    """Return the band between blurs of `sigma` and twice it, and the mean around it."""
    fine = cv2.GaussianBlur(light, (0, 0), sigma)
    coarse = cv2.GaussianBlur(light, (0, 0), 2 * sigma)
    return np.asarray(fine - coarse), np.asarray(coarse)
