"""What one comparison consists of: inputs, facts that they lack, settings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from nvcore.params import Params


@dataclass(frozen=True)
class RecordingFacts:
    """What the session says of one recording; None: the data tell."""

    name: str
    width: float | None = None
    height: float | None = None
    fps: float | None = None
    frames: str | None = None
    horizon: float | None = None
    pictures: str | None = None


@dataclass(frozen=True)
class Source:
    """Where ground truth or a system's detections come from, and how to read them.

    Attributes
    ----------
    path
        Files, folders or globs.
    format
        Name of a format; None: told from the content.
    classes, frame_base, box_base
        See `nvcore.readers.base.ReadOptions`.
    """

    path: tuple[str, ...]
    format: str | None = None
    classes: tuple[str, ...] | None = None
    frame_base: int | None = None
    box_base: int | None = None


@dataclass(frozen=True)
class SystemSource(Source):
    """A system's detections, its threshold, and corrections applied to its boxes.

    Attributes
    ----------
    name
        The system's name; None: told from the path.
    threshold
        Score threshold; None: every detection counts.
    offset_frames
        Added to the frame numbers.
    offset_px
        Added to x and y, after scaling.
    scale
        By which x, y, w and h are multiplied.
    """

    name: str | None = None
    threshold: float | None = None
    offset_frames: int = 0
    offset_px: tuple[float, float] = (0.0, 0.0)
    scale: float = 1.0


@dataclass(frozen=True)
class Session:
    """A comparison to be made.

    Attributes
    ----------
    folder
        What relative paths start from.
    truth, systems
        The inputs.
    recordings
        Facts by recording.
    size, fps, frames
        Facts for all recordings: (width, height) px, frames per second, frame list.
    x, y
        Names of the two systems to compare; None: the first and the second.
    params
        Settings of the analysis. Thresholds given here go before those of the systems.
    hashes
        sha256 of the inputs by path when the session was written; checked when it is loaded.
    """

    folder: Path
    truth: Source
    systems: tuple[SystemSource, ...]
    recordings: tuple[RecordingFacts, ...] = ()
    size: tuple[int, int] | None = None
    fps: float | None = None
    frames: str | None = None
    x: str | None = None
    y: str | None = None
    params: Params = field(default_factory=Params)
    hashes: Mapping[str, str] = field(default_factory=dict)


def parse_size(text: str) -> tuple[int, int]:
    """Width and height from ``640x480``.

    Raises
    ------
    ValueError
        If the text is not of that form.
    """
    found = re.fullmatch(r"\s*(\d{1,6})\s*[xX×]\s*(\d{1,6})\s*", text)
    if found is None or not int(found[1]) or not int(found[2]):
        raise ValueError(f"expected a size such as 640x480, got {text!r}")
    return int(found[1]), int(found[2])


def is_frame_range(frames: str) -> bool:
    """Whether the text is ``first:last`` or ``first:last:step``, not the name of a file."""
    return re.fullmatch(r"\s*-?\d+\s*:\s*-?\d+\s*(:\s*\d+\s*)?", frames) is not None
