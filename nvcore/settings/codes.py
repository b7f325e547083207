"""Intervals of a recording with a code from a person, such as glare or distraction."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Final

from nvcore.common.errors import ParameterError

COLUMNS: Final = ("recording", "start_s", "end_s", "code")
LONGEST_CODE: Final = 80
NO_CODE: Final = "no_code"
"""Class of encounters that overlap no coded interval, in recordings that have any."""
SEPARATOR: Final = ";"
"""Copy of `nvcore.dataset.schema.CLASS_SEPARATOR` that avoids loading that module."""


@dataclass(frozen=True, order=True)
class CodedInterval:
    """Interval of a recording with a code.

    Attributes
    ----------
    recording
        Name of the recording.
    start_s, end_s
        Seconds since the recording's first evaluated frame, both included.
    code
        One or a few words. It becomes a class of the encounters that the interval overlaps.

    Raises
    ------
    ParameterError
        If it ends before it starts, or the code is not valid.
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
        """Return the interval as in a session file."""
        return asdict(self)
