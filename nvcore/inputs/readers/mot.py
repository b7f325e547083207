"""MOTChallenge text: ground truth, detections and tracker results (MOT15, MOT16/17/20)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from nvcore.errors import InputError
from nvcore.findings import Finding
from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    annotated_frames,
    concat_boxes,
    conversion_text,
    image_list,
    recordings_table,
)
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.meaning.occlusion import levels_of_visible_share
from nvcore.inputs.readers.meaning.seqinfo import sequence_info
from nvcore.inputs.readers.parse.text import Layout, NumberTable, read_numbers, whole_numbers
from nvcore.schema import NO_TRACK

LAYOUT = Layout((7, 8, 9, 10), "frame,id,left,top,width,height,conf,...", whole=(0, 1))
CLASSES = {
    1: "pedestrian",
    2: "person_on_vehicle",
    3: "car",
    4: "bicycle",
    5: "motorbike",
    6: "non_mot_vehicle",
    7: "static_person",
    8: "distractor",
    9: "occluder",
    10: "occluder_on_ground",
    11: "occluder_full",
    12: "reflection",
    13: "crowd",
}
DISTRACTORS = frozenset({2, 7, 8, 12, 13})
"""Classes that look like pedestrians: detecting them is neither right nor wrong."""


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether the text has 7 to 10 comma-separated numbers a line, whole frame and id."""
    del name, role
    return LAYOUT.fits(head)


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read MOTChallenge files, one per recording.

    Frames, ids and pixels are 1-based in the files; frames keep their numbers, pixels become
    0-based. In truth, column 7 = 0 and distractor classes become ignore regions, other classes
    are left out. In results, a score column of nothing but -1 means that there are no scores.

    Raises
    ------
    InputError
        If two files are of one recording, or a class is unknown.
    FormatError
        With file and line of the first row that is not MOTChallenge.
    """
    infos = [sequence_info(file) for file in files]
    names, assumed = recordings_of(
        [file.name for file in files],
        options.recordings,
        stated=[info.name for info in infos],
    )
    tables: list[pd.DataFrame] = []
    annotated: list[pd.DataFrame] = []
    findings: list[Finding] = []
    facts = ["pixels from 1-based to 0-based", "frame numbers kept (1-based)"]
    for number, (file, name) in enumerate(zip(files, names, strict=True)):
        boxes, every_frame, new_facts, problems = _read_one(file, number, name, options)
        if options.role == "truth":
            annotated.append(annotated_frames(name, every_frame))
        tables.append(boxes)
        facts += new_facts
        findings += problems
    images = None
    if options.role == "truth" and all(info.n_frames is not None for info in infos):
        images = image_list(names, [np.arange(1, (info.n_frames or 0) + 1) for info in infos])
        facts.append("evaluated frames 1..seqLength from seqinfo.ini")
    return Reading(
        boxes=concat_boxes(tables),
        recordings=recordings_table(
            names,
            width=[info.width for info in infos],
            height=[info.height for info in infos],
            fps=[info.fps for info in infos],
        ),
        conversion=conversion_text([*facts, *assumed]),
        images=images,
        annotated=pd.concat(annotated, ignore_index=True) if annotated else None,
        findings=tuple(findings),
    )


def _read_one(
    file: SourceFile, number: int, name: str, options: ReadOptions
) -> tuple[pd.DataFrame, np.ndarray, list[str], list[Finding]]:
    """Boxes of a file, the frames of all its rows, the conversion in words, and what is odd."""
    table = read_numbers(file, LAYOUT)
    frame, track, left, top, width, height, conf = table.columns[:7]
    frame = whole_numbers(frame, table.lines, "frame")
    track = whole_numbers(track, table.lines, "id")
    findings = table.lines.finding(
        frame < 1,
        "frame-before-first",
        "Rows stand before frame 1, with which MOTChallenge recordings begin.",
        "The file may count frames from 0: add 1 to its frame numbers.",
        role=options.role,
        example=lambda row: f"frame {frame[row]}",
    )
    keep = None
    facts: list[str] = []
    columns: dict[str, object] = {}
    if options.role == "truth":
        keep, columns, facts, problems = _truth_columns(table, name, options)
        findings += problems
    elif np.all((conf == -1) | np.isnan(conf)):
        facts = ["score column is -1 throughout: no scores"] if len(table) else []
    else:
        columns = {"score": conf}
    boxes = table.lines.boxes(
        (left - 1, top - 1, width, height),
        keep=keep,
        recording=name,
        frame=frame,
        track=np.where(track < 0, NO_TRACK, track),
        file=number,
        **columns,
    )
    return boxes, frame, facts, findings


def _truth_columns(
    table: NumberTable, name: str, options: ReadOptions
) -> tuple[np.ndarray, dict[str, object], list[str], list[Finding]]:
    """What rows of truth stay, their further columns, the conversion in words, what is odd."""
    conf, kind, visibility, last = table.columns[6:]
    findings = table.lines.finding(
        (conf != np.floor(conf)) | (conf > 1),
        "truth-with-scores",
        "Rows of the ground truth have a number in column 7 other than 0 (ignore) and 1.",
        "It looks like scores: check that the truth and a system's detections are not swapped.",
        role="truth",
        example=lambda row: f"{conf[row]:g}",
    )
    keep, ignore = np.ones(len(table), dtype=bool), conf == 0
    columns: dict[str, object] = {}
    facts = ["conf 0 = ignore"]
    # MOT16 and later have 8 or 9 columns with a class; MOT15 has 10, of which 8 to 10 are x, y, z
    if np.isnan(last).all() and np.any(kind > 0):
        classes = whole_numbers(kind, table.lines, "class")
        counted = _class_numbers(options, table.lines.files[0])
        # the benchmark's rule: class 6 became a distractor with MOT20
        distractors = DISTRACTORS | ({6} if name.upper().startswith("MOT20") else set())
        if not options.objects.are_pedestrians:
            distractors = frozenset(
                k for k, name in CLASSES.items() if options.objects.concerns(name)
            )
        neutral = sorted(distractors - set(counted))
        is_wanted = np.isin(classes, counted)
        # a row with conf 0 of another class (a car) is no ignore region for pedestrians
        keep = is_wanted | np.isin(classes, neutral)
        ignore |= ~is_wanted
        columns["occlusion"] = levels_of_visible_share(visibility)
        facts.append(
            f"classes: {', '.join(CLASSES[k] for k in counted)} counted; "
            + (f"{', '.join(CLASSES[k] for k in neutral)} ignored; " if neutral else "")
            + "others left out"
        )
        findings += table.lines.finding(
            ~np.isin(classes, list(CLASSES)),
            "unknown-class",
            "Rows of a class that MOTChallenge does not have (it has 1 to 13) were left out.",
            "Number the classes as MOTChallenge does; 1 is pedestrian.",
            role="truth",
            example=lambda row: f"class {classes[row]}",
        )
    elif options.classes is not None and len(table):
        facts.append("no class column: all rows counted")
    return keep, columns | {"ignore": ignore}, facts, findings


def _class_numbers(options: ReadOptions, file: SourceFile) -> list[int]:
    """Numbers of the classes that count."""
    objects, classes = options.objects, options.classes
    if classes is None:
        numbers = [number for number, name in CLASSES.items() if objects.counts(name)]
        if not numbers:
            raise InputError(
                f"MOTChallenge has no class called {objects.singular}; it has "
                f"{', '.join(CLASSES.values())}: name the classes that count as {objects.plural}",
                file=file.name,
            )
        return numbers
    by_name = {v: k for k, v in CLASSES.items()}
    numbers = []
    for name in classes:
        number = int(name) if name.isdecimal() else by_name.get(name.lower())
        if number not in CLASSES:
            raise InputError(
                f"MOTChallenge has no class {name!r}; it has {', '.join(CLASSES.values())}",
                file=file.name,
            )
        numbers.append(number)
    return numbers


FORMAT = Format("mot", "MOTChallenge", BOTH_ROLES, (".txt", ".csv"), recognise, read)
