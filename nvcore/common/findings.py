"""Errors in the inputs and doubts about them, as `Finding` objects.

Readers, the dataset builder and the audit report through the same type, so that the command line
and the dashboard show a single list, worst first.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Final, Literal

from nvcore.common.wording import capitalised

if TYPE_CHECKING:
    import numpy as np

TRUTH_NAME: Final = "truth"
"""`Finding.subject` of the ground truth."""

OF_PICTURES: Final = "pictures-"
"""Prefix of image-related finding codes. They do not affect any measure."""


class Severity(StrEnum):
    """Severity of a finding. Errors make measures wrong, warnings possibly, notes do not."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


_ORDER = {Severity.ERROR: 0, Severity.WARNING: 1, Severity.NOTE: 2}


@dataclass(frozen=True, eq=False)
class Cases:
    """Rows of a table of the audited dataset that a finding concerns.

    `nvcore.tables.finding_entries` returns recording, frame and box of each.

    Attributes
    ----------
    table
        Name of the table: ``boxes``, ``frames`` or ``left_out``.
    rows
        Rows of the table; int, shape (n,).
    """

    table: Literal["boxes", "frames", "left_out"]
    rows: np.ndarray

    def __len__(self) -> int:
        return len(self.rows)


@dataclass(frozen=True)
class Caveats:
    """Texts on what findings mean for the verdict, by code.

    Attributes
    ----------
    warned
        Caveats of findings that every page warns about.
    lesser
        Caveats of findings that only Overview and Data show.
    """

    warned: Mapping[str, str]
    lesser: Mapping[str, str]


class Remedy(StrEnum):
    """Kind of action that fixes a finding or an error.

    The command line and the dashboard have tables that word it with their flags or fields. The
    library names neither.
    """

    CLASSES = "classes"
    """Specify the classes that count. Value: names or numbers, with commas."""
    SIZE = "size"
    """Specify the size of the pictures, px. Value: such as ``640x480``."""
    RATE = "rate"
    """Specify the frame rate. Value: frames per second."""
    FRAMES = "frames"
    """Specify the evaluated frames. Value: ``first:last:step``."""
    FRAME_LIST = "frame list"
    """Use this file as the list of evaluated frames, not as boxes."""
    FRAME_NAMES = "frame names"
    """Specify the meaning of picture names and large frame numbers. Value: such as ``times``."""
    FRAME_STEP = "frame step"
    """Multiply the frame numbers of a system. Value: the factor."""
    FORMAT = "format"
    """Specify the format of the files. Value: its name."""
    THRESHOLD = "threshold"
    """Set the threshold of a system. Value: a score."""
    BOX_BASE = "box base"
    """Specify the number of the first pixel. Value: 0 or 1."""
    BOXES = "boxes"
    """Specify the meaning of a box's four numbers. Value: such as ``corners``."""
    ACCEPT = "accept"
    """Accept an error as intended. Value: the code of the finding."""
    TABLE = "table"
    """Convert the files to plain CSV with a header line."""
    PICTURES = "pictures"
    """Specify a recording's pictures. Value: a path. Subject: the recording's name."""
    FIRST_PICTURE = "first picture"
    """Specify the frame of a recording's first picture. Value: its number. Subject: as above."""
    OPTION = "option"
    """Set an option. Value: such as ``height``. Subject: its name, a field of `Params` or a keyword
    of the Python functions."""


@dataclass(frozen=True)
class Step:
    """Suggested fix: an action and the value to use.

    Attributes
    ----------
    remedy
        Kind of action.
    value
        Value as the user types it. Empty: only the user knows it.
    subject
        Source of the files: `TRUTH_NAME` or the name of a system. Empty: all. For pictures: name of
        the recording. For an option: its name.
    """

    remedy: Remedy
    value: str = ""
    subject: str = ""


@dataclass(frozen=True)
class Finding:
    """Error, doubt or note about the inputs.

    Attributes
    ----------
    severity
        `error`: the measures are wrong until it is fixed. `warning`: they may be wrong. `note`:
        good to know.
    code
        Short stable name in kebab case, such as ``duplicate-track``.
    subject
        Source: ``truth``, the name of a system, or "pictures of" a recording.
    count
        Number of affected rows, frames or recordings.
    message
        Description in one sentence.
    advice
        Suggested fix in one sentence.
    steps
        Suggested fixes as data, for a medium with a flag, a field or a button for them.
    file
        File of the first occurrence. Empty if no single file is to blame.
    example
        First occurrence: line, recording, frame.
    suggestion
        Corrections as pairs of session file key and value, such as ``(("offset_frames", -2.0),)``,
        for a medium that has flags for them or offers to apply them.
    cases
        All affected places. None: an input as a whole, or not known.
    """

    severity: Severity
    code: str
    subject: str
    count: int
    message: str
    advice: str
    file: str = ""
    example: str = ""
    suggestion: tuple[tuple[str, float], ...] = ()
    cases: Cases | None = field(default=None, compare=False, repr=False)
    steps: tuple[Step, ...] = ()

    @property
    def place(self) -> str:
        """File and first affected place in it, or "" if neither is known."""
        return ", ".join(part for part in (self.file, self.example) if part)

    @property
    def is_of_pictures(self) -> bool:
        """True if the finding is about pictures, which do not affect any measure."""
        return self.code.startswith(OF_PICTURES)


def accepted(findings: Iterable[Finding], codes: Collection[str]) -> list[Finding]:
    """Downgrade errors with these codes to warnings, because the user accepted them."""
    return [
        replace(finding, severity=Severity.WARNING, steps=(), advice="This is meant, as given.")
        if finding.severity is Severity.ERROR and finding.code in codes
        else finding
        for finding in findings
    ]


def worst_first(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings sorted by severity, keeping the order within one severity."""
    return tuple(sorted(findings, key=lambda finding: _ORDER[finding.severity]))


RemedyTexts = Mapping[Remedy, tuple[str, str]]
"""Templates of each remedy in a medium, with a placeholder for values only the user knows.

``{value}`` becomes the value. ``{of}`` becomes the medium's text for a single source.
"""


def steps_text(
    steps: Iterable[Step],
    texts: RemedyTexts,
    mark: Callable[[Step], str] = lambda _: "",
    *,
    are_all_needed: bool = False,
) -> str:
    """Join suggested fixes to a sentence, or "" if there are none.

    Parameters
    ----------
    mark
        Returns the replacement of ``{of}``.
    are_all_needed
        True if all fixes are needed, False if one is enough.

    Examples
    --------
    >>> texts = {Remedy.CLASSES: ("enter {value} as the classes{of}", "the names")}
    >>> steps_text([Step(Remedy.CLASSES, "child")], texts, lambda step: " that count")
    'Enter child as the classes that count.'
    """
    ways = []
    for step in steps:
        text, unknown = texts[step.remedy]
        ways.append(text.format(value=step.value or unknown, of=mark(step)))
    joined = (" and " if are_all_needed else ", or ").join(dict.fromkeys(ways))
    return f"{capitalised(joined)}." if ways else ""
