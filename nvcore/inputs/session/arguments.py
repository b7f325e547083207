"""The arguments of `nvcore.convert` and ``nvcore convert``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY
from pathlib import Path
from typing import TYPE_CHECKING

import click

from nvcore.common.arguments import OTHER, PathLike, Size, argument, arguments

if TYPE_CHECKING:
    from nvcore.inputs.readers.base import Role
    from nvcore.inputs.session import Source
    from nvcore.settings.objects import Objects


@arguments
class ConvertArguments:
    """Arguments of `nvcore.convert`."""

    source: PathLike | Source
    target: PathLike
    to: str | None = argument(
        OTHER,
        "Format to write. Default: by the ending of OUTPUT: .csv, .parquet, .json (coco), .txt "
        "(mot).",
        default=None,
        type=click.Choice(["csv", "parquet", "coco", "mot"]),
    )
    _: KW_ONLY
    role: Role | None = argument(
        OTHER,
        "What the input holds. Default: truth; an input with scores is refused without it.",
        default=None,
        type=click.Choice(["truth", "detections"]),
    )
    truth: PathLike | Source | None = argument(
        OTHER,
        "Ground truth, for results that name pictures by number.",
        default=None,
        metavar="PATH",
    )
    frames_out: PathLike | None = argument(
        OTHER,
        "Write the evaluated frames of the truth here, for --frames: a file, or a folder if the "
        "recordings differ in them.",
        default=None,
        type=click.Path(path_type=Path),
        metavar="PATH",
    )
    force: bool = argument(
        OTHER, "Replace files that exist (never the input).", default=False, is_flag=True
    )
    size: Size | None = None
    objects: str | Sequence[str] | Objects | None = None
