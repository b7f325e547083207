"""KITTI object labels and results: 15 or 16 fields a row, one file per image."""

from __future__ import annotations

from collections.abc import Sequence

from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    recording_row,
    recordings_table,
)
from nvcore.inputs.readers.kitti.label import FIELDS, label_boxes
from nvcore.inputs.readers.meaning.names import listed_frames
from nvcore.inputs.readers.parse.text import are_numbers, read_numbers, rows_of_text, stacked


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether the rows have 15 or 16 fields: a type and numbers."""
    del name, role
    rows = rows_of_text(head, delimiter=" ")[:20]
    return bool(rows) and all(
        len(row) in (15, 16) and not are_numbers(row[:1]) and are_numbers(row[1:]) for row in rows
    )


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read KITTI object files, one per image; a file without rows is an evaluated frame.

    Pixels are 0-based, corners inclusive. Pedestrian counts, Person_sitting (neutral in KITTI's
    evaluation) and DontCare are ignore regions, other types are left out. The camera's Z becomes
    the distance.

    Raises
    ------
    InputError
        If a file name has no number, two files are of one frame, or a class is unknown.
    FormatError
        With file and line of the first row that is not KITTI object.
    """
    images = listed_frames(files, options)
    names = images["recording"].to_numpy()
    table, file = stacked(
        [
            read_numbers(frame_file, n_columns=(15, 16), delimiter=" ", what=FIELDS, label_at=0)
            for frame_file in files
        ]
    )
    boxes, choice, facts = label_boxes(
        table,
        options,
        files=files,
        file=file,
        recording=names[file],
        frame=images["frame"].to_numpy()[file],
    )
    return Reading(
        boxes=boxes,
        recordings=recordings_table([recording_row(name) for name in dict.fromkeys(names)]),
        conversion="; ".join(["frame numbers from the file names", *facts]),
        images=images.sort_values("image_id", ignore_index=True),
        findings=choice.findings,
    )


FORMAT = Format(
    name="kitti-object",
    title="KITTI object",
    roles=("truth", "detections"),
    suffixes=(".txt",),
    recognise=recognise,
    read=read,
)
