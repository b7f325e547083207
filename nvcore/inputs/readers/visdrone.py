"""VisDrone: its classes and columns, and its detection text (DET), one file per picture.

Its video text (MOT, VID) has MOTChallenge's first seven columns and is read by `mot`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from nvcore.inputs.readers.base import BOTH_ROLES, Format, Reading, ReadOptions, Role, SourceFile
from nvcore.inputs.readers.meaning.classes import ClassNames, NumberedRows, choose_categories
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.inputs.readers.meaning.values import levels_of_numbers
from nvcore.inputs.readers.parse.rows import choice_of_rows, rows_reading
from nvcore.inputs.readers.parse.text import (
    TextLayout,
    number_of,
    read_numbers,
    rows_of_text,
    stacked,
    whole_numbers,
)

CLASSES: Final = dict(
    enumerate(
        (
            *("ignored regions", "pedestrian", "people", "bicycle", "car", "van", "truck"),
            *("tricycle", "awning-tricycle", "bus", "motor", "others"),
        )
    )
)
NAMES: Final[Mapping[str, str]] = {str(number): name for number, name in CLASSES.items()}
LAYOUT: Final = TextLayout((8, 9), "left,top,width,height,score,class,truncation,occlusion")
"""Layout of DET. In some files each row ends with a comma."""


def are_visdrones(kind: np.ndarray, truncation: np.ndarray, occlusion: np.ndarray) -> bool:
    """Whether three columns are VisDrone's class, truncation and occlusion (-1: not given).

    In MOT15 these are world coordinates, which are -1 or not whole numbers in this range.
    """
    return bool(
        np.isin(kind, [*CLASSES]).all()
        and np.isin(truncation, (-1, 0, 1)).all()
        and np.isin(occlusion, (-1, 0, 1, 2)).all()
    )


def recognise(_name: str, head: str, _role: Role) -> bool:
    """Whether rows have 8 numbers, of which the last four are VisDrone's.

    In MOTChallenge's 8 columns, the column of the score is the width of a box.
    """
    if not LAYOUT.fits(head):
        return False
    rows = [[number_of(field) for field in row[:8]] for row in rows_of_text(head)[:20]]
    columns = np.array(rows, dtype=float).T
    return bool(np.all((columns[4] >= 0) & (columns[4] <= 1))) and are_visdrones(*columns[5:8])


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read VisDrone-DET files, one per picture. Files without boxes are evaluated frames, too.

    Pixels are 0-based and kept. In truth, a score of 0 marks an ignore region.
    """
    named = listed_frames(files, options)
    table = stacked([read_numbers(file, LAYOUT) for file in files])
    *box, score, kind, _, occlusion = table.columns[:8]
    numbered = NumberedRows.of(whole_numbers(kind, table.lines, "class number"))
    choice = choice_of_rows(
        numbered, choose_categories(numbered.counts, ClassNames(NAMES), options, file=files[0].name)
    )
    is_truth = options.role == "truth"
    facts = [
        "frame numbers from the file names",
        "x, y, w, h in pixels kept as they are (0-based)",
        choice.fact,
        "score 0 = ignore" if is_truth else "",
        "occlusion 0, 1, 2 kept, truncation not used",
    ]
    return rows_reading(
        table.lines,
        box,
        choice,
        named,
        options,
        facts,
        score=np.nan if is_truth else score,
        ignore=(choice.ignore | (score == 0)) & is_truth,
        occlusion=levels_of_numbers(occlusion),
    )


FORMAT = Format("visdrone", "VisDrone-DET text", BOTH_ROLES, (".txt",), recognise, read)
