"""Remarks that subjects add to the numbers of a comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from nvcore.common.subject import subjects
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Measure
from nvcore.dataset import Dataset
from nvcore.notes import Note


@dataclass(frozen=True)
class Remarks:
    """Functions by which a subject remarks on the numbers of a comparison.

    Attributes
    ----------
    note
        Text below the scorecard.
    limits
        Limits of the data, for the first page of the HTML report.
    of_claims
        Explanations that follow claims about these measures.
    recordings
        Title of a column of the HTML report's table of recordings, and a text for each recording.
    """

    note: Callable[[Result], tuple[Note, ...]]
    limits: Callable[[Result], tuple[Note, ...]]
    of_claims: Callable[[Result, Sequence[Measure]], Note | None]
    recordings: tuple[str, Callable[[Dataset], list[str]]]


def all_remarks() -> list[Remarks]:
    """Return the remarks of all subjects."""
    return [remarks for subject in subjects() for remarks in subject.report().remarks]


def remarks_on(result: Result) -> list[Note]:
    """Return the remarks of all subjects for below the scorecard."""
    return [note for remarks in all_remarks() for note in remarks.note(result)]
