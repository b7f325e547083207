"""What is wrong or suspicious in the inputs, as `Finding` objects.

Readers, the dataset builder and the audit report through the same type, so that the command line
and the dashboard show a single list, worst first.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Final, Literal

from nvcore.wording import capitalised

if TYPE_CHECKING:
    import numpy as np

TRUTH_NAME: Final = "truth"
"""`Finding.subject` of the ground truth."""

OF_PICTURES: Final = "pictures-"
"""How the codes of findings begin that concern pictures alone: no measure depends on these."""


class Severity(StrEnum):
    """How bad a finding is: an error makes measures wrong, a warning may, a note does not."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


_ORDER = {Severity.ERROR: 0, Severity.WARNING: 1, Severity.NOTE: 2}


@dataclass(frozen=True, eq=False)
class Cases:
    """Every place that a finding concerns, as rows of a table of the audited dataset.

    `nvcore.tables.finding_entries` says recording, frame and box of each.

    Attributes
    ----------
    table
        Which table: ``boxes``, ``frames`` or ``left_out``.
    rows
        Rows of it; int, shape (n,).
    """

    table: Literal["boxes", "frames", "left_out"]
    rows: np.ndarray

    def __len__(self) -> int:
        return len(self.rows)


@dataclass(frozen=True)
class Caveats:
    """What findings mean for the verdict, by their codes.

    Attributes
    ----------
    warned
        Of findings that every page warns of.
    lesser
        Of those that only Overview and Data tell.
    """

    warned: Mapping[str, str]
    lesser: Mapping[str, str]


class Remedy(StrEnum):
    """What a person can do about a finding or an error.

    The command line and the dashboard say it each with its own flag or field, in one table of
    theirs; the library names neither.
    """

    CLASSES = "classes"
    """Say which classes count; value: names or numbers, with commas."""
    SIZE = "size"
    """Give the size of the pictures, px; value: such as ``640x480``."""
    RATE = "rate"
    """Give the frame rate; value: frames per second."""
    FRAMES = "frames"
    """Say which frames are evaluated; value: ``first:last:step``."""
    FRAME_LIST = "frame list"
    """Give this file as the list of evaluated frames, not as boxes."""
    FRAME_NAMES = "frame names"
    """Say how names of pictures and large frame numbers are meant; value: such as ``times``."""
    FRAME_STEP = "frame step"
    """Multiply the frame numbers of a system; value: the factor."""
    FORMAT = "format"
    """Say in which format the files are; value: its name."""
    THRESHOLD = "threshold"
    """Set the threshold of a system; value: a score."""
    BOX_BASE = "box base"
    """Say which number the first pixel has; value: 0 or 1."""
    BOXES = "boxes"
    """Say what the four numbers of a box are; value: such as ``corners``."""
    ACCEPT = "accept"
    """Say that an error is meant; value: the code of the finding."""
    TABLE = "table"
    """Convert the files to plain CSV with a header line."""
    PICTURES = "pictures"
    """Say where a recording's pictures are; value: a path; subject: the recording's name."""
    FIRST_PICTURE = "first picture"
    """Say which frame a recording's first picture shows; value: its number; subject: as above."""
    OPTION = "option"
    """Give an option; value: such as ``height``; subject: its name, a field of `Params` or a
    keyword of the Python functions."""


@dataclass(frozen=True)
class Step:
    """One way on: what to do, and with what.

    Attributes
    ----------
    remedy
        What to do.
    value
        What to give, as it is typed; empty: only the user knows it.
    subject
        Whose files it is about: `TRUTH_NAME` or the name of a system; empty: all. Of pictures, the
        name of the recording; of an option, its name.
    """

    remedy: Remedy
    value: str = ""
    subject: str = ""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong or suspicious in the inputs.

    Attributes
    ----------
    severity
        `error`: the measures are wrong until it is fixed; `warning`: they may be; `note`: good to
        know.
    code
        Short stable name in kebab case, such as ``duplicate-track``.
    subject
        What it is about: ``truth``, the name of a system, or "pictures of" a recording.
    count
        How many rows, frames or recordings it concerns.
    message
        What was found, in a sentence.
    advice
        What to do about it, in a sentence.
    steps
        The same as data, for a medium that has a flag, a field or a button for it.
    file
        File in which it was first seen; empty where no single file is to blame.
    example
        The first case: line, recording, frame.
    suggestion
        Corrections, each with its key in the session file and the value that belongs there, such
        as ``(("offset_frames", -2.0),)``, for a medium that has flags for them or offers to apply
        them; empty: none.
    cases
        All places that it concerns; None: an input as a whole, or not known.
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
        """File and first place, empty if neither is known."""
        return ", ".join(part for part in (self.file, self.example) if part)

    @property
    def is_of_pictures(self) -> bool:
        """Whether it is about pictures, on which no measure depends."""
        return self.code.startswith(OF_PICTURES)


def accepted(findings: Iterable[Finding], codes: Collection[str]) -> list[Finding]:
    """The findings, errors of these codes as warnings: the user says that they are meant."""
    return [
        replace(finding, severity=Severity.WARNING, steps=(), advice="This is meant, as given.")
        if finding.severity is Severity.ERROR and finding.code in codes
        else finding
        for finding in findings
    ]


def worst_first(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings sorted by severity, the order within one severity kept."""
    return tuple(sorted(findings, key=lambda finding: _ORDER[finding.severity]))


RemedyTexts = Mapping[Remedy, tuple[str, str]]
"""How a medium words each remedy, and what stands there for a value that only the user knows.

``{value}`` becomes the value, ``{of}`` how the medium marks what is about one source.
"""


def steps_text(
    steps: Iterable[Step],
    texts: RemedyTexts,
    mark: Callable[[Step], str] = lambda _: "",
    *,
    are_all_needed: bool = False,
) -> str:
    """Ways on as a sentence; empty: there is none.

    Parameters
    ----------
    mark
        What ``{of}`` becomes.
    are_all_needed
        Whether all of them have to be taken; else one will do.

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
