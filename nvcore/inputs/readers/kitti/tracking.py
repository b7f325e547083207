"""KITTI tracking labels and results: 17 or 18 fields a row, one file per recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    conversion_text,
    object_array,
    recordings_table,
)
from nvcore.inputs.readers.kitti.label import FIELDS, label_boxes
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.parse.text import TextLayout, read_numbers, stacked, whole_numbers
from nvcore.schema import NO_TRACK

LAYOUT = TextLayout((17, 18), f"frame id {FIELDS}", delimiter=" ", label_at=2, whole=(0, 1))


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether the rows have 17 or 18 fields: whole frame and id, a type, numbers."""
    del name, role
    return LAYOUT.fits(head)


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
    table = stacked([read_numbers(file, LAYOUT) for file in files])
    frame = whole_numbers(table.columns[0], table.lines, "frame")
    track = whole_numbers(table.columns[1], table.lines, "id")
    places = pd.DataFrame({"recording": object_array(names)[table.lines.file], "frame": frame})
    boxes, choice, facts = label_boxes(
        table, places, options, track=np.where(track < 0, NO_TRACK, track)
    )
    return Reading(
        boxes=boxes,
        recordings=recordings_table(names),
        conversion=conversion_text(["frame numbers kept (0-based)", *facts, *assumed]),
        annotated=places.drop_duplicates(ignore_index=True),
        findings=choice.findings,
        left_out=choice.left_out,
        layout="corners",
    )


FORMAT = Format("kitti-tracking", "KITTI tracking", BOTH_ROLES, (".txt",), recognise, read)
