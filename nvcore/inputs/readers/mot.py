"""MOTChallenge text: ground truth, detections and tracker results (MOT15, MOT16/17/20)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from nvcore.common.findings import Finding, Remedy, Severity, Step
from nvcore.dataset.schema import NO_TRACK
from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    LeftOut,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    annotated_frames,
    conversion_text,
    image_list,
    recordings_table,
)
from nvcore.inputs.readers.meaning.classes import (
    ClassNames,
    ClassRule,
    NumberedRows,
    by_names,
    check_any_counts,
    choose_categories,
    choose_classes,
    is_class_file,
    names_in,
    names_of_numbers,
    rule_for,
)
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.meaning.values import (
    levels_of_numbers,
    levels_of_visible_share,
    sequence_info,
)
from nvcore.inputs.readers.parse.rows import FilePart, choice_of_rows, joined_parts
from nvcore.inputs.readers.parse.text import NumberTable, TextLayout, read_numbers, whole_numbers
from nvcore.inputs.readers.visdrone import NAMES as VISDRONE
from nvcore.inputs.readers.visdrone import are_visdrones

LAYOUT = TextLayout((7, 8, 9, 10), "frame,id,left,top,width,height,conf,...", whole=(0, 1))
BLANKS = replace(LAYOUT, delimiter=" ")
"""Layout of trackers that separate numbers by blanks or tabs."""
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
COLUMN_NAMES = {7: "the eighth column", 8: "the ninth column", 9: "the tenth column"}
"""Names of columns, by index."""
LABELS = "labels.txt"
HEAD_BYTES = 4096
"""Number of bytes that are read to detect the delimiter."""
LATE_SCORE = "constant-score-column"
RULE = ClassRule(
    counted=("pedestrian",),
    ignored=("person_on_vehicle", "static_person", "distractor", "reflection", "crowd"),
    left_out=(
        *("car", "bicycle", "motorbike", "non_mot_vehicle"),
        *("occluder", "occluder_on_ground", "occluder_full"),
    ),
    is_benchmark=True,
)
"""Rule of MOTChallenge's own evaluation: detecting a distractor is neither right nor wrong."""
MOT20_RULE = replace(RULE, ignored=(*RULE.ignored, "non_mot_vehicle"))


def recognise(_name: str, head: str, _role: Role) -> bool:
    """Whether lines have 7 to 10 numbers (with whole frame and id) between commas or blanks."""
    return LAYOUT.fits(head) or BLANKS.fits(head)


def read(
    files: Sequence[SourceFile], options: ReadOptions, *, has_late_score: bool = False
) -> Reading:
    """Read MOTChallenge files, one per recording.

    Frames, ids and pixels are 1-based in the files. Frames keep their numbers. Pixels become
    0-based, as those of VisDrone and of results on it already are. In truth, column 7 = 0 and
    distractor classes become ignore regions, and other classes are left out. In results, a score
    column of only -1 means no scores. A constant score with a later column that varies between
    0 and 1 is an error that users can accept: `has_late_score` uses the later column.

    Classes are those of MOTChallenge, of a ``labels.txt`` beside the file (CVAT), or of VisDrone.
    Results have the classes of the truth.
    """
    files = [file for file in files if not is_class_file(file.name)] or files
    infos = [sequence_info(file) for file in files]
    names, assumed = recordings_of(
        [file.name for file in files], options.recordings, stated=[info.name for info in infos]
    )
    parts = [
        _read_one(file, number, name, options, has_late_score=has_late_score)
        for number, (file, name) in enumerate(zip(files, names, strict=True))
    ]
    reading = joined_parts(parts, ["frame numbers kept (1-based)"])
    images = None
    if options.role == "truth" and all(info.n_frames is not None for info in infos):
        images = image_list(names, [np.arange(1, (info.n_frames or 0) + 1) for info in infos])
        assumed = ["evaluated frames 1..seqLength from seqinfo.ini", *assumed]
    return replace(
        reading,
        recordings=recordings_table(
            names,
            width=[info.width for info in infos],
            height=[info.height for info in infos],
            fps=[info.fps for info in infos],
        ),
        conversion=conversion_text([reading.conversion, *assumed]),
        images=images,
        numbering="mot",
    )


@dataclass(frozen=True)
class _Rows:
    """Treatment of rows: kept or not, ignored or counted, with facts and findings."""

    keep: np.ndarray
    ignore: np.ndarray
    facts: list[str]
    findings: list[Finding] = field(default_factory=list)
    names: Mapping[str, str] = field(default_factory=dict)
    classes: tuple[str, ...] = ()
    left_out: tuple[LeftOut, ...] = ()


def _read_one(
    file: SourceFile, number: int, name: str, options: ReadOptions, *, has_late_score: bool
) -> FilePart:
    with file.open() as stream:
        first = stream.read(HEAD_BYTES).lstrip(b"\xef\xbb\xbf \t\r\n").partition(b"\n")[0]
    table = read_numbers(file, LAYOUT if b"," in first else BLANKS)
    frame, track, left, top, width, height, conf, kind, visibility, last = table.columns
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
    is_visdrone = are_visdrones(kind, visibility, last) and bool(
        np.all(last >= 0) and np.any(kind > 0)
    )
    columns: dict[str, object] = {}
    if options.role == "truth":
        rows = _rows_of_truth(table, name, options, is_visdrone=is_visdrone)
        if is_visdrone:
            columns["occlusion"] = levels_of_numbers(last)
        elif np.isnan(last).all():
            columns["occlusion"] = levels_of_visible_share(visibility)
    else:
        is_visdrone = options.names_for("mot") == VISDRONE
        rows = _rows_of_results(table, options)
        late = _late_score(table)
        if has_late_score:
            # a file with few rows only shows which column is its last
            filled = [i for i in COLUMN_NAMES if np.isfinite(table.columns[i]).any()]
            late = [6, *filled][-1] if late is None else late
            conf = table.columns[late]
            rows.facts.append(f"score from column {late + 1}")
        elif late is not None:
            findings += table.lines.finding(
                np.ones(len(table), dtype=bool),
                LATE_SCORE,
                f"The score in the seventh column is {conf[0]:g} throughout, while "
                f"{COLUMN_NAMES[late]} varies between 0 and 1: it may be the score.",
                "Say which column is the score.",
                role="detections",
                severity=Severity.ERROR,
                steps=(Step(Remedy.FORMAT, BOXMOT.name), Step(Remedy.ACCEPT, LATE_SCORE)),
            )
        if not np.all((conf == -1) | np.isnan(conf)):
            columns["score"] = conf
        elif len(table):
            rows.facts.append("score column is -1 throughout: no scores")
    # CVAT and Datumaro write edges from 0, although frames start at 1
    base = 0 if is_visdrone or _labels_beside(file).names else 1
    boxes = table.lines.boxes(
        (left - base, top - base, width, height),
        keep=rows.keep,
        recording=name,
        frame=frame,
        track=np.where(track < 0, NO_TRACK, track),
        file=number,
        ignore=rows.ignore,
        **columns,
    )
    pixels = "pixels from 1-based to 0-based" if base else "pixels kept (0-based)"
    reading = Reading(
        boxes,
        recordings_table(()),
        "",
        annotated=annotated_frames(name, frame) if options.role == "truth" else None,
        findings=(*findings, *rows.findings),
        categories=rows.names,
        classes=rows.classes,
        left_out=rows.left_out,
    )
    return FilePart(reading, [pixels, *rows.facts])


def _rows_of_truth(
    table: NumberTable, name: str, options: ReadOptions, *, is_visdrone: bool
) -> _Rows:
    """Choose the treatment of rows of truth."""
    conf, kind, _, last = table.columns[6:]
    findings = table.lines.finding(
        (conf != np.floor(conf)) | (conf > 1),
        "truth-with-scores",
        "Rows of the ground truth have a number in column 7 other than 0 (ignore) and 1.",
        "It looks like scores: check that the truth and a system's detections are not swapped.",
        role="truth",
        example=lambda row: f"{conf[row]:g}",
    )
    ignore, facts = conf == 0, ["conf 0 = ignore"]
    everything = _Rows(np.ones(len(table), dtype=bool), ignore, facts, findings)
    # MOT16 and later have 8 or 9 columns with a class; MOT15 has 10, of which 8 to 10 are x, y, z
    if not is_visdrone and not (np.isnan(last).all() and np.any(kind > 0)):
        if options.classes is not None and len(table):
            facts.append("no class column: all rows counted")
        return everything
    classes = whole_numbers(kind, table.lines, "class")
    file = table.lines.files[0]
    named = ClassNames(VISDRONE) if is_visdrone else _labels_beside(file)
    if named.names:
        return _by_name(everything, classes, named, options, file)
    what = f"boxes of MOTChallenge ({', '.join(CLASSES.values())})"
    check_any_counts(CLASSES.values(), what, options, file)
    label, options = by_names(classes, CLASSES, options)
    rule = rule_for(MOT20_RULE if name.upper().startswith("MOT20") else RULE, label, options)
    choice = choose_classes(label, rule, options, table.lines)
    return _Rows(
        choice.keep,
        ignore | choice.ignore,
        [*facts, choice.fact],
        [*findings, *choice.findings],
        {str(number): name for number, name in CLASSES.items()},
        left_out=choice.left_out,
    )


def _late_score(table: NumberTable) -> int | None:
    """Find a column after a constant seventh one that varies between 0 and 1, or return None."""
    if len(np.unique(table.columns[6])) > 1:
        return None
    return next(
        (
            place
            for place, column in zip(COLUMN_NAMES, table.columns[7:], strict=True)
            if np.all((column >= 0) & (column <= 1)) and len(np.unique(column % 1)) > 1
        ),
        None,
    )


def _rows_of_results(table: NumberTable, options: ReadOptions) -> _Rows:
    """Choose the treatment of rows of results. Column 8 is a class if it can be nothing else."""
    kind, second, third = table.columns[7:]
    everything = _Rows(np.ones(len(table), dtype=bool), np.zeros(len(table), dtype=bool), [])
    is_small = np.isnan(third) | (np.isin(second, (-1, 0, 1)) & np.isin(third, (-1, 0, 1, 2)))
    if not (np.all(is_small & (kind == np.floor(kind))) and np.any(kind >= 0)):
        return everything
    classes = whole_numbers(kind, table.lines, "class")
    file = table.lines.files[0]
    numbers = [*map(str, np.unique(classes).tolist())]
    named = names_of_numbers(numbers, _labels_beside(file), options, "mot")
    return _by_name(everything, classes, named, options, file)


def _by_name(
    rows: _Rows, classes: np.ndarray, named: ClassNames, options: ReadOptions, file: SourceFile
) -> _Rows:
    """Choose the treatment of rows by the names of their classes."""
    numbered = NumberedRows.of(classes)
    choice = choose_categories(numbered.counts, named, options, file=file.name)
    of_rows = choice_of_rows(numbered, choice)
    return replace(
        rows,
        keep=of_rows.keep,
        ignore=rows.ignore | of_rows.ignore,
        facts=[*rows.facts, choice.conversion],
        findings=[*rows.findings, *choice.findings],
        names=named.names,
        classes=choice.classes,
        left_out=choice.left_out,
    )


def _labels_beside(file: SourceFile) -> ClassNames:
    """Read CVAT's ``labels.txt`` in the folder of the file or above, numbered from 1."""
    folder = file.path.absolute().parent
    places = [folder, folder.parent] if folder.name.lower() in ("gt", "det") else [folder]
    labels = next(
        (f for f in (SourceFile(p / LABELS, LABELS) for p in places) if f.path.is_file()), None
    )
    if labels is None:
        return ClassNames()
    names = names_in(labels)
    return ClassNames({str(int(number) + 1): name for number, name in names.items()}, LABELS)


FORMAT = Format("mot", "MOTChallenge", BOTH_ROLES, (".txt", ".csv"), recognise, read)
BOXMOT = Format(
    "boxmot",
    "MOTChallenge with the score behind the seventh column",
    ("detections",),
    (".txt", ".csv"),
    lambda _name, _head, _role: False,
    partial(read, has_late_score=True),
)
"""Format of BoxMOT, where column 7 is always 1. It has to be named, since it is not detected."""
