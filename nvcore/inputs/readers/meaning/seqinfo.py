"""MOTChallenge's ``seqinfo.ini``: name, length, frame rate and picture size of a recording."""

from __future__ import annotations

import configparser
import math
from dataclasses import dataclass
from pathlib import Path

from nvcore.errors import FormatError
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.text import read_text

MAX_FRAMES = 10_000_000
"""Longer than any recording: four days at 30 frames per second."""


@dataclass(frozen=True)
class SequenceInfo:
    """What ``seqinfo.ini`` says; NaN or None where it does not, or where there is none.

    Attributes
    ----------
    name
        Name of the recording.
    width, height
        Size of the pictures in pixels.
    fps
        Frames per second.
    n_frames
        Number of frames, which are 1 to `n_frames`.
    """

    name: str | None = None
    width: float = math.nan
    height: float = math.nan
    fps: float = math.nan
    n_frames: int | None = None


def sequence_info(file: SourceFile) -> SequenceInfo:
    """Facts of ``seqinfo.ini`` beside the file or in one of the two folders above.

    Raises
    ------
    FormatError
        If it has no section [Sequence], or a value that is no positive number.
    """
    path = _info_path(file)
    if path is None:
        return SequenceInfo()
    source = SourceFile(path, f"seqinfo.ini of {file.name}")
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(read_text(source))
    except configparser.Error as error:
        text = str(error).replace("\n", " ").replace("'<string>'", "").strip()
        raise FormatError(
            f"expected [Sequence] and lines such as frameRate=30: {text}", file=source.name
        ) from error
    if not parser.has_section("Sequence"):
        raise FormatError("expected a section [Sequence], found none", file=source.name)
    values = parser["Sequence"]
    length = _positive(values, "seqLength", source)
    if length > MAX_FRAMES or length % 1 > 0:
        raise FormatError(
            f"expected seqLength as a whole number up to {MAX_FRAMES}, found {length:g}",
            file=source.name,
        )
    return SequenceInfo(
        name=values.get("name", "").strip() or None,
        width=_positive(values, "imWidth", source),
        height=_positive(values, "imHeight", source),
        fps=_positive(values, "frameRate", source),
        n_frames=None if math.isnan(length) else int(length),
    )


def _positive(values: configparser.SectionProxy, key: str, file: SourceFile) -> float:
    """The value, NaN where the key is missing."""
    text = values.get(key)
    if text is None:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise FormatError(
            f"expected {key} as a positive number, found {text!r}; correct it or leave it out",
            file=file.name,
        )
    return value


def _info_path(file: SourceFile) -> Path | None:
    folder = file.path.parent.resolve()
    for candidate in (folder, folder.parent, folder.parent.parent):
        path = candidate / "seqinfo.ini"
        if path.is_file():
            return path
    return None
