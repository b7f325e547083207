"""MOTChallenge text: ground truth, detections and tracker results (MOT15, MOT16/17/20)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from nvcore.errors import InputError
from nvcore.findings import Finding
from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    annotated_frames,
    concat_boxes,
    reading_boxes,
    recording_row,
    recordings_table,
    rows_finding,
)
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.meaning.occlusion import levels_of_visible_share
from nvcore.inputs.readers.meaning.seqinfo import sequence_info
from nvcore.inputs.readers.parse.text import (
    NumberTable,
    are_numbers,
    is_whole,
    read_numbers,
    rows_of_text,
    whole_numbers,
)
from nvcore.schema import NO_TRACK

N_COLUMNS = (7, 8, 9, 10)
WHAT = "frame,id,left,top,width,height,conf,..."
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
    rows = rows_of_text(head)[:20]
    return bool(rows) and all(
        len(row) in N_COLUMNS and is_whole(row[0]) and is_whole(row[1]) and are_numbers(row)
        for row in rows
    )


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
    rows = [
        recording_row(name, width=info.width, height=info.height, fps=info.fps)
        for name, info in zip(names, infos, strict=True)
    ]
    tables: list[pd.DataFrame] = []
    annotated: list[pd.DataFrame] = []
    findings: list[Finding] = []
    facts = ["pixels from 1-based to 0-based", "frame numbers kept (1-based)"]
    for number, (file, name) in enumerate(zip(files, names, strict=True)):
        boxes, keep, what, problems = _read_one(file, number, name, options)
        if options.role == "truth":
            annotated.append(annotated_frames(name, boxes["frame"].to_numpy()))
        tables.append(boxes if keep.all() else boxes[keep].reset_index(drop=True))
        facts += [fact for fact in what if fact not in facts]
        findings += problems
    images = None
    if options.role == "truth" and all(info.n_frames is not None for info in infos):
        images = _listed_frames(names, [info.n_frames or 0 for info in infos])
        facts.append("evaluated frames 1..seqLength from seqinfo.ini")
    return Reading(
        boxes=concat_boxes(tables),
        recordings=recordings_table(rows),
        conversion="; ".join([*facts, *assumed]),
        images=images,
        annotated=pd.concat(annotated, ignore_index=True) if annotated else None,
        findings=tuple(findings),
    )


def _read_one(
    file: SourceFile, number: int, name: str, options: ReadOptions
) -> tuple[pd.DataFrame, np.ndarray, list[str], list[Finding]]:
    """All boxes of a file, which of them stay, the conversion in words, and what is odd."""
    table = read_numbers(file, n_columns=N_COLUMNS, what=WHAT)
    frame, track, left, top, width, height, conf, kind, visibility, last = table.columns
    frame = whole_numbers(frame, file, table.line, "frame")
    track = whole_numbers(track, file, table.line, "id")
    findings = _frame_zero(frame, file, table, options)
    keep = np.ones(len(table), dtype=bool)
    columns: dict[str, object] = {
        "recording": name,
        "frame": frame,
        "x": left - 1,
        "y": top - 1,
        "w": width,
        "h": height,
        "track": np.where(track < 0, NO_TRACK, track),
        "file": number,
        "line": table.line,
    }
    if options.role == "detections":
        has_scores = bool(len(table)) and not np.all((conf == -1) | np.isnan(conf))
        columns["score"] = conf if has_scores else np.nan
        no_scores = ["score column is -1 throughout: no scores"]
        return (
            reading_boxes(len(table), **columns),
            keep,
            no_scores if len(table) and not has_scores else [],
            findings,
        )
    facts = ["conf 0 = ignore"]
    findings += _scores(conf, file, table)
    ignore = conf == 0
    # MOT16 and later have 8 or 9 columns with a class; MOT15 has 10, of which 8 to 10 are x, y, z
    if np.isnan(last).all() and np.any(kind > 0):
        classes = whole_numbers(kind, file, table.line, "class")
        wanted = _class_numbers(options.classes, file)
        # the benchmark's rule: class 6 became a distractor with MOT20
        distractors = DISTRACTORS | ({6} if name.upper().startswith("MOT20") else set())
        neutral = sorted(distractors - set(wanted))
        is_wanted = np.isin(classes, wanted)
        # a row with conf 0 of another class (a car) is no ignore region for pedestrians
        keep = is_wanted | np.isin(classes, neutral)
        ignore |= ~is_wanted
        columns["occlusion"] = levels_of_visible_share(visibility)
        facts.append(
            f"classes: {', '.join(CLASSES[k] for k in wanted)} counted; "
            f"{', '.join(CLASSES[k] for k in neutral)} ignored; others left out"
        )
        findings += _unknown_classes(classes, file, table)
    elif options.classes is not None and len(table):
        facts.append("no class column: all rows counted")
    columns["ignore"] = ignore
    return reading_boxes(len(table), **columns), keep, facts, findings


def _class_numbers(classes: tuple[str, ...] | None, file: SourceFile) -> list[int]:
    if classes is None:
        return [1]
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


def _unknown_classes(classes: np.ndarray, file: SourceFile, table: NumberTable) -> list[Finding]:
    return rows_finding(
        ~np.isin(classes, list(CLASSES)),
        "unknown-class",
        "Rows of a class that MOTChallenge does not have (it has 1 to 13) were left out.",
        "Number the classes as MOTChallenge does; 1 is pedestrian.",
        role="truth",
        place=lambda row: (file.name, f"line {table.line[row]}: class {classes[row]}"),
    )


def _scores(conf: np.ndarray, file: SourceFile, table: NumberTable) -> list[Finding]:
    return rows_finding(
        (conf != np.floor(conf)) | (conf > 1),
        "truth-with-scores",
        "Rows of the ground truth have a number in column 7 other than 0 (ignore) and 1.",
        "It looks like scores: check that the truth and a system's detections are not swapped.",
        role="truth",
        place=lambda row: (file.name, f"line {table.line[row]}: {conf[row]:g}"),
    )


def _frame_zero(
    frame: np.ndarray, file: SourceFile, table: NumberTable, options: ReadOptions
) -> list[Finding]:
    return rows_finding(
        frame < 1,
        "frame-before-first",
        "Rows stand before frame 1, with which MOTChallenge recordings begin.",
        "The file may count frames from 0: add 1 to its frame numbers.",
        role=options.role,
        place=lambda row: (file.name, f"line {table.line[row]}: frame {frame[row]}"),
    )


def _listed_frames(names: Sequence[str], lengths: Sequence[int]) -> pd.DataFrame:
    """Frames 1..seqLength of every recording."""
    frames = np.concatenate([np.arange(1, length + 1) for length in lengths])
    return pd.DataFrame(
        {
            "recording": np.repeat(np.array(names, dtype=object), lengths),
            "frame": frames,
            "image_id": frames,
        }
    )


FORMAT = Format(
    name="mot",
    title="MOTChallenge",
    roles=("truth", "detections"),
    suffixes=(".txt", ".csv"),
    recognise=recognise,
    read=read,
)
