"""Stretches of a recording to which somebody gave a code, such as glare or distraction."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Final

from nvcore.errors import ParameterError

COLUMNS: Final = ("recording", "start_s", "end_s", "code")
LONGEST_CODE: Final = 80
NO_CODE: Final = "no_code"
"""Class of encounters that overlap no coded interval, in recordings that have any."""
SEPARATOR: Final = ";"
"""`nvcore.schema.CLASS_SEPARATOR`, without what that module loads."""


@dataclass(frozen=True, order=True)
class CodedInterval:
    """A stretch of a recording with a code.

    Attributes
    ----------
    recording
        What the recording is called.
    start_s, end_s
        Seconds since its first evaluated frame, both included.
    code
        A word or a few; it is a class of the encounters that the stretch overlaps.

    Raises
    ------
    ParameterError
        If it ends before it starts, or the code can be none.
    """

    recording: str
    start_s: float
    end_s: float
    code: str

    def __post_init__(self) -> None:
        for name in ("start_s", "end_s"):
            if not math.isfinite(getattr(self, name)):
                raise ParameterError(f"{name}: expected seconds, got {getattr(self, name):g}")
        if self.end_s < self.start_s:
            raise ParameterError(
                f"end_s: expected {self.start_s:g}, the start, or more; got {self.end_s:g}"
            )
        is_text = 0 < len(self.code) <= LONGEST_CODE and self.code.isprintable()
        is_taken = SEPARATOR in self.code or self.code == NO_CODE
        if not is_text or is_taken or self.code != self.code.strip():
            raise ParameterError(
                f"code: expected 1 to {LONGEST_CODE} characters without {SEPARATOR!r}, other "
                f"than {NO_CODE}; got {self.code!r}"
            )

    def given(self) -> dict[str, Any]:
        """As a session file has it."""
        return asdict(self)
