"""KAIST result text (one file for all images) and Caltech detection text (one per recording).

Both have rows of six numbers: ``image_number,x,y,w,h,score`` and ``frame,x,y,w,h,score``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import PurePosixPath

import numpy as np
import pandas as pd

from nvcore.errors import InputError, MissingFactError
from nvcore.file_kinds import unpacked_name
from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    concat_boxes,
    conversion_text,
    recordings_table,
)
from nvcore.inputs.readers.meaning.names import known_recording
from nvcore.inputs.readers.parse.text import (
    NumberTable,
    TextLayout,
    number_of,
    read_numbers,
    rows_of_text,
    whole_numbers,
)

LAYOUT = TextLayout((6,), "image number or frame,x,y,w,h,score", whole=(0,))
_SEQUENCE = re.compile(r"V\d+", re.IGNORECASE)


def recognise(_name: str, head: str, role: Role) -> bool:
    """Whether the rows have 6 numbers, the first of them whole and at least 1.

    Corners (``frame,x1,y1,x2,y2,score``) look the same: ``kitti-detections`` is tried first.
    """
    n_rows = 50
    return (
        role == "detections"
        and LAYOUT.fits(head, n_rows=n_rows)
        and all((number_of(row[0]) or 0) >= 1 for row in rows_of_text(head)[:n_rows])
    )


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read KAIST results by the truth's image list, Caltech detections by their file names.

    A file that is named by a recording (``set06/V000.txt``) is Caltech's: its frames are 1-based
    and become the 0-based numbers of the pictures (I00000 is the first), unless
    `ReadOptions.frame_base` is 0. Any other file is KAIST's: the image number is the 1-based
    position in the truth's image list. Boxes are x, y, w, h in pixels already.

    Raises
    ------
    MissingFactError
        If there is no image list for KAIST results.
    InputError
        If two files are of one recording.
    FormatError
        With file and line of the first row that is neither.
    """
    tables: list[pd.DataFrame] = []
    names: list[str] = []
    findings: list[Finding] = []
    facts = ["x, y, w, h in pixels kept as they are"]
    first_of: dict[str, str] = {}
    for number, file in enumerate(files):
        table = read_numbers(file, LAYOUT)
        numbers, *box, score = table.columns
        index = whole_numbers(numbers, table.lines, "image number or frame")
        recording = _sequence_of(file.name, options.recordings)
        if recording is not None:
            if recording in first_of:
                raise InputError(
                    f"holds recording {recording!r}, as {first_of[recording]} does; expected one "
                    "file per recording: leave one of the two out",
                    file=file.name,
                )
            first_of[recording] = file.name
            base = 1 if options.frame_base is None else options.frame_base
            facts.append(f"frames from {base}-based to 0-based; recordings from the file names")
            tables.append(
                table.lines.boxes(
                    box, recording=recording, frame=index - base, score=score, file=number
                )
            )
            names.append(recording)
            continue
        images = options.images
        if images is None or images.empty:
            raise MissingFactError(
                "these are results by image number: the truth's image list is needed to tell "
                "recording and frame. Give a truth that lists its images (COCO, bbGt); or, if the "
                "first column is the frame, name the file by its recording, as in set06/V000.txt",
                file=file.name,
            )
        position, fact = _positions(index, images)
        facts.append(fact)
        is_listed = position >= 0
        findings += _unlisted(table, index, is_listed, len(images))
        tables.append(
            table.lines.boxes(
                box,
                keep=is_listed,
                recording=images["recording"].to_numpy()[position],
                frame=images["frame"].to_numpy()[position],
                score=score,
                file=number,
            )
        )
        names += images["recording"].tolist()
    return Reading(
        boxes=concat_boxes(tables),
        recordings=recordings_table(names),
        conversion=conversion_text(facts),
        findings=tuple(findings),
        usual={"frame_base": 1} if first_of else {},
    )


def _sequence_of(name: str, known: tuple[str, ...]) -> str | None:
    """Recording that a file is named by; None for a file that holds all images."""
    path = PurePosixPath(unpacked_name(name))
    parts = (*path.parts[:-1], path.stem)
    # the file's own name must be part of it: a folder is often called by the data set
    for start in range(len(parts)):
        recording = known_recording(("/".join(parts[start:]),), known)
        if recording is not None:
            return recording
    if not _SEQUENCE.fullmatch(path.stem):
        return None
    folder = path.parent.name
    return f"{folder}/{path.stem}" if folder.lower().startswith("set") else path.stem


def _positions(index: np.ndarray, images: pd.DataFrame) -> tuple[np.ndarray, str]:
    """0-based rows of the image list, -1 where an image number is not on it."""
    if not len(index) or index.max() <= len(images):
        position = np.where(index >= 1, index - 1, -1)
        return position, "image number = 1-based position in the truth's image list"
    # a truth that is a part of the set (the night, say) keeps the ids of the whole
    ids = pd.to_numeric(images["image_id"], errors="coerce").to_numpy(dtype=float)
    place = pd.Series(np.arange(len(ids)), index=ids).loc[lambda s: ~s.index.duplicated()]
    position = place.reindex((index - 1).astype(float), fill_value=-1).to_numpy()
    return position, "image number = image id + 1 (the numbers exceed the truth's image list)"


def _unlisted(
    table: NumberTable, index: np.ndarray, is_listed: np.ndarray, n_images: int
) -> list[Finding]:
    """Rows whose image number is not on the truth's list."""
    return table.lines.finding(
        ~is_listed,
        "unknown-image",
        f"Rows whose image number is not on the truth's list of {n_images} images were left out.",
        "Give the truth that these results were made for; image numbers count from 1.",
        role="detections",
        example=lambda row: f"image number {index[row]}",
        severity=Severity.ERROR,
    )


FORMAT = Format(
    "kaist-results",
    "KAIST results or Caltech detections",
    ("detections",),
    (".txt", ".csv"),
    recognise,
    read,
)
