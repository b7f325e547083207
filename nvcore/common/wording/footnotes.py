"""Footnotes of tables, marked by letters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from string import ascii_lowercase

from nvcore.common.wording import capitalised


@dataclass(frozen=True)
class Footnotes:
    """Notes below a table, and the marks in its rows that refer to them.

    Attributes
    ----------
    marks
        Mark of each note, in the order of first use: a, b, c, ...
    """

    marks: dict[str, str] = field(default_factory=dict)

    def mark(self, note: str, mark: str = "") -> str:
        """Return a note's mark. A new note gets `mark`, or else the next unused letter."""
        if note not in self.marks:
            n = sum(known.isalpha() for known in self.marks.values())
            n_letters = len(ascii_lowercase)
            self.marks[note] = mark or ascii_lowercase[n % n_letters] * (1 + n // n_letters)
        return self.marks[note]

    def lines(self) -> list[str]:
        """Return each mark with its note as a sentence, such as "a: Too few recordings."."""
        return [f"{mark}: {capitalised(note)}." for note, mark in self.marks.items()]

    def of_row(self, notes: Iterable[str]) -> str:
        """Return the marks of a row's notes as text: "a c"."""
        return " ".join(dict.fromkeys(self.mark(note) for note in notes))
