"""Facts that a session gives: what they may be, and how sizes and frames are written."""

from __future__ import annotations

import math
import re

from nvcore.errors import SessionError
from nvcore.settings import MAX_FPS, MIN_FPS


def check_positive(name: str, value: float | None) -> None:
    """Raise SessionError unless the value is None or a positive, finite number."""
    if value is not None and not 0 < value < math.inf:
        raise SessionError(f"{name}: expected a positive number, found {value:g}")


def check_rate(fps: float | None) -> None:
    """Raise SessionError unless the value is None or a frame rate, frames per second."""
    if fps is not None and not MIN_FPS <= fps <= MAX_FPS:
        raise SessionError(f"fps: expected a number from {MIN_FPS:g} to {MAX_FPS:g}, found {fps:g}")


def check_finite(name: str, value: float | None) -> None:
    """Raise SessionError unless the value is None or a finite number."""
    if value is not None and not math.isfinite(value):
        raise SessionError(f"{name}: expected a finite number, found {value:g}")


def check_path(name: str, text: str | None) -> None:
    """Raise SessionError where the text can be no path."""
    # other control characters may be in the names of files, and are shown harmlessly
    if text is not None and "\0" in text:
        raise SessionError(f"{name}: expected a path, found one with a NUL: {text!r}")


def parse_size(text: str) -> tuple[int, int]:
    """Width and height from ``640x480``.

    Raises
    ------
    ValueError
        If the text is not of that form.
    """
    match = re.fullmatch(r"\s*(\d{1,6})\s*[xX×]\s*(\d{1,6})\s*", text)
    if match is None or not int(match[1]) or not int(match[2]):
        raise ValueError(f"expected a size such as 640x480, got {text!r}")
    return int(match[1]), int(match[2])


def is_frame_range(frames: str) -> bool:
    """Whether the text is ``first:last`` or ``first:last:step``, not the name of a file."""
    return re.fullmatch(r"\s*-?\d{1,15}\s*:\s*-?\d{1,15}\s*(:\s*\d{1,15}\s*)?", frames) is not None
