"""Numbers with their formats, as values of facts."""

from __future__ import annotations

from dataclasses import dataclass

from nvcore.notes import Fact as Fact
from nvcore.wording import number, p_text


@dataclass(frozen=True)
class Amount:
    """A number with its format (``d``: a whole number) and the unit that follows it."""

    value: float
    form: str
    unit: str = ""

    @property
    def number(self) -> str:
        """Without the unit."""
        return number(int(self.value) if self.form == "d" else self.value, self.form)

    def __str__(self) -> str:
        return self.number + self.unit


@dataclass(frozen=True)
class P:
    """A p by itself, and corrected for what is tested together."""

    p: float
    corrected: float

    def __str__(self) -> str:
        return p_text(self.p, self.corrected)
