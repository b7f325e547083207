"""COCO results (JSON): a list of detections that name their image by id or by file name."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pandas as pd

from nvcore.errors import FormatError, MissingFactError
from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    concat_boxes,
    reading_boxes,
    recording_row,
    recordings_table,
    rows_finding,
)
from nvcore.inputs.readers.coco.images import id_text, place_of_picture, places_of_rows, rows_by_id
from nvcore.inputs.readers.coco.result_columns import ResultColumns, read_columns
from nvcore.inputs.readers.meaning.categories import is_pedestrian
from nvcore.inputs.readers.meaning.names import recording_of
from nvcore.inputs.readers.meaning.tracks import TEXT_IDS, track_numbers

PERSON = "1"
"""Category id of persons in COCO, KAIST, Teledyne FLIR and NightOwls."""

_FIELDS = re.compile(r'"bbox"\s*:')
_IMAGE = re.compile(r'"(?:image_id|image_filepath)"\s*:')
_WRAPPED = re.compile(r'"annotations"\s*:\s*\[')


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether the text is a JSON list of objects with bbox and image, wrapped or not, or empty."""
    del name
    text = head.lstrip("\ufeff \t\r\n")
    if role != "detections":
        return False
    if text.startswith("{"):
        return _WRAPPED.search(text) is not None
    if re.match(r"\[\s*\]\s*$", text):
        return True
    has_fields = _FIELDS.search(text) is not None and _IMAGE.search(text) is not None
    return re.match(r"\[\s*\{", text) is not None and has_fields


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read COCO results; images are those of the truth, or of the file where it lists its own.

    Raises
    ------
    FormatError
        With file and record of the first thing that is no COCO result, or is not clear.
    MissingFactError
        If images are named by id and the truth's image list is not given.
    """
    tables = []
    facts = ["boxes as they are (0-based)"]
    findings: list[Finding] = []
    for number, file in enumerate(files):
        columns, own = read_columns(file)
        images = options.images if own is None else own
        boxes, what, oddities = _boxes(columns, file, number, images, options)
        tables.append(boxes)
        facts += [fact for fact in what if fact not in facts]
        findings += oddities
    boxes = concat_boxes(tables)
    rows = [recording_row(name) for name in boxes["recording"].unique()]
    return Reading(
        boxes=boxes,
        recordings=recordings_table(rows),
        conversion="; ".join(facts),
        findings=tuple(findings),
    )


def _boxes(
    columns: ResultColumns,
    file: SourceFile,
    number: int,
    images: pd.DataFrame | None,
    options: ReadOptions,
) -> tuple[pd.DataFrame, list[str], list[Finding]]:
    n_rows = len(columns)
    if not n_rows:
        return reading_boxes(0), ["an empty list: nothing was detected"], []
    is_wanted, facts, findings = _categories(columns.category, file, options, n_rows)
    if columns.image_id is not None:
        recording, frame, is_known = _places_by_id(columns.image_id, file, images)
        facts.append("recording and frame from the image list by image_id")
        names = columns.image_id
    else:
        assert columns.picture is not None
        recording, frame, is_known = _places_by_name(columns.picture, file, images, options)
        facts.append("recording and frame from image_filepath")
        names = columns.picture
    findings += rows_finding(
        ~is_known,
        "unknown-image",
        "Results that name an image which is not in the image list were left out.",
        "Check that the results belong to this truth, and that ids start at the same number.",
        role="detections",
        place=lambda row: (file.name, f"result {row + 1}, image {names.iloc[row]}"),
        severity=Severity.ERROR,
    )
    values: dict[str, object] = {}
    if columns.track is not None:
        values["track"], has_text = track_numbers(columns.track, recording)
        facts += [TEXT_IDS] if has_text else []
    if columns.score is not None:
        values["score"] = columns.score
    else:
        facts.append("no scores")
    boxes = reading_boxes(
        n_rows,
        recording=recording,
        frame=frame,
        x=columns.box[:, 0],
        y=columns.box[:, 1],
        w=columns.box[:, 2],
        h=columns.box[:, 3],
        file=number,
        line=np.arange(1, n_rows + 1),
        **values,
    )
    keep = is_wanted & is_known
    return boxes if keep.all() else boxes[keep].reset_index(drop=True), facts, findings


def _categories(
    category: pd.Series | None, file: SourceFile, options: ReadOptions, n_rows: int
) -> tuple[np.ndarray, list[str], list[Finding]]:
    """Which results are of a class that counts, and the rule in words."""
    everything = np.ones(n_rows, dtype=bool)
    if category is None:
        return everything, ["no category_id: all results count"], []
    present = {id_text(key): count for key, count in category.value_counts(dropna=False).items()}
    listed = ", ".join(f"{key} ({count} results)" for key, count in present.items())
    wanted = {PERSON}
    if options.classes is not None:
        # results have no names for their categories: only a person's number is known
        named = [name for name in options.classes if not name.isdecimal()]
        persons = [name for name in named if is_pedestrian(name)]
        wanted = set(options.classes) - set(named) | ({PERSON} if persons else set())
        if len(persons) < len(named) and set(present) - wanted:
            raise FormatError(
                f"results number their classes: found category_id {listed}; give the classes as "
                "numbers",
                file=file.name,
            )
    if not wanted & set(present):
        if len(present) > 1 or options.classes is not None:
            raise FormatError(
                f"expected results of category_id {', '.join(sorted(wanted))}, found {listed}; "
                "name the category ids that are pedestrians as classes",
                file=file.name,
            )
        finding = Finding(
            severity=Severity.WARNING,
            code="unusual-category",
            subject="detections",
            count=n_rows,
            message=f"All results have category_id {next(iter(present))}, not 1 (person); "
            "all count.",
            advice="Check that they are pedestrians; naming the class (--classes) ends this "
            "warning.",
            file=file.name,
            example="result 1",
        )
        return everything, [f"category_id {next(iter(present))} counted"], [finding]
    others = [key for key in present if key not in wanted]
    fact = f"category_id {', '.join(key for key in present if key in wanted)} counted"
    if not others:
        return everything, [fact], []
    fact += f", {', '.join(f'{key} ({present[key]} results)' for key in others)} left out"
    keep = category.map({key: id_text(key) in wanted for key in category.unique()})
    return keep.to_numpy(dtype=bool), [fact], []


def _places_by_id(
    ids: pd.Series, file: SourceFile, images: pd.DataFrame | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Recording, frame and whether it is known, of every result."""
    if images is None:
        raise MissingFactError(
            "results name their images by id, and only the truth says which frame an id is; give "
            "a truth with an image list (COCO)",
            file=file.name,
        )
    if images["image_id"].duplicated().any():
        # the truth is several files with ids of their own: the file's name must say which
        name = recording_of(file.name, tuple(images["recording"].unique()))
        images = images[images["recording"] == name]
        if images["image_id"].duplicated().any() or images.empty:
            raise FormatError(
                "image ids stand for different images in the truth's files; expected results in "
                "one file per recording, named by it",
                file=file.name,
            )
    return places_of_rows(images, rows_by_id(ids, images["image_id"]))


def _places_by_name(
    pictures: pd.Series, file: SourceFile, images: pd.DataFrame | None, options: ReadOptions
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `_places_by_id`, from file names: those of the image list, or what they tell."""
    codes, names = pd.factorize(pictures)
    if images is not None and "file_name" in images:
        row = _rows_by_name(names, images["file_name"])
        if np.any(row >= 0):
            return places_of_rows(images, row[codes])
    known = options.recordings
    places = [place_of_picture(name, known) for name in names]  # text: one by one
    if None in places:
        raise FormatError(
            f"expected a frame number at the end of the file name, found "
            f"{names[places.index(None)]!r}",
            file=file.name,
        )
    recording = np.array([place[0] for place in places if place], dtype=object)
    frame = np.array([place[1] for place in places if place], dtype=np.int64)
    return recording[codes], frame[codes], np.ones(len(codes), dtype=bool)


def _rows_by_name(names: pd.Index[str], listed: pd.Series) -> np.ndarray:
    """Row of the list that has each name, whole or, where that is clear, without its folders."""
    whole = pd.Series(range(len(listed)), index=listed.to_numpy())
    whole = whole[~whole.index.duplicated(keep=False)]
    short = pd.Series(range(len(listed)), index=[_short(name) for name in listed])
    short = short[~short.index.duplicated(keep=False)]
    row = whole.index.get_indexer(names)
    row = np.where(row >= 0, whole.to_numpy()[row], -1) if len(whole) else row
    by_short = short.index.get_indexer(pd.Index([_short(name) for name in names]))
    by_short = np.where(by_short >= 0, short.to_numpy()[by_short], -1) if len(short) else by_short
    return np.where(row >= 0, row, by_short)


def _short(name: str) -> str:
    return name.replace("\\", "/").rsplit("/", 1)[-1]


FORMAT = Format(
    name="coco-results",
    title="COCO results",
    roles=("detections",),
    suffixes=(".json",),
    recognise=recognise,
    read=read,
)
