"""Pedestrian detections on KITTI tracking, comma-separated: 6 columns, or AB3DMOT's 15."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from nvcore.findings import Finding
from nvcore.inputs.readers.base import (
    Format,
    LeftOut,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    conversion_text,
    object_array,
    recordings_table,
)
from nvcore.inputs.readers.kitti.label import CORNERS, DISTANCE, box_of_corners
from nvcore.inputs.readers.meaning.classes import ClassRule, choose_classes, rule_for
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.meaning.values import known_distances
from nvcore.inputs.readers.parse.text import (
    NumberTable,
    TextLayout,
    are_numbers,
    is_whole,
    number_of,
    read_numbers,
    rows_of_text,
    stacked,
    whole_numbers,
)

LAYOUT = TextLayout(
    (6, 15), "frame,x1,y1,x2,y2,score or frame,type,x1,y1,x2,y2,score,h,w,l,X,Y,Z,ry,alpha"
)
TYPES = {1: "Pedestrian", 2: "Car", 3: "Cyclist"}
"""Type numbers of the 15-column layout."""
RULE = ClassRule(counted=("Pedestrian",), ignored=(), left_out=("Car", "Cyclist"))


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether all rows have 15 numbers, or all have 6 with x2 > x1 and y2 > y1 throughout.

    Rows of 6 could be ``frame,x,y,w,h,score`` as well; there, sizes that exceed the positions in
    every single row do not occur.
    """
    del name
    if role != "detections":
        return False
    rows = rows_of_text(head)
    if not rows or len(rows[0]) not in (6, 15):
        return False
    n_columns = len(rows[0])
    if any(len(row) != n_columns or not are_numbers(row) for row in rows):
        return False
    if not all(is_whole(row[0]) and (n_columns == 6 or is_whole(row[1])) for row in rows):
        return False
    if n_columns == 15:
        return True
    edges = np.array([[number_of(field) for field in row[1:5]] for row in rows], dtype=float)
    return _first_without_corners(*edges.T) is None


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read KITTI detections, one file per recording.

    Frames and pixels are 0-based, corners inclusive. In the 15-column layout type 1 (Pedestrian)
    counts, other types are left out, and the camera's Z becomes the distance.

    Raises
    ------
    InputError
        If two files are of one recording, or a class is unknown.
    FormatError
        With file and line of the first row that has other columns, or no corners.
    """
    names, assumed = recordings_of([file.name for file in files], options.recordings)
    facts = ["frame numbers kept (0-based)", CORNERS]
    tables = [read_numbers(file, LAYOUT) for file in files]
    for part in tables:
        _check(part)
    table = stacked(tables)
    frame = whole_numbers(table.columns[0], table.lines, "frame")
    is_long = _is_long(table)
    # the long layout has the type between frame and corners
    left, top, right, bottom, score = (
        np.where(is_long, table.columns[i + 1], table.columns[i]) for i in range(1, 6)
    )
    keep = np.ones(len(table), dtype=bool)
    findings: tuple[Finding, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    if is_long.any():
        options_by_name = replace(options, classes=_class_names(options.classes))
        label = _type_names(np.where(is_long, table.columns[1], 1))
        choice = choose_classes(
            label, rule_for(RULE, label, options_by_name), options_by_name, table.lines
        )
        keep, findings, left_out = choice.keep, choice.findings, choice.left_out
        facts += [DISTANCE, choice.fact]
    elif len(table):
        facts.append("columns 2 to 5 taken for corners (x2 > x1 and y2 > y1 in every row)")
    return Reading(
        boxes=table.lines.boxes(
            box_of_corners(left, top, right, bottom),
            keep=keep,
            recording=object_array(names)[table.lines.file],
            frame=frame,
            score=score,
            distance_m=known_distances(table.columns[12]),
        ),
        recordings=recordings_table(names),
        conversion=conversion_text([*facts, *assumed]),
        findings=findings,
        left_out=left_out,
        layout="corners",
    )


def _is_long(table: NumberTable) -> np.ndarray:
    """Whether each row has more than 6 columns; bool, shape (n,)."""
    return np.asarray(~np.isnan(np.stack(table.columns[6:])).all(axis=0))


def _check(table: NumberTable) -> None:
    """Raise FormatError for a file that mixes the layouts or whose 6 columns are no corners."""
    is_long = _is_long(table)
    if not len(table):
        return
    if is_long.any():
        if not is_long.all():
            raise table.lines.fault(
                np.argmax(is_long != is_long[0]),
                "expected the same number of columns in all rows, found both 6 and 15 "
                f"({LAYOUT.what})",
            )
        whole_numbers(table.columns[1], table.lines, "type")
        return
    edges = table.columns[1:5]
    first = _first_without_corners(*edges)
    if first is not None:
        raise table.lines.fault(
            first,
            "expected corners x1,y1,x2,y2 with x2 > x1 and y2 > y1, found "
            f"{','.join(f'{edge[first]:g}' for edge in edges)}; if the columns are x,y,w,h, the "
            "format is kaist-results",
        )


def _first_without_corners(
    left: np.ndarray, top: np.ndarray, right: np.ndarray, bottom: np.ndarray
) -> int | None:
    """First row whose second corner is not to the lower right of the first; NaN rows pass."""
    with np.errstate(invalid="ignore"):
        wrong = (right <= left) | (bottom <= top)
    return int(np.argmax(wrong)) if wrong.any() else None


def _type_names(types: np.ndarray) -> np.ndarray:
    """Name of each row's type, its number where it has none."""
    numbers, rows = np.unique(types.astype(np.int64), return_inverse=True)
    return object_array([TYPES.get(int(n), str(n)) for n in numbers])[rows]


def _class_names(classes: tuple[str, ...] | None) -> tuple[str, ...] | None:
    """Classes by name, where they may be given by number."""
    if classes is None:
        return None
    return tuple(TYPES.get(int(c), c) if c.isdecimal() else c for c in classes)


FORMAT = Format(
    "kitti-detections",
    "KITTI detections, comma-separated",
    ("detections",),
    (".txt", ".csv"),
    recognise,
    read,
)
