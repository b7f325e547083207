"""One reader per file format, and the registry that finds the right one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.common.errors import UnknownFormatError
from nvcore.common.file_kinds import binary_kind
from nvcore.common.findings import Remedy, Step
from nvcore.common.wording import did_you_mean
from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    reading_boxes,
    recordings_table,
)
from nvcore.inputs.readers.caltech import BBGT, KAIST_RESULTS
from nvcore.inputs.readers.coco.results import FORMAT as COCO_RESULTS
from nvcore.inputs.readers.coco.truth import FORMAT as COCO
from nvcore.inputs.readers.csv import FORMAT as PLAIN_CSV
from nvcore.inputs.readers.csv.columns import read_header
from nvcore.inputs.readers.cvat.images import FORMAT as CVAT_IMAGES
from nvcore.inputs.readers.cvat.video import FORMAT as CVAT_VIDEO
from nvcore.inputs.readers.gtsdb import FORMAT as GTSDB
from nvcore.inputs.readers.kitti import KITTI_DETECTIONS, KITTI_OBJECT, KITTI_TRACKING
from nvcore.inputs.readers.meaning.classes import is_class_file
from nvcore.inputs.readers.mot import BOXMOT
from nvcore.inputs.readers.mot import FORMAT as MOT
from nvcore.inputs.readers.parquet import FORMAT as PARQUET
from nvcore.inputs.readers.parse.unknown import describe_foreign, foreign_format
from nvcore.inputs.readers.visdrone import FORMAT as VISDRONE
from nvcore.inputs.readers.voc import FORMAT as VOC
from nvcore.inputs.readers.yolo import FORMAT as YOLO

FORMATS: Final[tuple[Format, ...]] = (
    CVAT_VIDEO,
    CVAT_IMAGES,
    VOC,
    COCO,
    COCO_RESULTS,
    PLAIN_CSV,
    PARQUET,
    BBGT,
    GTSDB,
    KITTI_TRACKING,
    KITTI_OBJECT,
    KITTI_DETECTIONS,
    KAIST_RESULTS,
    VISDRONE,
    MOT,
    BOXMOT,
    YOLO,
)
"""All formats, in the order in which content is tested for them."""

_HOLDS: Final[dict[Role, str]] = {
    "truth": "ground truth",
    "detections": "the detections of a system",
}


_TABLE: Final[dict[Role, str]] = {
    "truth": "frame,x,y,w,h,track,class",
    "detections": "frame,x,y,w,h,score,class",
}
"""Header of plain CSV for a role, which users can convert other files to."""


def _read_nothing(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Return a reading without boxes for the recordings of the truth."""
    title = "empty file" if len(files) == 1 else "empty files"
    return Reading(
        reading_boxes(0), recordings_table(options.recordings), f"{title}: no detections"
    )


NOTHING: Final = Format(
    "empty",
    "empty",
    ("detections",),
    suffixes=(),
    recognise=lambda _name, _head, _role: False,
    read=_read_nothing,
)
"""Empty files of a system that detected nothing, in any format (see `holds_nothing`).

It is not in `FORMATS`, since it has no name for ``--format``.
"""

HEAD_BYTES: Final = 65_536
"""Bytes of a file that are read to recognise its format."""

MAX_LOOKS: Final = 50
"""Number of files to test. With one file per picture, the first ones may be empty."""


def format_named(name: str) -> Format:
    """Return the format of a given name.

    Raises
    ------
    UnknownFormatError
        If there is no such format.
    """
    for candidate in FORMATS:
        if candidate.name == name:
            return candidate
    titles = {candidate.name: candidate.title for candidate in FORMATS}
    known = ", ".join(f"{name} ({titles[name]})" for name in sorted(titles))
    hint = did_you_mean(name.lower(), titles, f"the formats are {known}")
    raise UnknownFormatError(f"there is no format {name!r}; {hint}")


def detect_format(files: Sequence[SourceFile], role: Role) -> Format:
    """Detect the format of files from the content of the first that is not empty.

    Raises
    ------
    UnknownFormatError
        If no reader recognises it, or all are empty.
    InputError
        If a file cannot be opened.
    """
    # files of class names do not tell the format of the labels
    by_use = sorted(files[:MAX_LOOKS], key=lambda file: is_class_file(file.name))
    for file in by_use:
        content = _head(file)
        head = content.decode("utf-8-sig", errors="replace")
        if not head.strip():
            continue
        for candidate in FORMATS:
            if role in candidate.roles and candidate.recognise(file.name, head, role):
                return candidate
        text = _recognised(file, content, head, role)
        steps = [] if binary_kind(content) else [Step(Remedy.TABLE, _TABLE[role])]
        if not text:
            first = head.strip().splitlines()[0][:60]
            readable = ", ".join(c.name for c in FORMATS if role in c.roles)
            text = f"no reader recognises this as {role}; it begins with {first!r}. "
            text += f"Name the format, one of {readable}"
            steps.insert(0, Step(Remedy.FORMAT))
        raise UnknownFormatError(text, file=file.name, steps=tuple(steps))
    raise UnknownFormatError(
        f"the format cannot be told: the first {len(files[:MAX_LOOKS])} files are empty",
        file=files[0].name if files else None,
        steps=(Step(Remedy.FORMAT),),
    )


def formats_like(file: SourceFile, role: Role) -> list[Format]:
    """List all formats that the content of a file matches.

    Raises
    ------
    InputError
        If the file cannot be opened.
    """
    head = _head(file).decode("utf-8-sig", errors="replace")
    return [of for of in FORMATS if role in of.roles and of.recognise(file.name, head, role)]


def holds_nothing(files: Sequence[SourceFile]) -> bool:
    """Whether there are files and all contain only white space.

    Raises
    ------
    InputError
        If a file cannot be opened.
    """
    return bool(files) and all(not _head(file).strip() for file in files)


def _recognised(file: SourceFile, content: bytes, head: str, role: Role) -> str:
    """Describe a file that no format accepts in this role, or return an empty text."""
    kind = binary_kind(content)
    if kind is not None:
        return f"expected {_HOLDS[role]}, found {kind}"
    known = foreign_format(head)
    if known is not None:
        return f"no reader recognises this as {role}: it is {known}"
    other: Role = "detections" if role == "truth" else "truth"
    for candidate in FORMATS:
        if role not in candidate.roles and candidate.recognise(file.name, head, other):
            return f"expected {_HOLDS[role]}, found {candidate.title}, which holds {_HOLDS[other]}"
    header = read_header(head.partition("\n")[0])
    if header.has_box and not header.has_frame:
        return (
            f"no reader recognises this as {role}: a table of boxes with the columns "
            f"{', '.join(header.names)}, and none is the frame's number (frame) or the picture's "
            "name (file_name); call the one that is so"
        )
    foreign = describe_foreign(file, head, role)
    return "" if foreign is None else f"no reader recognises this as {role}: it is {foreign}"


def _head(file: SourceFile) -> bytes:
    """Read the first `HEAD_BYTES` of a file."""
    with file.open() as stream:
        return stream.read(HEAD_BYTES)
