"""Subjects of findings, and the location of their first case in the files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from nvcore.common.file_kinds import unpacked_name
from nvcore.common.findings import TRUTH_NAME, Cases, Finding, Severity, Step
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import TABLE_ENDING

BLOCK: Final = 1 << 15
"""Number of boxes processed at a time."""
MOST_NAMES: Final = 3
"""Most names that a message lists. It only counts the others."""


@dataclass(frozen=True)
class BoxSource:
    """Source of boxes: the truth or a system.

    Attributes
    ----------
    dataset
        Dataset that contains the boxes.
    name
        ``truth`` or the system's name.
    is_truth
        True for the truth, since a system may be called ``truth``, too.
    boxes
        Boxes, px, sorted by frame.
    """

    dataset: Dataset
    name: str
    is_truth: bool
    boxes: BoxColumns

    @property
    def starts(self) -> np.ndarray:
        """First box of every recording, and the number of boxes, shape (n_recordings + 1,)."""
        starts: np.ndarray = self.boxes.offsets[self.dataset.frame_columns.first]
        return starts

    def blocks(self) -> Iterator[tuple[slice, slice]]:
        """Yield boxes in blocks of whole recordings: their rows, and the recordings.

        Intermediate results of a block stay in the processor's cache.
        """
        starts = self.starts
        edges = np.searchsorted(starts, np.arange(0, len(self.boxes) + BLOCK, BLOCK), side="right")
        for lo, hi in pairwise(np.unique(np.append(edges - 1, len(starts) - 1))):
            if starts[hi] > starts[lo]:
                yield slice(int(starts[lo]), int(starts[hi])), slice(int(lo), int(hi))

    def findings(
        self,
        severity: Severity,
        code: str,
        rows: np.ndarray,
        message: str,
        advice: str,
        *,
        count: int | None = None,
        is_of_all: bool = False,
        steps: tuple[Step, ...] = (),
    ) -> list[Finding]:
        """Return a finding about some boxes with the first as example, or none without boxes.

        Parameters
        ----------
        rows
            Rows of `boxes`.
        count
            Count of the finding; None: the number of rows.
        is_of_all
            True if it concerns the source as a whole, so that single boxes are no cases to look at.
        """
        if not len(rows):
            return []
        file, line = (
            int(self.dataset.boxes[name].iloc[self.boxes.first_row + rows[0]])
            for name in ("file", "line")
        )
        name = file_name(self.dataset, file, line)
        frame_index = int(self.boxes.frame_index[rows[0]])
        return [
            Finding(
                severity,
                code,
                self.name,
                len(rows) if count is None else count,
                message,
                advice,
                name,
                place_of_frame(self.dataset, frame_index, line=line, file=name),
                cases=None if is_of_all else Cases("boxes", self.boxes.first_row + rows),
                steps=steps,
            )
        ]


def truth_source(dataset: Dataset) -> BoxSource:
    """Return the ground truth."""
    return BoxSource(dataset, TRUTH_NAME, True, dataset.truth)


def system_source(dataset: Dataset, name: str) -> BoxSource:
    """Return a system by its name."""
    return BoxSource(dataset, name, False, dataset.system(name))


def all_sources(dataset: Dataset) -> list[BoxSource]:
    """Return the ground truth and every system."""
    return [truth_source(dataset), *(system_source(dataset, name) for name in dataset.systems)]


def file_name(dataset: Dataset, file: int, line: int) -> str:
    """Return the name of an input file, or "" for boxes without a file (they have no line)."""
    if line < 1 or not 0 <= file < len(dataset.inputs):
        return ""
    return str(dataset.inputs["file"].iloc[file])


def place(recording: object, frame: int, *, line: int = 0, file: str = "") -> str:
    """Describe a location, such as ``line 17, recording A, frame 12``.

    JSON counts records. Rows of a table, in memory or in Parquet, are counted from 0.
    """
    name = unpacked_name(file.lower())
    is_table = name.endswith((TABLE_ENDING, ".parquet", ".pq"))
    unit = "row" if is_table else "record" if name.endswith(".json") else "line"
    number = f"{unit} {line - is_table}, " if line > 0 else ""
    return f"{number}recording {recording}, frame {frame}"


def place_of_frame(dataset: Dataset, frame_index: int, *, line: int = 0, file: str = "") -> str:
    """Describe the location (see `place`) of a row of the frames table."""
    frames = dataset.frame_columns
    name = dataset.recordings["name"].iloc[int(frames.recording[frame_index])]
    return place(name, int(frames.frame[frame_index]), line=line, file=file)


def recording_findings(
    dataset: Dataset,
    severity: Severity,
    code: str,
    subject: str,
    recordings: np.ndarray,
    what: str,
    advice: str,
    *,
    frame_index: int | None = None,
    frame_rows: np.ndarray | None = None,
    steps: tuple[Step, ...] = (),
) -> list[Finding]:
    """Return a finding about some recordings with the first as example, or none without any.

    Parameters
    ----------
    recordings
        Rows of the recordings table.
    what
        Text that completes "... recordings have".
    frame_index
        Row of the frame used as example; None: the recording is the example.
    frame_rows
        Row of the frame to look at in each recording; None: its first frame.
    """
    if not len(recordings):
        return []
    names = dataset.recordings["name"].iloc[recordings]
    having = count_text(len(recordings), "recording has", "recordings have")
    if frame_rows is None:
        first = dataset.frame_columns.first
        frame_rows = first[recordings][first[recordings] < first[recordings + 1]]
    return [
        Finding(
            severity=severity,
            code=code,
            subject=subject,
            count=len(recordings),
            message=f"{having} {what}: {spelled(names)}.",
            advice=advice,
            example=f"recording {names.iloc[0]}"
            if frame_index is None
            else place_of_frame(dataset, frame_index),
            cases=Cases("frames", frame_rows),
            steps=steps,
        )
    ]


def spelled(names: Iterable[object]) -> str:
    """List the first few names, and count the others."""
    every = [str(name) for name in names]
    names_text, more = ", ".join(every[:MOST_NAMES]), len(every) - MOST_NAMES
    return f"{names_text} and {more} more" if more > 0 else names_text


def without_doubles(names: Iterable[object]) -> list[object]:
    """Return the names in their order, each once."""
    return list(dict.fromkeys(names))
