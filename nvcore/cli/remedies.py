"""Remedies as the command line words them: by its flags."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final

import click

from nvcore.errors import InputError, NvcoreError
from nvcore.findings import TRUTH_NAME, Remedy, RemedyTexts, Step, steps_text

TEXTS: Final[RemedyTexts] = {
    Remedy.CLASSES: ("give --classes{of} {value}", "NAMES"),
    Remedy.SIZE: ("give --size {value}", "WIDTHxHEIGHT"),
    Remedy.RATE: ("give --fps {value}", "FPS"),
    Remedy.FRAMES: ("give --frames {value}", "FIRST:LAST:STEP"),
    Remedy.FRAME_NAMES: ("give --frame-names{of} {value}", "numbers|times|order|scenes"),
    Remedy.FRAME_STEP: ("give --frame-step{of} {value}", "FACTOR"),
    Remedy.FORMAT: ("give --format{of} {value}", "FORMAT"),
    Remedy.BOXES: ("give --boxes{of} {value}", "corners"),
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

OF_SESSION_FILE: Final[RemedyTexts] = dict(TEXTS) | {
    Remedy.CLASSES: ('write classes = ["{value}"]{of}', "NAMES"),
    Remedy.FRAME_NAMES: ('write frame_names = "{value}"{of}', "numbers|times|order|scenes"),
    Remedy.FRAME_STEP: ("write frame_step = {value}{of}", "FACTOR"),
    Remedy.FORMAT: ('write format = "{value}"{of}', "FORMAT"),
    Remedy.BOXES: ('write boxes = "{value}"{of}', "corners"),
}
"""Where a session file is given, which holds what the flags say of files named by flags."""


def ways_text(steps: Iterable[Step], compared: Mapping[str, str]) -> str:
    """Ways on as a sentence: by flags, or by keys of the session file where one is given.

    Parameters
    ----------
    compared
        What the flags about a source end in ("-x"), by the subject of a step.
    """
    context = click.get_current_context(silent=True)
    if context is None or context.params.get("session_file") is None:
        return steps_text(steps, TEXTS, compared)
    steps = [
        replace(step, value=step.value.replace(",", '", "'))
        if step.remedy is Remedy.CLASSES
        else step
        for step in steps
    ]
    tables = {
        name: f' under [[system]] "{name}" of the session file'
        for name in {step.subject for step in steps}
    }
    tables |= {
        "": " under [truth] and [[system]] of the session file",
        TRUTH_NAME: " under [truth] of the session file",
    }
    return steps_text(steps, OF_SESSION_FILE, tables)


def error_text(error: NvcoreError) -> str:
    """The error with its ways on."""
    ways = ways_text(error.steps, {}) if isinstance(error, InputError) else ""
    return f"{str(error).rstrip('.')}. {ways}" if ways else str(error)
