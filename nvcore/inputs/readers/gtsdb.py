"""Ground truth of the German Traffic Sign Detection Benchmark: ``gt.txt``, one row per sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from pathlib import PurePosixPath
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.findings import Remedy, Step
from nvcore.inputs.readers.base import (
    Format,
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    image_list,
)
from nvcore.inputs.readers.meaning.classes import (
    ClassRule,
    by_names,
    check_any_counts,
    choose_classes,
    rule_for,
)
from nvcore.inputs.readers.meaning.names import recording_and_frame_of, recordings_of
from nvcore.inputs.readers.parse.rows import rows_reading
from nvcore.inputs.readers.parse.text import (
    TextLayout,
    read_numbers,
    read_text,
    stacked,
    whole_numbers,
)

LAYOUT: Final = TextLayout((6,), "file;x1;y1;x2;y2;class", delimiter=";", label_at=0, whole=(5,))
CLASSES: Final = (
    *(f"speed limit {limit}" for limit in (20, 30, 50, 60, 70, 80)),
    *("end of speed limit 80", "speed limit 100", "speed limit 120"),
    *("no overtaking", "no overtaking for trucks", "priority at next intersection"),
    *("priority road", "give way", "stop", "no traffic both ways", "no trucks", "no entry"),
    *("danger", "bend left", "bend right", "bend", "uneven road", "slippery road"),
    *("road narrows", "construction", "traffic signal", "pedestrian crossing", "school crossing"),
    *("cycles crossing", "snow", "animals", "restriction ends", "go right", "go left"),
    *("go straight", "go right or straight", "go left or straight", "keep right", "keep left"),
    *("roundabout", "end of no overtaking", "end of no overtaking for trucks"),
)
"""Names of the benchmark's classes, by their numbers."""
SCENES: Final = "scenes.txt"
"""File beside ``gt.txt`` that also lists scenes without a sign, one picture name per line."""
PICTURES: Final = frozenset({".ppm", ".jpg", ".jpeg", ".png"})
_MOST_PICTURES: Final = 100_000


def recognise(_name: str, head: str, role: Role) -> bool:
    """Whether rows are a picture's name and 5 numbers with semicolons, the last one whole."""
    return role == "truth" and LAYOUT.fits(head)


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read ``gt.txt``, one file per recording. Each scene (a single picture) is a frame.

    Corners are the first and last pixel inside, 0-based. A scene without a sign has no row, so
    evaluated frames come from ``scenes.txt`` in the same folder, else from the pictures there,
    else from the rows.
    """
    tables = [file for file in files if PurePosixPath(file.name).name != SCENES]
    if not tables:
        raise InputError(f"expected gt.txt, found {SCENES} alone", file=files[0].name)
    names, facts = recordings_of([file.name for file in tables], options.recordings)
    table = stacked([read_numbers(file, LAYOUT) for file in tables])
    assert table.label is not None
    left, top, right, bottom, kind = table.columns
    frame = _frames(table.label, table.lines)
    number = whole_numbers(kind, table.lines, "class number")
    table.lines.refuse(
        (number < 0) | (number >= len(CLASSES)),
        lambda row: f"expected a class from 0 to {len(CLASSES) - 1}, found {number[row]}",
    )
    as_objects = Step(Remedy.OPTION, "speed sign", "objects")
    check_any_counts(CLASSES, "traffic signs", options, tables[0], steps=(as_objects,))
    label, options = by_names(number, dict(enumerate(CLASSES)), options)
    rule = rule_for(ClassRule((), (), CLASSES), label, options)
    choice = choose_classes(label, rule, options, table.lines)
    scenes = [_scenes(file, files, frame[table.lines.file == i]) for i, file in enumerate(tables)]
    facts += [
        "frame numbers from the pictures' names",
        "boxes from corners (0-based, inclusive)",
        choice.fact,
        *(fact for _, fact in scenes),
    ]
    reading = rows_reading(
        table.lines,
        (left, top, right - left + 1, bottom - top + 1),
        choice,
        names,
        options,
        facts,
        kind=label,
        layout="corners",
        frame=frame,
    )
    return replace(reading, images=image_list(names, [listed for listed, _ in scenes]))


def _frames(picture: np.ndarray, lines: Lines) -> np.ndarray:
    """Return the frame number of each row's picture."""
    codes, pictures = pd.factorize(picture)
    numbers = np.empty(len(pictures), np.int64)
    for i, name in enumerate(pictures):  # of the few different names
        place = recording_and_frame_of(str(name))
        if place is None:
            row = int(np.argmax(codes == i))
            raise lines.fault(
                row, f"expected a picture named by a number, such as 00006.ppm, found {name!r}"
            )
        numbers[i] = place[1]
    frame: np.ndarray = numbers[codes]
    return frame


def _scenes(
    file: SourceFile, files: Sequence[SourceFile], annotated: np.ndarray
) -> tuple[np.ndarray, str]:
    """Return sorted frame numbers of all scenes of a file, with a text on their source."""
    folder = PurePosixPath(file.name).parent
    listed = next((f for f in files if PurePosixPath(f.name) == folder / SCENES), None)
    if listed is None and (file.path.parent / SCENES).is_file():
        listed = SourceFile(file.path.parent / SCENES, str(folder / SCENES))
    if listed is not None:
        every = pd.Series(read_text(listed).splitlines(), dtype=object).str.strip()
        names = every[every != ""]
        lines = Lines.of(listed, names.index.to_numpy() + 1)
        own = _frames(names.to_numpy(), lines)
        return np.union1d(own, annotated), f"scenes as {SCENES} lists them"
    pictures = _pictures_beside(file)
    if len(pictures):
        return np.union1d(pictures, annotated), "a scene for each picture beside the file"
    return np.unique(annotated), "scenes with a row; those without a sign are not known"


def _pictures_beside(file: SourceFile) -> np.ndarray:
    """Return the frame numbers of the pictures in the file's folder."""
    numbers = []
    for path in islice(file.path.parent.iterdir(), _MOST_PICTURES):
        place = recording_and_frame_of(path.name) if path.suffix.lower() in PICTURES else None
        numbers += [] if place is None else [place[1]]
    return np.array(numbers, np.int64)


FORMAT = Format(
    "gtsdb",
    "German Traffic Sign Detection Benchmark",
    ("truth",),
    (".txt", ".csv"),
    recognise,
    read,
)
