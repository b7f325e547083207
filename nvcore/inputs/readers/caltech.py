"""Caltech and KAIST text files: ground truth (``bbGt``, versions 0 to 3), and results.

Results have rows of six numbers: ``image_number,x,y,w,h,score`` in KAIST's one file for all images,
``frame,x,y,w,h,score`` in Caltech's, one per recording.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePosixPath

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError, MissingFactError
from nvcore.common.file_kinds import unpacked_name
from nvcore.common.findings import Severity
from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    recordings_table,
)
from nvcore.inputs.readers.meaning.classes import ClassRule, choose_classes, rule_for
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.inputs.readers.meaning.names import known_recording
from nvcore.inputs.readers.meaning.values import (
    PARTIAL_OCCLUSION,
    levels_of_numbers,
    levels_of_visible_share,
)
from nvcore.inputs.readers.parse.rows import FilePart, joined_parts, rows_reading
from nvcore.inputs.readers.parse.text import (
    NumberTable,
    TextLayout,
    number_of,
    read_numbers,
    rows_of_text,
    stacked,
    whole_numbers,
)

BBGT_LAYOUT = TextLayout(
    (10, 11, 12),
    "label l t w h occluded vl vt vw vh [ignore [angle]]",
    delimiter=" ",
    label_at=0,
    comment="%",
)
BBGT_HEADER = "% bbGt version="
RULE = ClassRule(
    counted=("person",),
    ignored=("people", "person?", "cyclist", "ignore", "__ignore__"),
    left_out=("person-fa",),
)
RESULTS_LAYOUT = TextLayout((6,), "image number or frame,x,y,w,h,score", whole=(0,))
_SEQUENCE = re.compile(r"V\d+", re.IGNORECASE)


def recognise_bbgt(_name: str, head: str, role: Role) -> bool:
    """Whether the text begins with the bbGt header, or has the 10 fields of version 0."""
    has_header = head.removeprefix("\ufeff").startswith(BBGT_HEADER)
    return role == "truth" and (has_header or replace(BBGT_LAYOUT, n_columns=(10,)).fits(head))


def read_bbgt(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read bbGt files, one per frame. Files without boxes are evaluated frames, too.

    Boxes are kept, since they already are x, y, w, h in pixels. `person` counts. `people`,
    `person?`, `cyclist` and rows with the ignore flag are ignore regions. Other labels are left
    out. The occlusion field is KAIST's level 0, 1, 2, or Caltech's flag, which is converted to a
    level by the visible box.
    """
    named = listed_frames(files, options)
    table = stacked([read_numbers(frame_file, BBGT_LAYOUT) for frame_file in files])
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
    """Return levels 0, 1, 2. The visible box tells whether a flag of 1 is partial or heavy."""
    with np.errstate(invalid="ignore", divide="ignore"):
        share = visible[2] * visible[3] / (box[2] * box[3])
    is_set = np.any([v != 0 for v in visible], axis=0)
    # Caltech's labelling tool leaves the visible box equal to the box if nothing is visible
    is_whole = np.all([v == b for v, b in zip(visible, box, strict=True)], axis=0)
    is_heavy = is_set & (is_whole | (levels_of_visible_share(share) == 2))
    return levels_of_numbers(np.where((flag == 1) & is_heavy, 2, flag))


def recognise_results(_name: str, head: str, role: Role) -> bool:
    """Whether rows have 6 numbers, of which the first is whole and at least 1.

    Corners (``frame,x1,y1,x2,y2,score``) look the same, so ``kitti-detections`` is tried first.
    """
    n_rows = 50
    return (
        role == "detections"
        and RESULTS_LAYOUT.fits(head, n_rows=n_rows)
        and all((number_of(row[0]) or 0) >= 1 for row in rows_of_text(head)[:n_rows])
    )


def read_results(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read KAIST results by the truth's image list, Caltech detections by their file names.

    A file that is named after a recording (``set06/V000.txt``) is Caltech's. Its 1-based frames
    become the 0-based numbers of the pictures (I00000 is the first), unless
    `ReadOptions.frame_base` is 0. Any other file is KAIST's, whose image number is the 1-based
    position in the truth's image list. Boxes already are x, y, w, h in pixels.
    """
    parts: list[FilePart] = []
    first_of: dict[str, str] = {}
    for number, file in enumerate(files):
        table = read_numbers(file, RESULTS_LAYOUT)
        numbers, *box, score = table.columns
        index = whole_numbers(numbers, table.lines, "image number or frame")
        recording = _sequence_of(file.name, options.recordings)
        if recording is not None:
            if recording in first_of:
                raise InputError(
                    f"holds recording {recording!r}, as {first_of[recording]} does; expected one "
                    "file per recording: leave one of the two out",
                    file=file.name,
                )
            first_of[recording] = file.name
            base = 1 if options.frame_base is None else options.frame_base
            fact = f"frames from {base}-based to 0-based; recordings from the file names"
            boxes = table.lines.boxes(
                box, recording=recording, frame=index - base, score=score, file=number
            )
            reading = Reading(boxes, recordings_table([recording]), "")
        else:
            reading, fact = _by_image_number(table, index, number, options)
        parts.append(FilePart(reading, [fact]))
    reading = joined_parts(parts, ["x, y, w, h in pixels kept as they are"])
    return replace(reading, usual={"frame_base": 1} if first_of else {})


def _by_image_number(
    table: NumberTable, index: np.ndarray, number: int, options: ReadOptions
) -> tuple[Reading, str]:
    """Read results by the truth's image list, and describe how their images are found."""
    images = options.images
    if images is None or images.empty:
        raise MissingFactError(
            "these are results by image number: the truth's image list is needed to tell "
            "recording and frame. Give a truth that lists its images (COCO, bbGt); or, if the "
            "first column is the frame, name the file by its recording, as in set06/V000.txt",
            file=table.lines.files[0].name,
        )
    position, fact = _positions(index, images)
    _, *box, score = table.columns
    boxes = table.lines.boxes(
        box,
        keep=position >= 0,
        recording=images["recording"].to_numpy()[position],
        frame=images["frame"].to_numpy()[position],
        score=score,
        file=number,
    )
    findings = table.lines.finding(
        position < 0,
        "unknown-image",
        f"Rows whose image number is not on the truth's list of {len(images)} images were left "
        "out.",
        "Give the truth that these results were made for; image numbers count from 1.",
        role="detections",
        example=lambda row: f"image number {index[row]}",
        severity=Severity.ERROR,
    )
    recordings = recordings_table(images["recording"].tolist())
    return Reading(boxes, recordings, "", findings=tuple(findings)), fact


def _sequence_of(name: str, known: tuple[str, ...]) -> str | None:
    """Return the recording that a file is named after, or None for a file of all images."""
    path = PurePosixPath(unpacked_name(name))
    parts = (*path.parts[:-1], path.stem)
    # the match must include the file's own name, since a folder is often named after the data set
    for start in range(len(parts)):
        recording = known_recording(("/".join(parts[start:]),), known)
        if recording is not None:
            return recording
    if not _SEQUENCE.fullmatch(path.stem):
        return None
    folder = path.parent.name
    return f"{folder}/{path.stem}" if folder.lower().startswith("set") else path.stem


def _positions(index: np.ndarray, images: pd.DataFrame) -> tuple[np.ndarray, str]:
    """Return 0-based rows of the image list, -1 if an image number is not on it."""
    if not len(index) or index.max() <= len(images):
        position = np.where(index >= 1, index - 1, -1)
        return position, "image number = 1-based position in the truth's image list"
    # a truth that is a part of the data set (such as the night) keeps the ids of the whole
    ids = pd.to_numeric(images["image_id"], errors="coerce").to_numpy(dtype=float)
    place = pd.Series(np.arange(len(ids)), index=ids).loc[lambda s: ~s.index.duplicated()]
    position = place.reindex((index - 1).astype(float), fill_value=-1).to_numpy()
    return position, "image number = image id + 1 (the numbers exceed the truth's image list)"


BBGT = Format("bbgt", "Caltech/KAIST bbGt text", ("truth",), (".txt",), recognise_bbgt, read_bbgt)
KAIST_RESULTS = Format(
    "kaist-results",
    "KAIST results or Caltech detections",
    ("detections",),
    (".txt", ".csv"),
    recognise_results,
    read_results,
)
