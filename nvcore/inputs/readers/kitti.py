"""KITTI: labels and results of tracking and of objects, and detections separated by commas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nvcore.dataset.schema import NO_TRACK
from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    NamedPictures,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    annotated_frames,
    object_array,
)
from nvcore.inputs.readers.meaning.classes import (
    ClassChoice,
    ClassRule,
    by_names,
    choose_classes,
    rule_for,
)
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.meaning.values import known_distances, levels_of_numbers
from nvcore.inputs.readers.parse.rows import rows_reading
from nvcore.inputs.readers.parse.text import (
    NumberTable,
    TextLayout,
    number_of,
    read_numbers,
    rows_of_text,
    stacked,
    whole_numbers,
)
from nvcore.inputs.readers.parse.unknown import foreign_format

FIELDS = "type truncated occluded alpha left top right bottom h w l X Y Z ry [score]"
OBJECT = TextLayout((15, 16), FIELDS, delimiter=" ", label_at=0)
TRACKING = TextLayout((17, 18), f"frame id {FIELDS}", delimiter=" ", label_at=2, whole=(0, 1))
DETECTIONS = TextLayout(
    (6, 15), "frame,x1,y1,x2,y2,score or frame,type,x1,y1,x2,y2,score,h,w,l,X,Y,Z,ry,alpha"
)
_WHOLE = {6: (0,), 15: (0, 1)}
"""Indices of whole-number columns in detections, by the number of columns."""
RULE = ClassRule(
    counted=("Pedestrian",),
    ignored=("Person_sitting", "DontCare"),
    left_out=("Cyclist", "Car", "Van", "Truck", "Tram", "Misc"),
    is_benchmark=True,
)
"""Rule of KITTI's own pedestrian evaluation: a detection of a cyclist is a false alarm."""
TRACKING_RULE = replace(RULE, ignored=("Person", *RULE.ignored))
"""Rule for KITTI's tracking labels, where `Person` is sitting, unlike `person` of other tools."""
TYPES = {1: "Pedestrian", 2: "Car", 3: "Cyclist"}
"""Type numbers of detections with 15 columns."""
TYPES_RULE = ClassRule(counted=("Pedestrian",), ignored=(), left_out=("Car", "Cyclist"))
CORNERS = "boxes from corners (0-based, inclusive)"
DISTANCE = "distance from the camera's Z"


def read_object(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read KITTI object files, one per image. Files without rows are evaluated frames, too.

    Pixels are 0-based, corners inclusive. Pedestrian counts. Person_sitting (neutral in KITTI's
    evaluation) and DontCare are ignore regions. Other types are left out. The camera's Z becomes
    the distance.
    """
    named = listed_frames(files, options)
    table = stacked([read_numbers(file, OBJECT) for file in files])
    return _labels(table, named, options, ["frame numbers from the file names"])


def read_tracking(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read KITTI tracking files, one per recording.

    Frames and pixels are 0-based, corners inclusive. Pedestrian counts. Person and Person_sitting
    (neutral in KITTI's evaluation) and DontCare are ignore regions. Other types are left out. The
    camera's Z becomes the distance.
    """
    names, assumed = recordings_of([file.name for file in files], options.recordings)
    table = stacked([read_numbers(file, TRACKING) for file in files])
    frame = whole_numbers(table.columns[0], table.lines, "frame")
    track = whole_numbers(table.columns[1], table.lines, "id")
    facts = ["frame numbers kept (0-based)", *assumed]
    tracks: dict[str, Any] = {"frame": frame, "track": np.where(track < 0, NO_TRACK, track)}
    reading = _labels(table, names, options, facts, **tracks)
    recording = object_array(names)[table.lines.file]
    return replace(reading, annotated=annotated_frames(recording, frame))


def _labels(
    table: NumberTable,
    places: NamedPictures | Sequence[str],
    options: ReadOptions,
    facts: Sequence[str],
    **columns: Any,
) -> Reading:
    """Make a reading of label rows, which end with the columns of `FIELDS`."""
    assert table.label is not None
    _, occluded, _, left, top, right, bottom, _, _, _, _, _, z, _, score = table.columns[-15:]
    is_kitti = not {"Pedestrian", "DontCare"}.isdisjoint(table.label)
    rule = TRACKING_RULE if is_kitti and "Person" in table.label else RULE
    choice = choose_classes(table.label, rule_for(rule, table.label, options), options, table.lines)
    facts = [
        *facts[:1],
        CORNERS,
        DISTANCE,
        "occluded 0, 1, 2 kept, 3 = unknown",
        choice.fact,
        *facts,
    ]
    has_score = options.role == "detections"
    if has_score and len(table) and np.isnan(score).all():
        facts.append("no score column: no scores")
    return rows_reading(
        table.lines,
        _box_of_corners(left, top, right, bottom),
        choice,
        places,
        options,
        facts,
        layout="corners",
        score=score if has_score else np.nan,
        distance_m=known_distances(z),
        occlusion=levels_of_numbers(occluded),
        **columns,
    )


def _box_of_corners(
    left: np.ndarray, top: np.ndarray, right: np.ndarray, bottom: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Convert corners, which are the first and the last pixel inside, to x, y, w, h."""
    return left, top, right - left + 1, bottom - top + 1


def recognise_detections(_name: str, head: str, role: Role) -> bool:
    """Whether all rows have 15 numbers, or all have 6 with x2 > x1 and y2 > y1.

    Rows of 6 could also be ``frame,x,y,w,h,score``, but there sizes never exceed positions in
    every row.
    """
    n_rows = len(head)  # all of them
    short, long = (replace(DETECTIONS, n_columns=(n,), whole=at) for n, at in _WHOLE.items())
    if role != "detections" or not short.fits(head, n_rows=n_rows):
        return role == "detections" and long.fits(head, n_rows=n_rows)
    rows = rows_of_text(head)
    edges = np.array([[number_of(field) for field in row[1:5]] for row in rows], dtype=float)
    return not _lack_corners(*edges.T).any()


def read_detections(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read KITTI detections, one file per recording.

    Frames and pixels are 0-based, corners inclusive. In the 15-column layout type 1 (Pedestrian)
    counts and other types are left out. The camera's Z becomes the distance.
    """
    names, assumed = recordings_of([file.name for file in files], options.recordings)
    facts = ["frame numbers kept (0-based)", CORNERS]
    tables = [read_numbers(file, DETECTIONS) for file in files]
    for part in tables:
        _check(part)
    table = stacked(tables)
    frame = whole_numbers(table.columns[0], table.lines, "frame")
    is_long = _is_long(table)
    # the long layout has the type between frame and corners
    left, top, right, bottom, score = (
        np.where(is_long, table.columns[i + 1], table.columns[i]) for i in range(1, 6)
    )
    choice = ClassChoice(np.ones(len(table), bool), np.zeros(len(table), bool), "", (), ())
    if is_long.any():
        numbers = np.where(is_long, table.columns[1], 1).astype(np.int64)
        label, by_name = by_names(numbers, TYPES, options)
        choice = choose_classes(label, rule_for(TYPES_RULE, label, by_name), by_name, table.lines)
        choice = replace(choice, ignore=np.zeros(len(table), bool))
        facts += [DISTANCE, choice.fact]
    elif len(table):
        facts.append("columns 2 to 5 are corners (x2 > x1 and y2 > y1 in every row)")
    return rows_reading(
        table.lines,
        _box_of_corners(left, top, right, bottom),
        choice,
        names,
        options,
        [*facts, *assumed],
        layout="corners",
        frame=frame,
        score=score,
        distance_m=known_distances(table.columns[12]),
    )


def _is_long(table: NumberTable) -> np.ndarray:
    """Mark rows with more than 6 columns. Bool, shape (n,)."""
    return np.asarray(~np.isnan(np.stack(table.columns[6:])).all(axis=0))


def _check(table: NumberTable) -> None:
    """Raise FormatError for a file that mixes the layouts or whose 6 columns are not corners."""
    is_long, edges = _is_long(table), table.columns[1:5]
    table.lines.refuse(
        is_long != is_long[:1],
        lambda _row: (
            "expected the same number of columns in all rows, found both 6 and 15 "
            f"({DETECTIONS.what})"
        ),
    )
    whole_numbers(table.columns[1][is_long], table.lines[is_long], "type")
    table.lines.refuse(
        ~is_long & _lack_corners(*edges),
        lambda row: (
            "expected corners x1,y1,x2,y2 with x2 > x1 and y2 > y1, found "
            f"{','.join(f'{edge[row]:g}' for edge in edges)}; if the columns are x,y,w,h, the "
            "format is kaist-results"
        ),
    )


def _lack_corners(
    left: np.ndarray, top: np.ndarray, right: np.ndarray, bottom: np.ndarray
) -> np.ndarray:
    """Mark rows whose second corner is not to the lower right of the first, except NaN."""
    with np.errstate(invalid="ignore"):
        return (right <= left) | (bottom <= top)


KITTI_TRACKING = Format(
    "kitti-tracking",
    "KITTI tracking",
    BOTH_ROLES,
    (".txt",),
    lambda _name, head, _role: TRACKING.fits(head),
    read_tracking,
)
KITTI_OBJECT = Format(
    "kitti-object",
    "KITTI object",
    BOTH_ROLES,
    (".txt",),
    # DeepStream's text with an id has as many fields
    lambda _name, head, _role: OBJECT.fits(head) and foreign_format(head) is None,
    read_object,
)
KITTI_DETECTIONS = Format(
    "kitti-detections",
    "KITTI detections, comma-separated",
    ("detections",),
    (".txt", ".csv"),
    recognise_detections,
    read_detections,
)
