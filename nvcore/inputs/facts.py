"""Validation and parsing of facts that a session gives, such as sizes and frames."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache
from pathlib import Path
from typing import Any, Final, TypeVar

from nvcore.common.arguments import Size
from nvcore.common.errors import InputError, SessionError
from nvcore.settings.defaults import MAX_FPS, MIN_FPS
from nvcore.settings.objects import Objects, objects_from

P = TypeVar("P")
FRAME_NAMES: Final = ("numbers", "times", "order", "scenes", "counter")
"""Interpretations of picture names and large frame numbers."""


def expect(is_met: bool, message: str) -> None:
    """Raise SessionError with the message unless the expectation is met."""
    if not is_met:
        raise SessionError(message)


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
    """Raise SessionError if the text cannot be a path."""
    # names of files may have other control characters, which are escaped when shown
    if text is not None and "\0" in text:
        raise SessionError(f"{name}: expected a path, found one with a NUL: {text!r}")


def path_field(meaning: str = "", *, label: str = "", is_of_run: bool = False) -> Any:
    """Declare a field with the path of a file, None by default.

    Parameters
    ----------
    meaning
        Help text with ``{system}`` of a system's key that has flags for X and Y.
    label
        Label of its field in a form that opens files. Empty: the form has none.
    is_of_run
        Whether the file is about one run of a system, so that other detections invalidate it.
    """
    about = {"is_path": True, "meaning": meaning, "label": label, "is_of_run": is_of_run}
    return field(default=None, metadata=about)


def without_files_of_run(part: P) -> P:
    """Return a part of a session without the files about one run of a system."""
    of_part: Any = part
    names = [spec.name for spec in fields(of_part) if spec.metadata.get("is_of_run")]
    dropped: P = replace(of_part, **dict.fromkeys(names))
    return dropped


@cache
def labelled_paths(kind: Any) -> Mapping[str, str]:
    """Return labels of a session part's fields that are shown in forms, by field name."""
    labels = {spec.name: spec.metadata.get("label", "") for spec in fields(kind)}
    return {name: label for name, label in labels.items() if label}


@cache
def _path_fields(kind: Any) -> tuple[str, ...]:
    return tuple(spec.name for spec in fields(kind) if spec.metadata.get("is_path"))


def paths_in(part: Any) -> Iterator[str]:
    """Yield the paths in a part of a session, as they are written."""
    paths = (getattr(part, name) for name in _path_fields(part.__class__))
    yield from (path for path in paths if path is not None)


def check_paths(part: Any) -> None:
    """Raise SessionError if one of `paths_in` cannot be a path."""
    for name in _path_fields(part.__class__):
        check_path(name, getattr(part, name))


def with_paths_in(part: P, rename: Callable[[str], str | None]) -> P:
    """Return a part of a session with each path renamed, or dropped by None."""
    of_part: Any = part
    paths = {name: getattr(part, name) for name in _path_fields(of_part.__class__)}
    renamed = {name: rename(path) for name, path in paths.items() if path is not None}
    return replace(of_part, **renamed) if renamed else part


def parse_size(text: str) -> tuple[int, int]:
    """Parse width and height from ``640x480``.

    Raises
    ------
    ValueError
        If the text is not of that form.
    """
    match = re.fullmatch(r"\s*(\d{1,6})\s*[xX×]\s*(\d{1,6})\s*", text)
    if match is None or not int(match[1]) or not int(match[2]):
        raise ValueError(f"expected a size such as 640x480, got {text!r}")
    return int(match[1]), int(match[2])


FRAME_RANGE: Final = "first:last or first:last:step"
"""Form of a range of frames, inclusive. A missing end is the recording's."""
_FRAME_RANGE: Final = re.compile(r"\s*(-?\d{1,15})?\s*:\s*(-?\d{1,15})?\s*(?::\s*(\d{1,15})\s*)?")


@dataclass(frozen=True)
class FrameRange:
    """Frames from the first to the last, both included. None: the recording's own."""

    first: int | None
    last: int | None
    step: int = 1


def is_frame_range(frames: str) -> bool:
    """Whether the text chooses frames by their numbers, and is not the name of a file."""
    return _FRAME_RANGE.fullmatch(frames) is not None


def is_open_range(frames: str) -> bool:
    """Whether the text is a range with an end that is the recording's."""
    match = _FRAME_RANGE.fullmatch(frames)
    return match is not None and None in match.group(1, 2)


def frame_range(frames: str) -> FrameRange:
    """Parse a range of frames such as ``0:299``, ``:399`` or ``0:299:5``.

    Raises
    ------
    InputError
        If the text is not a range, or the range is empty.
    """
    match = _FRAME_RANGE.fullmatch(frames)
    if match is not None:
        first, last, step = (None if part is None else int(part) for part in match.groups())
        is_empty = first is not None and last is not None and last < first
        if not is_empty and step != 0:
            return FrameRange(first, last, step or 1)
    raise InputError(
        f"frames {frames!r}: expected {FRAME_RANGE} with last >= first and step >= 1, such as "
        "0:299, 0:299:5, :399 or 400:"
    )


def frames_from(frames: str | range | None) -> str | None:
    """Return frames as a session names them. A file is relative to the working folder.

    Raises
    ------
    InputError
        If a range is empty.
    """
    if isinstance(frames, range):
        if not frames:
            raise InputError(f"frames: expected at least one, got {frames}")
        first, last = sorted((frames[0], frames[-1]))
        return f"{first}:{last}:{abs(frames.step)}"
    if frames is None or is_frame_range(frames):
        return frames
    return str(Path.cwd() / frames)


def objects_named(names: str | Sequence[str] | Objects | None) -> Objects | None:
    """Return the objects of these names, or None.

    Raises
    ------
    InputError
        If they are not names of objects.
    """
    if names is None:
        return None
    try:
        return objects_from(names)
    except ValueError as error:
        raise InputError(f"objects: {error}") from error


def size_from(size: Size | None) -> tuple[int, int] | None:
    """Convert a picture's size, given as a pair or as text, to width and height.

    Raises
    ------
    InputError
        If the size is neither a pair of numbers nor text such as ``640x480``.
    """
    if size is None:
        return None
    try:
        if isinstance(size, str):
            return parse_size(size)
        width, height = (int(side) for side in size)
        if (width, height) != tuple(size) or min(width, height) < 1:
            raise ValueError
    except (TypeError, ValueError) as error:
        raise InputError(
            f'size: expected (WIDTH, HEIGHT) in pixels or "WIDTHxHEIGHT", got {size!r}'
        ) from error
    return width, height
