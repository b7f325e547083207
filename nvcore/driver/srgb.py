"""The 8-bit values of pictures as intensities: sRGB (IEC 61966-2-1)."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray


def _linear() -> NDArray[np.float64]:
    share = np.arange(256) / 255
    bent: NDArray[np.float64] = ((share + 0.055) / 1.055) ** 2.4
    return np.where(share <= 0.04045, share / 12.92, bent)


LINEAR: Final = _linear()
"""Share of the greatest intensity by 8-bit value, shape (256,)."""
