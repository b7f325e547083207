"""YOLO text: one file per picture, rows of class, centre and size in shares of the picture."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath
from typing import Final

import numpy as np

from nvcore.common.errors import FormatError, InputError, MissingFactError
from nvcore.common.findings import Finding
from nvcore.common.wording import shortened
from nvcore.dataset.schema import NO_TRACK
from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    object_array,
)
from nvcore.inputs.readers.meaning.classes import (
    NumberedRows,
    choose_categories,
    class_names_beside,
    is_class_file,
    last_part,
    names_of_numbers,
)
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.inputs.readers.parse.rows import choice_of_rows, rows_reading
from nvcore.inputs.readers.parse.text import (
    NumberTable,
    TextLayout,
    are_numbers,
    is_whole,
    number_of,
    read_numbers,
    read_text,
    rows_of_text,
    stacked,
    whole_numbers,
)

LAYOUT = TextLayout((5, 6, 7), "class x y width height [confidence]", delimiter=" ")
MAX_SHARE: Final = 2.0
"""Largest coordinate, in shares of the picture, of boxes that extend beyond it."""
_INSIDE: Final = 0.01
"""Share of the picture by which a box inside it may extend beyond it."""
_OTHER_FILES = re.compile(r".*\.ya?ml|(?:train|val|valid|test)\.txt|.*\.data|.*\.cache")


def recognise(name: str, head: str, _role: Role) -> bool:
    """Whether rows are a class number and 4 to 6 numbers, of which the first four are shares.

    A list of class names matches, too, since it may precede the first picture's file in a folder.
    """
    if _is_extra(name):
        return is_class_file(name)
    rows = rows_of_text(head, delimiter=" ")[:20]
    are_long = any(len(row) > max(LAYOUT.n_columns) for row in rows)  # polygons
    if are_long and not (
        all(len(row) >= LAYOUT.n_columns[0] and are_numbers(row) for row in rows)
        and not all(is_whole(field) for row in rows for field in row)
    ):
        return False
    return (are_long or LAYOUT.fits(head)) and all(
        row[0].isdecimal()
        and all(
            0 <= (number_of(share) or 0) <= 1.1 for share in (row[1:] if are_long else row[1:5])
        )
        for row in rows
    )


@dataclass(frozen=True)
class _Fields:
    """Fields of all rows by their meaning, which is inferred from the content."""

    middle_and_size: list[np.ndarray]
    score: np.ndarray
    track: np.ndarray
    facts: tuple[str, ...]
    findings: tuple[Finding, ...]
    is_score_first: bool = False
    has_score_beside: bool = False


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read YOLO text files, one per picture. Empty files are evaluated frames, too.

    The classes named as pedestrians in a file beside the labels count, or the only class.
    The confidence is the last field (Ultralytics) or the second (review_object_detection_metrics),
    whichever keeps the boxes inside the picture.
    """
    frames = [file for file in files if not _is_extra(file.name)]
    position = np.array([i for i, file in enumerate(files) if not _is_extra(file.name)], np.int64)
    if not frames:
        raise InputError(
            "expected one text file per picture, found none", file=files[0].name if files else None
        )
    named = listed_frames(frames, options)
    if options.size is None:
        raise MissingFactError(
            "YOLO text holds shares of the picture's width and height: the size of the pictures is "
            "needed",
            file=files[0].name if files else None,
            facts=("size",),
        )
    own = class_names_beside(files)
    table, has_polygons = _rows_of(frames)
    _check_shares(table)
    fields = _identified(table, options)
    numbered = NumberedRows.of(whole_numbers(table.columns[0], table.lines, "class number"))
    counts = numbered.counts
    by_number = names_of_numbers(counts, own, options, "list")
    by_class = choose_categories(counts, by_number, options, file=frames[0].name)
    choice = choice_of_rows(numbered, by_class)
    # a number alone does not identify a class across files
    label = object_array([by_number.names.get(key, "") for key in numbered.keys])[numbered.codes]
    width, height = options.size
    x, y, w, h = fields.middle_and_size
    passed = sorted({PurePosixPath(of.name).name for of in files if _is_extra(of.name)})
    facts = [
        "frame numbers from the file names",
        f"shares of the picture to pixels of {width} x {height} (0-based)",
        "polygons to the boxes around them" if has_polygons else "",
        *fields.facts,
        choice.fact,
        f"not read as pictures: {', '.join(passed)}" if passed else "",
    ]
    reading = rows_reading(
        table.lines,
        ((x - w / 2) * width, (y - h / 2) * height, w * width, h * height),
        choice,
        named,
        options,
        facts,
        findings=fields.findings,
        kind=label,
        layout="score-centres-shares" if fields.is_score_first else "centres-shares",
        score=fields.score,
        track=fields.track,
        file=position[table.lines.file],
    )
    return replace(
        reading,
        recordings=reading.recordings.assign(width=float(width), height=float(height)),
        classes=by_class.classes,
        has_score_beside=fields.has_score_beside,
        categories=own.names,
        numbering="list",
    )


def _is_extra(name: str) -> bool:
    """Whether the file is not of a picture: names of classes, lists of files, settings."""
    return is_class_file(name) or _OTHER_FILES.fullmatch(last_part(name)) is not None


def _rows_of(frames: Sequence[SourceFile]) -> tuple[NumberTable, bool]:
    """Read rows of all files, with boxes around polygons, and whether there are polygons."""
    try:
        table = stacked([read_numbers(frame, LAYOUT) for frame in frames])
        last = table.columns[-1][~np.isnan(table.columns[-1])]
        # three corners without a track id
        has_polygons = bool(np.any(last != np.floor(last)) and np.all(last <= 1))
    except FormatError:
        if not any(_is_polygon(line.split()) for f in frames for line in read_text(f).splitlines()):
            raise
        has_polygons = True
    return (stacked([*map(_around_polygons, frames)]) if has_polygons else table), has_polygons


def _is_polygon(fields: Sequence[str]) -> bool:
    return len(fields) > max(LAYOUT.n_columns) and are_numbers(fields)


def _around_polygons(file: SourceFile) -> NumberTable:
    """Read rows of a class, corners x y x y ..., and an optional confidence, as boxes."""
    rows, lines = [], []
    for line, text in enumerate(read_text(file).splitlines(), 1):  # of any number of corners
        numbers = [number_of(field) for field in text.split()]
        if not numbers:
            continue
        if None in numbers or len(numbers) < LAYOUT.n_columns[0]:
            raise file.fault(f"expected a class and corners, found {shortened(text, 60)!r}", line)
        row = np.array(numbers, dtype=float)
        if len(row) > 6:
            has_score = len(row) % 2 == 0
            corners = row[1 : len(row) - has_score].reshape(-1, 2)
            low, high = corners.min(axis=0), corners.max(axis=0)
            row = np.array([row[0], *(low + high) / 2, *high - low, *row[-1:][:has_score]])
        rows.append(np.append(row, [np.nan] * (LAYOUT.n_numbers - len(row))))
        lines.append(line)
    columns = np.array(rows).reshape(-1, LAYOUT.n_numbers).T
    return NumberTable([*columns], Lines.of(file, np.array(lines, np.int64)))


def _check_shares(table: NumberTable) -> None:
    """Raise FormatError for the first row with a coordinate that cannot be a share."""
    values = np.column_stack(table.columns[1:5])
    with np.errstate(invalid="ignore"):
        is_wrong = np.abs(values) > MAX_SHARE
    table.lines.refuse(
        is_wrong.any(axis=1),
        lambda row: (
            f"expected shares of the picture in 0..1 ({LAYOUT.what}), found "
            f"{values[row][is_wrong[row]][0]:g}; are these pixels?"
        ),
    )


def _identified(table: NumberTable, options: ReadOptions) -> _Fields:
    """Identify the fields of the box, the confidence and the track id."""
    second, third, fourth, fifth, sixth, seventh = table.columns[1:]
    box, score, track = [second, third, fourth, fifth], sixth, seventh
    has_sixth, has_seventh = ~np.isnan(sixth), ~np.isnan(seventh)
    facts: list[str] = []
    findings: list[Finding] = []
    n_last = n_second = 0
    has_score_beside = False
    if has_seventh.any():
        facts.append("confidence last but one, track id last")
    elif has_sixth.any() and _are_ids(sixth[has_sixth]):
        score, track = np.full(len(table), np.nan), sixth
        facts.append("last field = track id; no scores")
    elif has_sixth.any():
        has_score_beside = True
        n_last = _n_outside([column[has_sixth] for column in box])
        shifted = [third, fourth, fifth, sixth]
        n_second = _n_outside([column[has_sixth] for column in shifted])
        if n_second < n_last:
            # rows of five fields have no confidence, so they keep their positions
            box = [np.where(has_sixth, s, b) for s, b in zip(shifted, box, strict=True)]
            score = np.where(has_sixth, second, np.nan)
        facts.append(f"confidence in the {'second' if n_second < n_last else 'last'} field")
        if n_last == n_second:
            facts[-1] += " (could not be told from the content)"
            findings = table.lines.finding(
                has_sixth,
                "confidence-field",
                "Whether the confidence is the last field or the second cannot be told from the "
                "rows; it was taken as the last.",
                "Check that the boxes lie where they should.",
                role=options.role,
            )
    ids = np.full(len(table), NO_TRACK, dtype=np.int64)
    has_track = ~np.isnan(track)
    ids[has_track] = whole_numbers(track[has_track], table.lines[has_track], "track id")
    return _Fields(
        box,
        score,
        np.maximum(ids, NO_TRACK),
        tuple(facts),
        tuple(findings),
        is_score_first=n_second < n_last,
        has_score_beside=has_score_beside,
    )


def _are_ids(values: np.ndarray) -> bool:
    """Whether the last field is a tracker's id: whole numbers, some above 1."""
    return bool(np.all(values == np.floor(values)) and values.max() > 1)


def _n_outside(box: Sequence[np.ndarray]) -> int:
    """Count boxes that extend beyond the picture or have no area."""
    x, y, w, h = box
    with np.errstate(invalid="ignore"):
        inside = (
            (x - w / 2 >= -_INSIDE)
            & (x + w / 2 <= 1 + _INSIDE)
            & (y - h / 2 >= -_INSIDE)
            & (y + h / 2 <= 1 + _INSIDE)
            & (w > 0)
            & (h > 0)
        )
    return int((~inside).sum())


FORMAT = Format("yolo", "YOLO text", BOTH_ROLES, (".txt",), recognise, read)
