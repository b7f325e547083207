"""Remedies as the command line words them: by its flags."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from nvcore.errors import InputError, NvcoreError
from nvcore.findings import Remedy, RemedyTexts, steps_text

TEXTS: Final[RemedyTexts] = {
    Remedy.CLASSES: ("give --classes{of} {value}", "NAMES"),
    Remedy.SIZE: ("give --size {value}", "WIDTHxHEIGHT"),
    Remedy.RATE: ("give --fps {value}", "FPS"),
    Remedy.FRAMES: ("give --frames {value}", "FIRST:LAST:STEP"),
    Remedy.FRAME_NAMES: ("give --frame-names {value}", "numbers|times|order|scenes"),
    Remedy.FRAME_STEP: ("give --frame-step{of} {value}", "FACTOR"),
    Remedy.FORMAT: ("give --format{of} {value}", "FORMAT"),
    Remedy.BOXES: (
        'give --boxes{of} {value} (in a session file boxes = "{value}")',
        "corners",
    ),
    Remedy.ACCEPT: ("if this is meant, give --accept {value}", "CODE"),
    Remedy.TABLE: (
        "convert the files to CSV with the header {value} (docs/formats.md)",
        "frame,x,y,w,h,score",
    ),
    Remedy.PICTURES: (
        'write pictures = "{value}" under the recording in the session file',
        "PATH",
    ),
    Remedy.FIRST_PICTURE: (
        "write first_picture = {value} under the recording in the session file",
        "FRAME",
    ),
}


ENDS: Final = {end: end for end in ("-truth", "-x", "-y")}
"""Subjects of steps that are the ends of flags already; see `nvcore.cli.steps.errors_of`."""


def error_text(error: NvcoreError, marks: Mapping[str, str] | None = None) -> str:
    """The error with its ways on; `marks` as in `steps_text`."""
    steps = error.steps if isinstance(error, InputError) else ()
    ways = steps_text(steps, TEXTS, ENDS | dict(marks or {}))
    return f"{str(error).rstrip('.')}. {ways}" if ways else str(error)
