"""Which frames of a recording are evaluated, and why."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import numpy as np

from nvcore.errors import FormatError, InputError, MissingFactError
from nvcore.readers.seqinfo import MAX_FRAMES
from nvcore.session import is_frame_range

MIN_SAMPLED: Final = 8
"""Annotated frames from which a common step between them is taken for regular sampling."""


def parse_frames(text: str, folder: Path) -> np.ndarray:
    """Frame numbers from ``first:last``, ``first:last:step``, or a file with one number a line.

    Returns
    -------
    Sorted, unique, int64.

    Raises
    ------
    InputError
        If the range is empty or too long, or the file cannot be opened.
    FormatError
        With the line that is no whole number.
    """
    if is_frame_range(text):
        first, last, step = ([int(part) for part in text.split(":")] + [1])[:3]
        if step < 1 or last < first:
            raise InputError(
                f"frames {text!r}: expected first:last[:step] with last >= first and step >= 1"
            )
        if (last - first) // step >= MAX_FRAMES:
            raise InputError(f"frames {text!r}: expected at most {MAX_FRAMES} frames")
        return np.arange(first, last + 1, step)
    path = folder / text
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, ValueError) as error:  # ValueError: not UTF-8, or a name that cannot be
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise InputError(
            "cannot be read as a frame list; expected first:last[:step], or a text file with one "
            f"frame number a line ({reason})",
            file=text,
        ) from error
    numbers = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        if re.fullmatch(r"\s*-?\d{1,15}\s*", line) is None:
            raise FormatError(
                f"expected a frame number, found {line[:40]!r}", file=path.name, line=number
            )
        numbers.append(int(line))
    if not numbers:
        raise InputError("holds no frame number", file=text)
    return np.unique(np.array(numbers, dtype=np.int64))


def nth(step: int) -> str:
    """The step as an ordinal number: ``2nd``, ``20th``."""
    ending = {1: "st", 2: "nd", 3: "rd"}.get(step % 10 if step // 10 % 10 != 1 else 0, "th")
    return f"{step}{ending}"


def infer_frames(annotated: np.ndarray) -> tuple[np.ndarray, str]:
    """Evaluated frames of a recording from the frames that have truth, and the reason.

    Every frame from the first to the last annotated one; or every n-th, where all annotated
    frames lie a multiple of n apart (n > 1, at least `MIN_SAMPLED` of them).

    Parameters
    ----------
    annotated
        Frame numbers with truth, ignored boxes included; sorted, unique, not empty.

    Raises
    ------
    MissingFactError
        If that would be more frames than any recording has.
    """
    first, last = int(annotated[0]), int(annotated[-1])
    step = int(np.gcd.reduce(np.diff(annotated))) if len(annotated) >= MIN_SAMPLED else 1
    if (last - first) // step >= MAX_FRAMES:
        raise MissingFactError(
            f"the truth reaches from frame {first} to {last}, more than {MAX_FRAMES} frames; "
            "correct the frame numbers, or give the evaluated frames with --frames"
        )
    if step > 1:
        reason = (
            f"every {nth(step)} frame from {first} to {last}: annotation is sampled at that step"
        )
        return np.arange(first, last + 1, step), reason
    return np.arange(
        first, last + 1
    ), f"every frame from the first to the last annotated, {first} to {last}"
