"""Filter a picture to look as drivers see it in the seconds after a change of light.

Contrast and acuity drop at the change and recover exponentially while the eyes adapt:

- *Contrast.* In octave bands (a Laplacian pyramid), differences from the surround below a
  threshold disappear, and larger ones shrink by the threshold. Colours fade with the contrast.
- *Acuity.* Details smaller than a visual angle blur.

The picture is meant for people to look at. It illustrates what the estimators
(`nvcore.subjects.driver.estimators`) model, but they do not use it, and nobody was measured for it.
The form of the model is published, its numbers are our choice (`FilterSettings`).

References
----------
R. M. Boynton, N. D. Miller: Visual performance under conditions of transitional adaptation,
Illuminating Engineering 58 (1963). Contrast thresholds rise at once when the light changes, and
fall again within seconds.

E. Peli: Contrast in complex images, Journal of the Optical Society of America A 7 (1990),
2032-2040. Contrast by octave, relative to the local mean, with a threshold for each place.

P. J. Burt, E. H. Adelson: The Laplacian pyramid as a compact image code, IEEE Transactions on
Communications 31 (1983), 532-540.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import ParameterError
from nvcore.common.extras import needs
from nvcore.subjects.driver.illumination.shapes import check_picture, check_ranges

with needs("driver", "the picture as the driver sees it needs"):
    import cv2

OCTAVES: Final = 6
"""Number of bands of the pyramid. The finest one has single pixels."""
LEAST_SIGMA_PX: Final = 0.2
"""Minimum blur. Less is treated as none."""
MOST_SIGMA_PX: Final = 100.0
"""Maximum blur. More would take minutes, and nothing is left to see."""
LEAST_THRESHOLD: Final = 1 / 1024
"""Minimum threshold. A smaller one changes no grey level and is treated as none."""
_RANGES: Final = {
    "threshold": (0.0, 100.0),
    "threshold_decay_s": (0.01, 3600.0),
    "blur_arcmin": (0.0, 600.0),
    "blur_decay_s": (0.01, 3600.0),
    "width_degrees": (1.0, 360.0),
    "gamma": (0.1, 10.0),
    "veil_level": (0.0, 255.0),
}


@dataclass(frozen=True, kw_only=True)
class FilterSettings:
    """Settings of the filter: loss of contrast and acuity, and their recovery.

    All values are our choice.

    Attributes
    ----------
    threshold
        Contrast that disappears at the change: difference of light relative to the surround.
    threshold_decay_s
        Time in which the threshold falls to 1/e. With 1.5 s, a twentieth of it is left after 4.5 s,
        when detectability stops rising in the paper.
    blur_arcmin
        Visual angle of the details that blur at the change, minutes of arc.
    blur_decay_s
        Time in which that angle falls to 1/e.
    width_degrees
        Horizontal angle of view of the picture, degrees.
    gamma
        Gamma of the display: light is the grey level to this power.
    veil_level
        Grey levels of stray light in the eye, which removes contrast in black areas.
    """

    threshold: float = 0.6
    threshold_decay_s: float = 1.5
    blur_arcmin: float = 15.0
    blur_decay_s: float = 1.5
    width_degrees: float = 48.0
    gamma: float = 2.2
    veil_level: float = 4.0

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES)


def contrast_threshold(period_s: float, settings: FilterSettings | None = None) -> float:
    """Return the contrast below which details vanish `period_s` after the change, 0 for NaN."""
    settings = settings or FilterSettings()
    return settings.threshold * _left(period_s, settings.threshold_decay_s)


def blur_px(period_s: float, width_px: int, settings: FilterSettings | None = None) -> float:
    """Return the SD of the blur in px `period_s` after the change, 0 for NaN.

    This is half the angle of the details that blur: bars of that width keep 0.3 of their contrast.
    The maximum is `MOST_SIGMA_PX`.

    Parameters
    ----------
    width_px
        Width of the picture. The blur in px is proportional to it.
    """
    settings = settings or FilterSettings()
    angle = settings.blur_arcmin * _left(period_s, settings.blur_decay_s)
    return min(angle / 60 * width_px / settings.width_degrees / 2, MOST_SIGMA_PX)


def as_the_driver_sees(
    picture: NDArray[np.uint8], period_s: float, settings: FilterSettings | None = None
) -> NDArray[np.uint8]:
    """Return the picture as the driver sees it `period_s` after a change from bright to dark.

    Parameters
    ----------
    picture
        Visible-light picture, grey (h, w) or RGB (h, w, 3), uint8.
    period_s
        Adaptation period, seconds. NaN or infinite: the eyes are adapted.
    settings
        Settings of the filter. None: our defaults.

    Returns
    -------
    uint8, of the same shape. The picture itself if the eyes are adapted.

    Raises
    ------
    ParameterError
        If the period is negative, or the picture has no pixel or another shape or type.

    Examples
    --------
    >>> picture = np.tile(np.array([100, 104], np.uint8), (64, 32))
    >>> int(np.ptp(as_the_driver_sees(picture, 0.5))), int(np.ptp(as_the_driver_sees(picture, 60)))
    (0, 4)
    """
    check_picture(picture)
    settings = settings or FilterSettings()
    threshold = contrast_threshold(period_s, settings)
    sigma = blur_px(period_s, picture.shape[1], settings)
    if sigma >= LEAST_SIGMA_PX:
        picture = _uint8(cv2.GaussianBlur(picture, (0, 0), sigma))
    if threshold < LEAST_THRESHOLD:
        return picture
    grey = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    levels = grey.astype(np.float32)
    seen = _above_threshold(levels, threshold, settings)
    if picture.ndim == 2:
        return _uint8(cv2.convertScaleAbs(np.maximum(seen, 0)))
    colour = max(1 - threshold, 0.0)
    rest = np.asarray(seen - colour * levels, np.float32)
    return _uint8(cv2.addWeighted(picture, colour, cv2.merge([rest] * 3), 1, 0, dtype=cv2.CV_8U))


def _left(period_s: float, decay_s: float) -> float:
    """Return the share of the loss that remains after `period_s`, 0 for NaN."""
    if math.isnan(period_s):
        return 0.0
    if period_s < 0:
        raise ParameterError(f"period: expected seconds after the change, found {period_s:g}")
    return math.exp(-period_s / decay_s)


def _above_threshold(
    levels: NDArray[np.float32], threshold: float, settings: FilterSettings
) -> NDArray[np.float32]:
    """Remove contrasts below the threshold from grey levels, float32.

    For small contrasts, the contrast of light is `gamma` times that of grey levels.
    """
    share = threshold / settings.gamma
    bands, means = [], []
    for _ in range(OCTAVES):
        if min(levels.shape) < 2:
            break
        smaller = cv2.pyrDown(levels)
        mean = cv2.pyrUp(smaller, dstsize=levels.shape[::-1])
        bands.append(levels - mean)
        means.append(mean)
        levels = np.asarray(smaller, np.float32)
    for band, mean in zip(bands[::-1], means[::-1], strict=True):
        least = (mean + np.float32(settings.veil_level)) * np.float32(share)
        seen = band - np.clip(band, -least, least)
        levels = np.asarray(cv2.pyrUp(levels, dstsize=band.shape[::-1]) + seen, np.float32)
    return levels


def _uint8(picture: object) -> NDArray[np.uint8]:
    return np.asarray(picture, np.uint8)
