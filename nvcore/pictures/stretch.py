"""Grey levels for display: dim night pictures and 16-bit pictures become visible 8-bit ones."""

from __future__ import annotations

import math
from base64 import b64encode
from typing import Final, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.errors import ParameterError
from nvcore.pictures.base import Picture

_SAMPLED: Final = 1 << 16
"""Approximate number of pixels sampled for the percentiles."""


def stretch(picture: Picture, lo: float = 0.0, hi: float = 100.0) -> NDArray[np.uint8]:
    """The picture with the grey levels between two percentiles spread over 0..255.

    An 8-bit picture with ``lo`` 0 and ``hi`` 100 stays as it is; a 16-bit one is spread from its
    least to its greatest value. Colours are spread together, so that hues stay. Where both
    percentiles are the same value, that becomes 128, what is darker 0 and what is brighter 255.

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
    low = float(np.percentile(sample, lo)) if lo > 0 else float(picture.min())
    high = float(np.percentile(sample, hi)) if hi < 100 else float(picture.max())
    levels = np.arange(np.iinfo(picture.dtype).max + 1, dtype=np.float64)
    if high > low:
        spread = np.round((levels - low) * (255 / (high - low)))
    else:
        spread = np.where(levels < low, 0, np.where(levels > low, 255, 128))
    table = np.clip(spread, 0, 255).astype(np.uint8)
    return table[picture]


def jpeg(picture: Picture, lo: float = 0.0, hi: float = 100.0, quality: int = 85) -> bytes:
    """The picture, stretched (`stretch`), as JPEG.

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
    """An address that holds the encoded picture: what shows it has nothing left to fetch."""
    return f"data:image/{kind};base64,{b64encode(content).decode()}"


def png(picture: Picture) -> bytes:
    """The picture as PNG, without loss."""
    return _encode(".png", picture, [])


def _encode(ending: str, picture: Picture, options: list[int]) -> bytes:
    bgr = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    is_encoded, content = cv2.imencode(ending, bgr, options)
    assert is_encoded, (ending, picture.shape, picture.dtype)
    return bytes(content)
