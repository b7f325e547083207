"""Caltech and KAIST ground truth as ``bbGt`` text (versions 0 to 3), one file per frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
)
from nvcore.inputs.readers.meaning.classes import ClassRule, choose_classes, rule_for
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.inputs.readers.meaning.values import (
    PARTIAL_OCCLUSION,
    levels_of_numbers,
    levels_of_visible_share,
)
from nvcore.inputs.readers.parse.rows import rows_reading
from nvcore.inputs.readers.parse.text import TextLayout, read_numbers, stacked

LAYOUT = TextLayout(
    (10, 11, 12),
    "label l t w h occluded vl vt vw vh [ignore [angle]]",
    delimiter=" ",
    label_at=0,
    comment="%",
)
HEADER = "% bbGt version="
RULE = ClassRule(
    counted=("person",),
    ignored=("people", "person?", "cyclist", "ignore", "__ignore__"),
    left_out=("person-fa",),
)


def recognise(_name: str, head: str, role: Role) -> bool:
    """Whether the text begins with the bbGt header, or has 10 fields as version 0 has them."""
    has_header = head.removeprefix("\ufeff").startswith(HEADER)
    return role == "truth" and (has_header or replace(LAYOUT, n_columns=(10,)).fits(head))


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read bbGt files, one per frame; a file without boxes is an evaluated frame.

    Boxes are x, y, w, h in pixels already and are kept. `person` counts; `people`, `person?`,
    `cyclist` and rows with the ignore flag are ignore regions; other labels are left out. The
    occlusion field is KAIST's level 0, 1, 2, or Caltech's flag, which the visible box makes a
    level.

    Raises
    ------
    InputError
        If a file name has no frame number, two files are of one frame, or a class is unknown.
    FormatError
        With file and line of the first row that is not bbGt.
    """
    named = listed_frames(files, options)
    table = stacked([read_numbers(frame_file, LAYOUT) for frame_file in files])
    assert table.label is not None
    *box, flag, vl, vt, vw, vh, ignore, angle = table.columns
    choice = choose_classes(table.label, rule_for(RULE, table.label, options), options, table.lines)
    rotated = table.lines.finding(
        choice.keep & (np.nan_to_num(angle) != 0),
        "rotated-box",
        "Boxes with an angle are taken as upright boxes.",
        "Give upright boxes if the angle matters.",
        role="truth",
        example=lambda row: f"angle {angle[row]:g}",
    )
    facts = [
        "x, y, w, h in pixels kept as they are",
        "frame numbers from the file names",
        choice.fact,
        "ignore flag kept",
        "occlusion levels kept, Caltech's flag made a level by the visible box (up to "
        f"{PARTIAL_OCCLUSION:g} hidden = partial)",
    ]
    reading = rows_reading(
        table.lines,
        box,
        choice,
        named,
        options,
        facts,
        ignore=choice.ignore | (np.nan_to_num(ignore) != 0),
        occlusion=_occlusion(flag, box, (vl, vt, vw, vh)),
    )
    return replace(reading, findings=(*choice.findings, *rotated))


def _occlusion(
    flag: np.ndarray, box: Sequence[np.ndarray], visible: Sequence[np.ndarray]
) -> np.ndarray:
    """Levels 0, 1, 2; a flag of 1 is partial unless the visible box says that it is heavy."""
    with np.errstate(invalid="ignore", divide="ignore"):
        share = visible[2] * visible[3] / (box[2] * box[3])
    is_set = np.any([v != 0 for v in visible], axis=0)
    # Caltech's labelling tool leaves the visible box equal to the box where nothing is visible
    is_whole = np.all([v == b for v, b in zip(visible, box, strict=True)], axis=0)
    is_heavy = is_set & (is_whole | (levels_of_visible_share(share) == 2))
    return levels_of_numbers(np.where((flag == 1) & is_heavy, 2, flag))


FORMAT = Format("bbgt", "Caltech/KAIST bbGt text", ("truth",), (".txt",), recognise, read)
