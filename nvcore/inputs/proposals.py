"""What a person probably means, or needs: proposed, never taken without a word."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from nvcore.errors import NvcoreError
from nvcore.inputs.files import find_files
from nvcore.inputs.readers.base import BOTH_ROLES, Format, Role
from nvcore.inputs.session import Source

KITTI_SIZES: Final = ((1242, 375), (1241, 376), (1238, 374), (1224, 370))
"""Sizes of the recordings of KITTI, the usual one first."""


@dataclass(frozen=True)
class UsualInputs:
    """What most recordings in a format have, and which other sizes (px) there are.

    Without a frame rate (1/s) they are single pictures; `others` is empty where all have the size.
    `note` says where the size is from if it is
    not the usual one.
    """

    size: tuple[int, int]
    fps: float | None
    name: str
    others: str
    note: str = ""


_USUAL, *_OTHERS = KITTI_SIZES
_OF_KITTI: Final = ("KITTI", " or ".join(f"{w} × {h}" for w, h in sorted(_OTHERS)))
USUAL_INPUTS: Final = {
    "kitti-tracking": UsualInputs(_USUAL, 10.0, *_OF_KITTI),
    "kitti-object": UsualInputs(_USUAL, None, *_OF_KITTI),
    "gtsdb": UsualInputs((1360, 800), None, "the German Traffic Sign Detection Benchmark", ""),
}
"""By the name of the format."""


def looks_like(path: Path) -> tuple[Format, Role] | None:
    """The format of annotations that a file or folder is in, and what it holds; None: none.

    What may be both is taken for ground truth.
    """
    for role in BOTH_ROLES:
        try:
            files, file_format = find_files(Source((str(path),)), Path.cwd(), role)
        except NvcoreError:
            continue
        if files and file_format.name != "empty":
            return file_format, role
    return None
