"""Grey levels for display, so that dim night pictures and 16-bit pictures become visible."""

from __future__ import annotations

import math
from base64 import b64encode
from typing import Any, Final, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import ParameterError
from nvcore.pictures.base import Picture

_MANY: Final = 0.002
_FEWEST: Final = 8
"""Share and number of pixels from which on an extreme value may stand for no measurement."""
_APART: Final = 3
STRETCH: Final = (0.5, 99.8)
"""Percentiles of the grey levels between which contrast is stretched by default."""
_SAMPLED: Final = 1 << 16
"""Approximate number of pixels sampled for the percentiles."""


def stretch(picture: Picture, lo: float = 0.0, hi: float = 100.0) -> NDArray[np.uint8]:
    """Spread the grey levels between two percentiles over 0..255.

    An 8-bit picture with ``lo`` 0 and ``hi`` 100 stays as it is. A 16-bit one is spread from its
    least to its greatest value, without those that stand for no measurement (`measured`), as of a
    masked border. Colours are spread together, so that hues stay. Where both percentiles are the
    same value, it becomes 128, darker values 0 and brighter ones 255.

    Parameters
    ----------
    picture
        (h, w) or (h, w, 3), uint8 or uint16.
    lo, hi
        Percentiles, 0..100, of a sample of the pixels.

    Raises
    ------
    ParameterError
        Unless ``0 <= lo < hi <= 100``.
    """
    if not 0 <= lo < hi <= 100:
        raise ParameterError(f"stretch: expected 0 <= low < high <= 100, got {lo:g} and {hi:g}")
    if picture.dtype == np.uint8 and lo == 0 and hi == 100:
        return picture
    step = max(1, math.ceil(math.sqrt(picture.shape[0] * picture.shape[1] / _SAMPLED)))
    sample = picture[::step, ::step]
    near = sample if picture.dtype == np.uint8 else measured(sample)
    whole = picture if near.size == sample.size else near
    low = float(np.percentile(near, lo)) if lo > 0 else float(whole.min())
    high = float(np.percentile(near, hi)) if hi < 100 else float(whole.max())
    levels = np.arange(np.iinfo(picture.dtype).max + 1, dtype=np.float64)
    if high > low:
        spread = np.round((levels - low) * (255 / (high - low)))
    else:
        spread = np.where(levels < low, 0, np.where(levels > low, 255, 128))
    table = np.clip(spread, 0, 255).astype(np.uint8)
    return table[picture]


def measured(values: NDArray[Any]) -> NDArray[Any]:
    """Drop a least or greatest value that stands for no measurement, such as -9999.

    Many pixels, yet no more than half, share it. It is 0 or less, or more than twice all others (of
    whole numbers the greatest there is), and further from them than `_APART` times their range.
    """
    for is_least in (True, False):
        extreme = float(values.min() if is_least else values.max())
        n_alike = int(np.count_nonzero(values == extreme))
        if not max(_FEWEST, _MANY * values.size) <= n_alike <= values.size / 2:
            continue
        others = values[values != extreme]
        nearest = float(others.min() if is_least else others.max())
        low, high = np.percentile(others, (0.5, 99.5))
        is_usual = extreme > 0 if is_least else extreme <= 2 * nearest
        if values.dtype.kind == "u" and not is_least:
            is_usual = extreme < np.iinfo(values.dtype).max
        if high > low and abs(nearest - extreme) > _APART * (high - low) and not is_usual:
            values = others
    return values


def jpeg(picture: Picture, lo: float = 0.0, hi: float = 100.0, quality: int = 85) -> bytes:
    """Encode the picture as JPEG after `stretch`.

    Parameters
    ----------
    quality
        1..100.

    Raises
    ------
    ParameterError
        As `stretch` does.
    """
    return _encode(".jpg", stretch(picture, lo, hi), [cv2.IMWRITE_JPEG_QUALITY, quality])


def picture_address(content: bytes, kind: Literal["jpeg", "png"] = "jpeg") -> str:
    """Return a data URL of the encoded picture."""
    return f"data:image/{kind};base64,{b64encode(content).decode()}"


def png(picture: Picture) -> bytes:
    """Encode the picture as PNG."""
    return _encode(".png", picture, [])


def _encode(ending: str, picture: Picture, options: list[int]) -> bytes:
    bgr = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    is_encoded, content = cv2.imencode(ending, bgr, options)
    assert is_encoded, (ending, picture.shape, picture.dtype)
    return bytes(content)
