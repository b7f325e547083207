"""KITTI tracking labels and results: 17 or 18 fields a row, one file per recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    annotated_frames,
    recording_row,
    recordings_table,
)
from nvcore.inputs.readers.kitti.label import FIELDS, label_boxes
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.parse.text import (
    are_numbers,
    is_whole,
    read_numbers,
    rows_of_text,
    stacked,
    whole_numbers,
)
from nvcore.schema import NO_TRACK

WHAT = f"frame id {FIELDS}"


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether the rows have 17 or 18 fields: whole frame and id, a type, numbers."""
    del name, role
    rows = rows_of_text(head, delimiter=" ")[:20]
    return bool(rows) and all(
        len(row) in (17, 18)
        and is_whole(row[0])
        and is_whole(row[1])
        and not are_numbers(row[2:3])
        and are_numbers(row[3:])
        for row in rows
    )


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read KITTI tracking files, one per recording.

    Frames and pixels are 0-based, corners inclusive. Pedestrian counts, Person and Person_sitting
    (neutral in KITTI's evaluation) and DontCare are ignore regions, other types are left out. The
    camera's Z becomes the distance.

    Raises
    ------
    InputError
        If two files are of one recording, or a class is unknown.
    FormatError
        With file and line of the first row that is not KITTI tracking.
    """
    names, assumed = recordings_of([file.name for file in files], options.recordings)
    tables = [
        read_numbers(file, n_columns=(17, 18), delimiter=" ", what=WHAT, label_at=2)
        for file in files
    ]
    pairs = list(zip(files, tables, strict=True))
    frame = np.concatenate([whole_numbers(t.columns[0], f, t.line, "frame") for f, t in pairs])
    track = np.concatenate([whole_numbers(t.columns[1], f, t.line, "id") for f, t in pairs])
    table, file = stacked(tables)
    recording = np.array(names, dtype=object)[file]
    boxes, choice, facts = label_boxes(
        table,
        options,
        files=files,
        file=file,
        recording=recording,
        frame=frame,
        track=np.where(track < 0, NO_TRACK, track),
    )
    return Reading(
        boxes=boxes,
        recordings=recordings_table([recording_row(name) for name in names]),
        conversion="; ".join(["frame numbers kept (0-based)", *facts, *assumed]),
        annotated=annotated_frames(recording, frame),
        findings=choice.findings,
    )


FORMAT = Format(
    name="kitti-tracking",
    title="KITTI tracking",
    roles=("truth", "detections"),
    suffixes=(".txt",),
    recognise=recognise,
    read=read,
)
