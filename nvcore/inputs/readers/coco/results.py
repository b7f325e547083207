"""COCO results (JSON): a list of detections that name their image by id or by file name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from nvcore.errors import MissingFactError
from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import (
    Format,
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    concat_boxes,
    conversion_text,
    reading_boxes,
    recordings_table,
    rows_finding,
    warning,
)
from nvcore.inputs.readers.coco.images import (
    id_text,
    places_of_pictures,
    places_of_rows,
    rows_by_id,
)
from nvcore.inputs.readers.coco.result_columns import ResultColumns, read_columns
from nvcore.inputs.readers.meaning.labels import labelled
from nvcore.inputs.readers.meaning.names import recording_of
from nvcore.inputs.readers.meaning.tracks import TEXT_IDS, track_numbers
from nvcore.wording.objects import PEDESTRIAN

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
    tables, kinds = [], []
    facts = ["boxes as they are (0-based)"]
    findings: list[Finding] = []
    for number, file in enumerate(files):
        columns, own = read_columns(file)
        images = options.images if own is None else own
        boxes, new_facts, oddities, kind = _boxes(columns, file, number, images, options)
        tables.append(boxes)
        kinds.append(kind)
        facts += new_facts
        findings += oddities
    boxes = concat_boxes(tables)
    kind = np.concatenate(kinds) if kinds else np.empty(0, dtype=object)
    codes, labels = labelled(kind, kind != "", options.objects)
    return Reading(
        boxes=boxes.assign(label=codes),
        recordings=recordings_table(boxes["recording"].unique()),
        conversion=conversion_text(facts),
        findings=tuple(findings),
        labels=labels,
    )


def _boxes(
    columns: ResultColumns,
    file: SourceFile,
    number: int,
    images: pd.DataFrame | None,
    options: ReadOptions,
) -> tuple[pd.DataFrame, list[str], list[Finding], np.ndarray]:
    """Boxes of a file, the conversion in words, what is odd; class of boxes, empty if unknown."""
    n_rows = len(columns)
    if not n_rows:
        empty = np.empty(0, dtype=object)
        return reading_boxes(0), ["an empty list: nothing was detected"], [], empty
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
    boxes = Lines.of(file, np.arange(1, n_rows + 1)).boxes(
        columns.box.T,
        keep=is_wanted & is_known,
        recording=recording,
        frame=frame,
        file=number,
        **values,
    )
    kind = np.full(n_rows, "", dtype=object)
    if columns.category is not None:
        keys = columns.category.unique()
        name_of = {key: options.categories.get(id_text(key), "") for key in keys}
        kind = columns.category.map(name_of).fillna("").to_numpy(dtype=object)
    return boxes, facts, findings, kind[is_wanted & is_known]


def _categories(
    category: pd.Series | None, file: SourceFile, options: ReadOptions, n_rows: int
) -> tuple[np.ndarray, list[str], list[Finding]]:
    """Which results are of a class that counts, and the rule in words."""
    everything = np.ones(n_rows, dtype=bool)
    if category is None:
        return everything, ["no category_id: all results count"], []
    present = {id_text(key): count for key, count in category.value_counts(dropna=False).items()}
    listed = ", ".join(f"{key} ({count} results)" for key, count in present.items())
    objects = options.objects
    counted = {PERSON}
    if not objects.are_pedestrians:
        counted = {key for key, name in options.categories.items() if objects.counts(name)}
    if options.classes is not None:
        # results have no names for their categories: a person's number is known, and the truth's
        key_of = {name.casefold(): key for key, name in options.categories.items()}
        wanted = [key_of.get(name.casefold(), name) for name in options.classes]
        names = [name for name in wanted if not name.isdecimal()]
        persons = [name for name in names if PEDESTRIAN.counts(name)]
        counted = set(wanted) - set(names) | ({PERSON} if persons else set())
        if len(persons) < len(names) and set(present) - counted:
            raise file.fault(
                f"results number their classes: found category_id {listed}; give the classes as "
                "numbers"
            )
    if not counted & set(present):
        if len(present) > 1 or options.classes is not None:
            expected = ", ".join(sorted(counted)) or f"{objects.plural} alone"
            raise file.fault(
                f"expected results of category_id {expected}, found {listed}; "
                f"name the category ids that are {objects.plural} as classes"
            )
        if not objects.are_pedestrians:  # of whose number in COCO nothing is known
            return everything, [f"category_id {next(iter(present))} counted"], []
        finding = warning(
            "unusual-category",
            n_rows,
            f"All results have category_id {next(iter(present))}, not 1 (person); all count.",
            "Check that they are pedestrians; naming the class (--classes) ends this warning.",
            role="detections",
            file=file.name,
            example="result 1",
        )
        return everything, [f"category_id {next(iter(present))} counted"], [finding]
    others = [key for key in present if key not in counted]
    fact = f"category_id {', '.join(key for key in present if key in counted)} counted"
    if not others:
        return everything, [fact], []
    fact += f", {', '.join(f'{key} ({present[key]} results)' for key in others)} left out"
    keep = category.map({key: id_text(key) in counted for key in category.unique()})
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
            raise file.fault(
                "image ids stand for different images in the truth's files; expected results in "
                "one file per recording, named by it"
            )
    return places_of_rows(images, rows_by_id(ids, images["image_id"]))


def _places_by_name(
    pictures: pd.Series, file: SourceFile, images: pd.DataFrame | None, options: ReadOptions
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `_places_by_id`, from file names: those of the image list, or parsed."""
    if images is not None and "file_name" in images:
        codes, names = pd.factorize(pictures)
        row = _rows_by_name(names, images["file_name"])
        if np.any(row >= 0):
            return places_of_rows(images, row[codes])
    recording, frame = places_of_pictures(
        pictures,
        options.recordings,
        lambda _row, name: file.fault(
            f"expected a frame number at the end of the file name, found {name!r}"
        ),
    )
    return recording, frame, np.ones(len(frame), dtype=bool)


def _rows_by_name(names: Iterable[str], listed: Iterable[str]) -> np.ndarray:
    """Row of the list that has each name, whole or, where that is clear, without its folders."""
    by_path = _rows_by_text(names, listed)
    by_name = _rows_by_text(map(_short, names), map(_short, listed))
    return np.where(by_path >= 0, by_path, by_name)


def _rows_by_text(names: Iterable[str], listed: Iterable[str]) -> np.ndarray:
    """Row of the list that has each text; -1 where none or several have it."""
    index = pd.Index(list(listed))
    rows = np.flatnonzero(~index.duplicated(keep=False))
    place = index[rows].get_indexer(pd.Index(list(names)))
    return np.append(rows, -1)[place]


def _short(name: str) -> str:
    """File name without folders."""
    return name.replace("\\", "/").rsplit("/", 1)[-1]


FORMAT = Format("coco-results", "COCO results", ("detections",), (".json",), recognise, read)
