"""Messages of the library as a page words them: it has fields and buttons, no flags.

The library names what to give by the flags of the command line; here each is what a person does on
the page instead.
"""

from __future__ import annotations

import re
from typing import Final

from nvcore.errors import InputError
from nvcore.findings import steps_text
from ui.shell.messages import without_paths
from ui.shell.remedies import TEXTS

_READING: Final = "under “How to read”"
_CLASSES: Final = "“Classes that count”"
_FRAMES: Final = "under “Evaluated frames”"
_WORDS: Final = tuple(
    (re.compile(rf"(?<![\w-]){pattern}" if pattern.startswith("--") else pattern), words)
    for pattern, words in (
        (r" \(on the command line: --frames\)", ""),
        (r" \(--only\)", ""),
        (r"--only, (?=--frames)", ""),
        (r" \(\[\[system\]\] in the session file(?:, or --[^)]*)?\)", " (the button does it)"),
        (r", or --(?:scale|offset-frames|offset-px)-\S*", ""),
        (r" --offset-px-\S*", ""),
        (r" \(--(?:size|fps)\)", ""),
        (r" \(--recordings\)", " (“Recordings”, below)"),
        (r" \(--frames(?: [^)]*)?\)", f" ({_FRAMES})"),
        (r" \(--objects \"[^\"]*\"\)", " (“The boxes are of”, above the fields)"),
        (r" \(--classes\)", f" ({_CLASSES} {_READING})"),
        (r"(?:with )?--frames\b", _FRAMES),
        (r"(?:with )?--format\b", _READING),
        (r"(?:with )?--box-base ([01])", rf"{_READING}: “the first pixel is \1”"),
        (r"(?:with )?--frame-base ([01])", rf"{_READING}: “the first frame is \1”"),
        (r"--classes\b", _CLASSES),
        (r"--size(?: WIDTHxHEIGHT)?", "the size of the pictures"),
        (r"--fps(?: FPS)?", "the frame rate"),
        (r"--recordings\b", "the table of recordings"),
        (r"--proximity (\w+)", r"“What tells how near” set to \1"),
        (
            r" \(--missing-distance borrow takes those of the systems\)",
            " (the button borrows those of the systems)",
        ),
        (r"--missing-distance height", "“Without a distance, weigh by” set to his height"),
        (r"--distance ground", "“Distance” set to foot points, under “Advanced”"),
        (
            r" \(--speed-kmh, or speed_kmh of the recording\)",
            " (on the page Time left, or in the table of recordings)",
        ),
        (r"; nvcore check estimates it", "; the page Data estimates it"),
        (r"--horizon\b", "the row of the horizon in the sidebar"),
        (r"--threshold-x and --threshold-y", "thresholds for X and Y"),
        (r"--threshold-x ([\d.e+-]*\d)", r"the threshold \1 for X"),
        (r"--threshold-y ([\d.e+-]*\d)", r"the threshold \1 for Y"),
        (r"--threshold-x\b", "the threshold of X"),
        (r"--threshold-y\b", "the threshold of Y"),
        (r"--threshold-", "its threshold"),
    )
)


def page_text(text: object) -> str:
    """The text without paths of the machine and without flags, an error with its ways on.

    Not yet plain.

    Examples
    --------
    >>> page_text("Name the format with --format (one of csv, coco)")
    'Name the format under “How to read” (one of csv, coco)'
    >>> page_text("For example, --threshold-y 0.042 alone leaves B 3 false alarms.")
    'For example, the threshold 0.042 for Y alone leaves B 3 false alarms.'
    """
    worded = without_paths(text)
    for pattern, words in _WORDS:
        worded = pattern.sub(words, worded)
    ways = steps_text(text.steps, TEXTS) if isinstance(text, InputError) else ""
    return f"{worded.rstrip('.')}. {ways}" if ways else worded
