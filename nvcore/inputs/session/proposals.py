"""Suggestions for inputs: usual sizes and formats, which the user has to confirm."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from nvcore.common.errors import NvcoreError
from nvcore.inputs.files.find import find_files
from nvcore.inputs.readers.base import BOTH_ROLES, Format, Role
from nvcore.inputs.session import Source

KITTI_SIZES: Final = ((1242, 375), (1241, 376), (1238, 374), (1224, 370))
"""Sizes of the recordings of KITTI, the usual one first."""


@dataclass(frozen=True)
class UsualInputs:
    """Usual picture size (px) and frame rate (1/s) of recordings in a format.

    The frame rate is None for single pictures. `others` lists other sizes, if there are any.
    `note` names the source of the size if it is not the usual one.
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
    """Detect the annotation format and role of a file or folder, or return None.

    Ground truth takes precedence if both roles are possible.
    """
    for role in BOTH_ROLES:
        try:
            files, file_format = find_files(Source((str(path),)), Path.cwd(), role)
        except NvcoreError:
            continue
        if files and file_format.name != "empty":
            return file_format, role
    return None
