"""Wording of suggested fixes on the command line, in terms of its flags."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final

import click

from nvcore.common.errors import NvcoreError
from nvcore.common.findings import TRUTH_NAME, Finding, Remedy, RemedyTexts, Step, steps_text

TEXTS: Final[RemedyTexts] = {
    Remedy.CLASSES: ("give --classes{of} {value}", "NAMES"),
    Remedy.SIZE: ("give --size {value}", "WIDTHxHEIGHT"),
    Remedy.RATE: ("give --fps {value}", "FPS"),
    Remedy.FRAMES: ("give --frames {value}", "FIRST:LAST:STEP"),
    Remedy.FRAME_LIST: ("give the file as --frames", ""),
    Remedy.FRAME_NAMES: ("give --frame-names{of} {value}", "numbers|times|order|scenes|counter"),
    Remedy.FRAME_STEP: ("give --frame-step{of} {value}", "FACTOR"),
    Remedy.FORMAT: ("give --format{of} {value}", "FORMAT"),
    Remedy.THRESHOLD: ("give --threshold{of} {value}", "SCORE"),
    Remedy.BOX_BASE: ("give --box-base {value}", "0|1"),
    Remedy.BOXES: ("give --boxes{of} {value}", "corners"),
    Remedy.ACCEPT: ("if this is meant, give --accept {value}", "CODE"),
    Remedy.TABLE: (
        "convert the files to CSV with the header {value} (docs/formats.md)",
        "frame,x,y,w,h,score",
    ),
    Remedy.PICTURES: ('write pictures = "{value}" under the recording in the session file', "PATH"),
    Remedy.FIRST_PICTURE: (
        "write first_picture = {value} under the recording in the session file",
        "FRAME",
    ),
    Remedy.OPTION: ("give {of}", ""),
}

_METAVARS: Final = {
    "boxes": "FILE",
    "force": "",
    "frames_out": "PATH",
    "horizon": "ROW",
    "only": "RECORDING",
    "recordings": "FILE",
    "truth": "PATH",
}
"""Placeholders for values of options that only the user knows."""

OF_SESSION_FILE: Final[RemedyTexts] = dict(TEXTS) | {
    Remedy.CLASSES: ('write classes = ["{value}"]{of}', "NAMES"),
    Remedy.FRAME_NAMES: ('write frame_names = "{value}"{of}', "numbers|times|order|scenes|counter"),
    Remedy.FRAME_STEP: ("write frame_step = {value}{of}", "FACTOR"),
    Remedy.FORMAT: ('write format = "{value}"{of}', "FORMAT"),
    Remedy.BOX_BASE: ("write box_base = {value}{of}", "0"),
    Remedy.BOXES: ('write boxes = "{value}"{of}', "corners"),
}
"""Templates for runs with a session file, which has keys instead of flags about its files."""


def ways_text(
    steps: Iterable[Step], compared: Mapping[str, str], *, are_all_needed: bool = False
) -> str:
    """Return suggested fixes as a sentence, by flags or by keys of the given session file.

    Parameters
    ----------
    compared
        Ending of the flags about a source ("-x"), by the subject of a step.
    are_all_needed
        See `steps_text`.
    """
    context = click.get_current_context(silent=True)
    texts, tables = TEXTS, {}
    if context is not None and context.params.get("session_file") is not None:
        texts = OF_SESSION_FILE
        steps = [
            replace(step, value=step.value.replace(",", '", "'))
            if step.remedy is Remedy.CLASSES
            else step
            for step in steps
        ]
        tables = {"": " under [truth] and [[system]] of the session file"}
        tables |= {TRUTH_NAME: " under [truth] of the session file"}

    def mark(step: Step) -> str:
        if step.remedy is Remedy.OPTION:
            value = shlex.quote(step.value) if step.value else _METAVARS.get(step.subject, "VALUE")
            return f"--{step.subject.replace('_', '-')} {value}".rstrip()
        if texts is TEXTS or step.remedy is Remedy.THRESHOLD:
            return compared.get(step.subject, "")
        return tables.get(step.subject) or _system_table(step.subject)

    return steps_text(steps, texts, mark, are_all_needed=are_all_needed)


def _system_table(name: str) -> str:
    return f' under [[system]] "{name}" of the session file'


def suggestion_text(finding: Finding, compared: Mapping[str, str]) -> str:
    """Return a finding's suggested corrections, by flags of X or Y or else by session keys."""
    values: dict[str, list[str]] = {}
    for name, value in finding.suggestion:
        key = {"offset_x_px": "offset_px", "offset_y_px": "offset_px"}.get(name)
        key = key or name.removesuffix("_x").removesuffix("_y")
        values.setdefault(key, []).append(f"{value:.6g}")
    if not values:
        return ""
    end = compared.get(finding.subject)
    if end is not None:
        flags = (f"--{key.replace('_', '-')}{end} {','.join(own)}" for key, own in values.items())
        return f"Give {' '.join(flags)}."
    keys = (
        f"{key} = {own[0] if len(own) == 1 else '[' + ', '.join(own) + ']'}"
        for key, own in values.items()
    )
    return f"Write {' and '.join(keys)}{_system_table(finding.subject)}."


def error_text(error: NvcoreError) -> str:
    """Return the error's message with suggested fixes."""
    ways = ways_text(error.steps, {}, are_all_needed=error.needs_all_steps)
    return f"{str(error).rstrip('.')}. {ways}" if ways else str(error)
