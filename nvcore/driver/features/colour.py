"""Tables by which the kernels turn RGB pixels into CIE L*a*b*.

The pictures are taken as sRGB (IEC 61966-2-1), white is D65: what a video or JPEG holds unless it
says otherwise.

References
----------
CIE 15:2004, Colorimetry (L*a*b*).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

_TO_XYZ: Final = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)  # fmt: skip
_CURVE_STEPS: Final = 1 << 11
_KNEE: Final = (6 / 29) ** 3


def _lines() -> NDArray[np.float64]:
    """The cube root of CIE L*a*b* and its straight end, as lines between equal steps of 0..1."""
    steps = np.arange(_CURVE_STEPS + 2)
    share = steps / _CURVE_STEPS
    straight = share / (3 * (6 / 29) ** 2) + 4 / 29
    value = np.where(share > _KNEE, np.cbrt(share), straight)
    slope = np.diff(value)
    return np.stack([value[:-1] - steps[:-1] * slope, slope], axis=1)


TO_PLACE: Final = _TO_XYZ / _TO_XYZ.sum(axis=1, keepdims=True) * _CURVE_STEPS
"""Linear RGB to X, Y, Z as places among the steps of `LINES`, white being the last; (3, 3)."""
LINES: Final = _lines()
"""Height at 0, and slope, of the curve's line at each step; L*, a*, b* are right to 0.01.

More steps would not fit the processor's first cache (32 kB).
"""


def lab_of(curved: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean L*, a*, b* from the means of the three curved values, shape (..., 3)."""
    x, y, z = np.moveaxis(curved, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)
