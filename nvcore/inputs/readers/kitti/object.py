"""KITTI object labels and results: 15 or 16 fields a row, one file per image."""

from __future__ import annotations

from collections.abc import Sequence

from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    conversion_text,
    recordings_table,
)
from nvcore.inputs.readers.kitti.label import FIELDS, label_boxes
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.inputs.readers.parse.text import TextLayout, read_numbers, stacked
from nvcore.inputs.readers.parse.unknown import foreign_format

LAYOUT = TextLayout((15, 16), FIELDS, delimiter=" ", label_at=0)


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether the rows have 15 or 16 fields: a type and numbers, and no id as DeepStream's have."""
    del name, role
    return LAYOUT.fits(head) and foreign_format(head) is None


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
    named = listed_frames(files, options)
    table = stacked([read_numbers(file, LAYOUT) for file in files])
    boxes, choice, facts = label_boxes(table, named.table.iloc[table.lines.file], options)
    return Reading(
        boxes=boxes,
        recordings=recordings_table(named.recording),
        conversion=conversion_text(["frame numbers from the file names", *facts]),
        images=named.images,
        named=named,
        findings=choice.findings,
        left_out=choice.left_out,
        layout="corners",
    )


FORMAT = Format("kitti-object", "KITTI object", BOTH_ROLES, (".txt",), recognise, read)
