"""One reader per file format, and the registry that finds the right one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.errors import InputError, UnknownFormatError
from nvcore.readers import (
    bbgt,
    coco,
    coco_results,
    cvat_images,
    cvat_video,
    kaist_results,
    kitti_detections,
    kitti_object,
    kitti_tracking,
    mot,
    plain_csv,
    voc,
    yolo,
)
from nvcore.readers.base import Format, Role, SourceFile

FORMATS: Final[tuple[Format, ...]] = (
    cvat_video.FORMAT,
    cvat_images.FORMAT,
    voc.FORMAT,
    coco.FORMAT,
    coco_results.FORMAT,
    plain_csv.FORMAT,
    bbgt.FORMAT,
    kitti_tracking.FORMAT,
    kitti_object.FORMAT,
    kitti_detections.FORMAT,
    kaist_results.FORMAT,
    mot.FORMAT,
    yolo.FORMAT,
)
"""All formats, in the order in which they are asked whether a content is theirs."""

HEAD_BYTES: Final = 65_536
"""How much of a file is looked at to tell its format."""

MAX_LOOKS: Final = 50
"""How many files are looked at: those of a format with one file a picture may be empty."""


def format_named(name: str) -> Format:
    """The format of a given name.

    Raises
    ------
    UnknownFormatError
        If there is none.
    """
    for candidate in FORMATS:
        if candidate.name == name:
            return candidate
    names = ", ".join(sorted(candidate.name for candidate in FORMATS))
    raise UnknownFormatError(f"there is no format {name!r}; the formats are {names}")


def detect_format(files: Sequence[SourceFile], role: Role) -> Format:
    """The format of some files, told from the content of the first that is not empty.

    Raises
    ------
    UnknownFormatError
        If no reader recognises it, or all are empty.
    InputError
        If a file cannot be opened.
    """
    for file in files[:MAX_LOOKS]:
        head = _head(file)
        if not head.strip():
            continue
        for candidate in FORMATS:
            if role in candidate.roles and candidate.recognise(file.name, head, role):
                return candidate
        first = head.strip().splitlines()[0][:60]
        readable = ", ".join(c.name for c in FORMATS if role in c.roles)
        raise UnknownFormatError(
            f"no reader recognises this as {role}; it begins with {first!r}. Name the format with "
            f"--format (one of {readable})",
            file=file.name,
        )
    raise UnknownFormatError(
        "the format cannot be told from empty files; name it with --format",
        file=files[0].name if files else None,
    )


def _head(file: SourceFile) -> str:
    try:
        with file.path.open("rb") as stream:
            content = stream.read(HEAD_BYTES)
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=file.name) from error
    return content.decode("utf-8-sig", errors="replace")
