"""Evaluated frames of a recording, and the reason for choosing them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError, MissingFactError
from nvcore.common.memory import SPARSE
from nvcore.common.wording import MOST_NAMED, listed, one_line
from nvcore.inputs.facts import FRAME_RANGE, frame_range, is_frame_range
from nvcore.inputs.readers.base import Reading, SourceFile
from nvcore.inputs.readers.meaning.values import MAX_FRAMES

MIN_SAMPLED: Final = 8
"""Smallest number of annotated frames whose common step counts as regular sampling."""
LONG: Final = 100_000
"""Frames of a recording, an hour at 28 Hz, from which on `SPARSE` holds."""
_LINE_ENDS: Final = tuple(end.encode() for end in "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029")
"""Where `str.splitlines` splits."""


def parse_frames(text: str, folder: Path, own: np.ndarray | None = None) -> np.ndarray:
    """Parse frame numbers from a range (`frame_range`) or a file with one number per line.

    Parameters
    ----------
    own
        Frames of the recording, sorted, int64, for a range that lacks an end. None: the range
        needs both ends.

    Returns
    -------
    Sorted, unique, int64. Empty if the range begins after the recording's end.

    Raises
    ------
    InputError
        If the range is empty or too long, or the file cannot be opened.
    FormatError
        If a line is not a whole number.
    """
    if is_frame_range(text):
        return _frames_in(text, own)
    file = SourceFile(folder / text, (folder / text).name)
    try:
        with file.open() as stream:
            content = stream.read()
        # checked before each line takes memory of its own
        if sum(map(content.count, _LINE_ENDS)) - content.count(b"\r\n") > MAX_FRAMES:
            raise InputError(f"expected at most {MAX_FRAMES} lines")
        lines = content.decode("utf-8-sig").splitlines()
    except (InputError, ValueError) as error:  # ValueError: not UTF-8, or a name that cannot be
        reason = error.message if isinstance(error, InputError) else "not UTF-8 text"
        raise InputError(
            f"cannot be read as a frame list; expected {FRAME_RANGE}, or a text file with "
            f"one frame number a line ({reason}){_meant(text)}",
            file=text,
        ) from error
    numbers = []
    for number, line in enumerate(lines, 1):
        if line.strip() and re.fullmatch(r"\s*-?\d{1,15}\s*", line) is None:
            raise file.fault(f"expected a frame number, found {line[:40]!r}", number)
        # int takes less for a space than str does
        numbers += [int(line.strip())] if line.strip() else []
    if not numbers:
        raise InputError("holds no frame number", file=text)
    return np.unique(np.array(numbers, dtype=np.int64))


def _meant(text: str) -> str:
    """Suggest a range such as 0:299 for text such as 0-299, or return an empty text."""
    ends = re.fullmatch(r"(\d{1,15})\s*(?:-|\.\.+|to)\s*(\d{1,15})", text.rpartition("/")[2])
    return "" if ends is None else f"; did you mean {ends[1]}:{ends[2]}?"


def _frames_in(text: str, own: np.ndarray | None) -> np.ndarray:
    """Return the frames of a range, as `parse_frames` does."""
    chosen = frame_range(text)
    first, last = chosen.first, chosen.last
    if first is None or last is None:
        if own is None:
            raise InputError(f"frames {text!r}: expected both ends here, such as 0:299")
        if not len(own):
            return own
        first = int(own[0]) if first is None else first
        last = int(own[-1]) if last is None else last
    if (last - first) // chosen.step >= MAX_FRAMES:
        raise InputError(f"frames {text!r}: expected at most {MAX_FRAMES} frames")
    return np.arange(first, last + 1, chosen.step)


def frames_there(frames: Mapping[str, np.ndarray]) -> str:
    """Describe the frames that recordings have, for an error about other frames.

    Parameters
    ----------
    frames
        Sorted frame numbers of each recording, by its name.
    """
    names_of: dict[str, list[str]] = {}
    for name, own in frames.items():
        if len(own):
            names_of.setdefault(f"{own[0]} to {own[-1]}", []).append(one_line(name))
    texts = [
        f"{listed(names, most=MOST_NAMED)} {'has' if len(names) == 1 else 'have'} frames {span}"
        for span, names in names_of.items()
    ]
    return listed(texts, most=MOST_NAMED) or "the recordings have no frames"


def nth(step: int) -> str:
    """Format the step as an ordinal number: ``2nd``, ``20th``."""
    ending = {1: "st", 2: "nd", 3: "rd"}.get(step % 10 if step // 10 % 10 != 1 else 0, "th")
    return f"{step}{ending}"


def infer_frames(annotated: np.ndarray) -> tuple[np.ndarray, str]:
    """Infer evaluated frames of a recording from the frames that have truth, with the reason.

    These are all frames from the first to the last annotated one, or every n-th if all annotated
    frames are a multiple of n apart (n > 1, at least `MIN_SAMPLED` of them).

    Parameters
    ----------
    annotated
        Frame numbers with truth (including ignored boxes), sorted, unique, not empty.

    Raises
    ------
    MissingFactError
        If there would be more frames than any recording has, or few of them are annotated.
    """
    first, last = int(annotated[0]), int(annotated[-1])
    step = int(np.gcd.reduce(np.diff(annotated))) if len(annotated) >= MIN_SAMPLED else 1
    n_frames = (last - first) // step + 1
    if n_frames > max(LONG, SPARSE * len(annotated)) or n_frames > MAX_FRAMES:
        raise MissingFactError(
            f"the truth reaches from frame {first} to {last}, and has boxes in {len(annotated)} "
            f"frames; expected boxes in at least one of {SPARSE}, and at most {MAX_FRAMES} frames. "
            "Correct the frame numbers (are they times?), or say which frames are evaluated",
            facts=("frames",),
        )
    reason = (
        f"every {nth(step)} frame from {first} to {last}: annotation is sampled at that step"
        if step > 1
        else f"every frame from the first to the last annotated, {first} to {last}"
    )
    return np.arange(first, last + 1, step), reason


def own_frames(
    truth: Reading, names: Iterable[str], files: Sequence[SourceFile] = ()
) -> dict[str, tuple[np.ndarray, str]]:
    """Return evaluated frames of recordings by the ground truth, with a text on the reason.

    Parameters
    ----------
    truth
        The ground truth.
    names
        The recordings that are needed.
    files
        Files of the truth, for the error.

    Returns
    -------
    dict
        Frame numbers by recording, sorted, unique, int64. Empty if nothing is known.

    Raises
    ------
    MissingFactError
        If there would be more frames than any recording has, with the line of the largest.
    """
    names = list(names)
    if not names:
        return {}
    annotated = frames_by_recording(truth.boxes if truth.annotated is None else truth.annotated)
    imaged = {} if truth.images is None else frames_by_recording(truth.images)
    listed: dict[str, tuple[np.ndarray, str]] = {}
    for name in names:
        if name in imaged:
            listed[name] = imaged[name], "those that the ground truth lists"
        elif name in annotated:
            try:
                listed[name] = infer_frames(annotated[name])
            except MissingFactError as error:
                boxes, last = truth.boxes, annotated[name][-1]
                is_last = (boxes["recording"] == name) & (boxes["frame"] == last)
                row = int(np.argmax(is_last))
                if not files or not is_last.any():
                    raise
                raise MissingFactError(
                    error.message,
                    file=files[boxes["file"].iloc[row]].name,
                    line=int(boxes["line"].iloc[row]),
                    facts=error.facts,
                ) from None
        else:
            listed[name] = np.empty(0, np.int64), "no frame is known; recording left out"
    return listed


def frames_by_recording(table: pd.DataFrame) -> dict[str, np.ndarray]:
    """Return sorted unique frame numbers by recording of a table."""
    groups = table.groupby("recording", sort=False, observed=True)["frame"]
    return {str(name): _sorted_unique(group.to_numpy(dtype=np.int64)) for name, group in groups}


def _sorted_unique(numbers: np.ndarray) -> np.ndarray:
    """Return sorted unique numbers, faster than `numpy.unique` if they are already sorted."""
    if np.any(numbers[1:] < numbers[:-1]):
        return np.unique(numbers)
    is_new = np.ones(len(numbers), dtype=bool)
    is_new[1:] = numbers[1:] != numbers[:-1]
    return numbers[is_new]
