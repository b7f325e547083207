"""Whom a finding of the audit is about, and where its first case stands in the files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.dataset import BoxColumns, Dataset
from nvcore.findings import Finding, Severity
from nvcore.schema import TABLE_ENDING

TRUTH_NAME: Final = "truth"
"""`Finding.subject` of the ground truth."""
MOST_NAMES: Final = 3
"""Names that a message spells out; of the others it says how many."""


@dataclass(frozen=True)
class Audited:
    """One source of boxes: the truth or a system.

    Attributes
    ----------
    dataset
        The dataset that the boxes are from.
    name
        ``truth`` or the system's name.
    is_truth
        Whether it is the truth: a system may be called ``truth``, too.
    boxes
        Its boxes, px, sorted by frame.
    """

    dataset: Dataset
    name: str
    is_truth: bool
    boxes: BoxColumns

    @property
    def recording(self) -> np.ndarray:
        """Recording of every box, shape (n,)."""
        of_box: np.ndarray = self.dataset.frame_columns.recording[self.boxes.frame_index]
        return of_box

    def finding(
        self,
        severity: Severity,
        code: str,
        rows: np.ndarray,
        message: str,
        advice: str,
        *,
        count: int | None = None,
    ) -> Finding:
        """A finding about some boxes, the first of which is the example.

        Parameters
        ----------
        rows
            Rows of `boxes`, at least one.
        count
            What to count; None: the rows.
        """
        first = int(rows[0])
        row = self.boxes.first_row + first
        file, line = (int(self.dataset.boxes[name].iloc[row]) for name in ("file", "line"))
        name = file_name(self.dataset, file, line)
        frame_index = int(self.boxes.frame_index[first])
        return Finding(
            severity=severity,
            code=code,
            subject=self.name,
            count=len(rows) if count is None else count,
            message=message,
            advice=advice,
            file=name,
            example=place_of_frame(self.dataset, frame_index, line=line, file=name),
        )


def audited_truth(dataset: Dataset) -> Audited:
    """The ground truth."""
    return Audited(dataset, TRUTH_NAME, True, dataset.truth)


def audited_systems(dataset: Dataset) -> list[Audited]:
    """All systems, in the order of the dataset."""
    return [audited_system(dataset, name) for name in dataset.systems]


def audited_system(dataset: Dataset, name: str) -> Audited:
    """One system, by its name."""
    return Audited(dataset, name, False, dataset.system(name))


def file_name(dataset: Dataset, file: int, line: int) -> str:
    """Name of an input file; empty for boxes that come from none (they have no line)."""
    if line < 1 or not 0 <= file < len(dataset.inputs):
        return ""
    return str(dataset.inputs["file"].iloc[file])


def place(recording: object, frame: int, *, line: int = 0, file: str = "") -> str:
    """Where something is, such as ``line 17, recording A, frame 12``; JSON counts records.

    Rows of a table in memory are counted from 0.
    """
    is_table = file.endswith(TABLE_ENDING)
    unit = "row" if is_table else "record" if file.lower().endswith(".json") else "line"
    number = f"{unit} {line - is_table}, " if line > 0 else ""
    return f"{number}recording {recording}, frame {frame}"


def place_of_frame(dataset: Dataset, frame_index: int, *, line: int = 0, file: str = "") -> str:
    """`place` of a row of the frames table."""
    frames = dataset.frame_columns
    name = dataset.recordings["name"].iloc[int(frames.recording[frame_index])]
    return place(name, int(frames.frame[frame_index]), line=line, file=file)


def counted(n: int, singular: str, plural: str | None = None) -> str:
    """Number and noun, such as ``1 box`` or ``12,000 boxes``; `plural`: `singular` + s."""
    return f"{n:,} {singular if n == 1 else plural or singular + 's'}"


def spelled(names: Iterable[object]) -> str:
    """The first few names; of the others how many."""
    every: Sequence[str] = [str(name) for name in names]
    shown = ", ".join(every[:MOST_NAMES])
    more = len(every) - MOST_NAMES
    return f"{shown} and {more} more" if more > 0 else shown


def without_doubles(names: Iterable[object]) -> list[object]:
    """The names in their order, each once."""
    return list(dict.fromkeys(names))
