"""COCO results (JSON): a list of detections that name their image by id or by file name."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.json
from pandas.api.types import is_integer_dtype

from nvcore.common.errors import MissingFactError, UnnamedClassesError
from nvcore.common.findings import Finding, Remedy, Severity, Step
from nvcore.inputs.readers.base import (
    Format,
    LeftOut,
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    best_overlaps,
    reading_boxes,
    recordings_table,
    rows_finding,
    warning,
)
from nvcore.inputs.readers.coco.truth import (
    NAME_KEYS,
    category_names,
    id_text,
    id_texts,
    image_ids,
    places_of_rows,
    read_files,
    read_images,
    rows_by_id,
)
from nvcore.inputs.readers.meaning.classes import CategoryChoice, ClassNames, choose_categories
from nvcore.inputs.readers.meaning.frame_names import (
    in_file,
    places_of_pictures,
    rows_by_name,
    rows_by_text,
)
from nvcore.inputs.readers.meaning.names import plain_name, plain_names, recording_of
from nvcore.inputs.readers.meaning.values import TEXT_IDS, track_numbers
from nvcore.inputs.readers.parse.json import Records, read_json
from nvcore.inputs.readers.parse.rows import FilePart
from nvcore.inputs.readers.parse.text import read_bytes
from nvcore.inputs.readers.parse.unknown import foreign_format

_FIELDS = re.compile(r'"bbox"\s*:')
_IMAGE = re.compile(rf'"(?:image_id|{"|".join(NAME_KEYS)})"\s*:')
MOST_COMPARED: Final = 1000
"""Number of results that are compared with the truth's boxes if ids are ambiguous."""
KIND: Final = "category_name"
"""Field in which SAHI and others name the category beside its id."""
_WRAPPED = re.compile(r'"annotations"\s*:\s*\[')


def recognise(_name: str, head: str, _role: Role) -> bool:
    """Whether the text is a JSON list of objects with bbox and image, wrapped or not, or empty."""
    text = head.lstrip("\ufeff \t\r\n")
    if text.startswith("{"):
        return _WRAPPED.search(text) is not None and foreign_format(text) is None
    has_fields = _FIELDS.search(text) is not None and _IMAGE.search(text) is not None
    is_empty = re.match(r"\[\s*\]\s*$", text) is not None
    return is_empty or (re.match(r"\[\s*\{", text) is not None and has_fields)


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read COCO results by the truth's image list, or by the file's own if it has one."""
    return read_files(files, options, _read_part)[0]


def _read_part(file: SourceFile, number: int, options: ReadOptions) -> FilePart:
    columns = _fast(file)
    if columns is None:
        columns = _careful(file, options)
    images = options.images if columns.images is None else columns.images
    n_rows = len(columns)
    if not n_rows:
        return FilePart(
            Reading(reading_boxes(0), recordings_table(()), ""),
            ["an empty list: nothing was detected"],
        )
    is_wanted, facts, findings = np.ones(n_rows, dtype=bool), ["no category_id: all count"], []
    kind = np.full(n_rows, "", dtype=object)
    left_out: tuple[LeftOut, ...] = ()
    category, own_names = columns.category, columns.names
    if columns.kind is not None and not columns.kind.str.isdecimal().all():
        category = columns.kind
        own_names = {name: name for name in category.unique()}
    if category is not None:
        ids = category.unique()
        keys = category.map(dict(zip(ids, map(id_text, ids), strict=True)))
        choice, named = _choice(keys, own_names, file, options)
        is_wanted = keys.isin(choice.counted).to_numpy()
        counted = {key: named.names.get(key, "") for key in choice.counted}
        kind = keys.map(counted).fillna("").to_numpy()
        facts, findings, left_out = [choice.conversion], [*choice.findings], choice.left_out
    with in_file(file):
        places = _places(columns, is_wanted, file, images, options)
    facts.append(places.fact)
    findings += places.findings
    names = columns.image_id if columns.picture is None else columns.picture
    assert names is not None
    findings += rows_finding(
        ~places.is_known,
        "unknown-image",
        "Results that name an image which is not in the image list were left out.",
        "Check that the results belong to this truth, and that ids start at the same number.",
        role="detections",
        place=lambda row: (file.name, f"result {row + 1}, image {names.iloc[row]}"),
        severity=Severity.ERROR,
    )
    values: dict[str, object] = {}
    if columns.track is not None:
        values["track"], has_text = track_numbers(columns.track, places.recording)
        facts += [TEXT_IDS] if has_text else []
    if columns.score is not None:
        values["score"] = columns.score
    else:
        facts.append("no scores")
    keep = is_wanted & places.is_known
    boxes = Lines.of(file, np.arange(1, n_rows + 1)).boxes(
        columns.box.T,
        keep=keep,
        recording=places.recording,
        frame=places.frame,
        file=number,
        **values,
    )
    reading = Reading(
        boxes,
        recordings_table(boxes["recording"].unique()),
        "",
        findings=tuple(findings),
        left_out=left_out,
    )
    return FilePart(reading, facts, kind[keep])


def _choice(
    keys: pd.Series, own: Mapping[str, str], file: SourceFile, options: ReadOptions
) -> tuple[CategoryChoice, ClassNames]:
    """Choose the categories that count, by their names in the file or in the truth."""
    counts: dict[Any, int] = keys.value_counts().to_dict()
    theirs = options.names_for("coco")
    named = ClassNames(own) if own else ClassNames(theirs, "the ground truth" if theirs else "")
    unknown = counts.keys() - named.names.keys()
    # a single id may be any number if the truth has no other kind of objects
    others = [name for name in named.names.values() if not options.objects.concerns(name)]
    if named.names and len(counts) == 1 and unknown and not others and options.classes is None:
        named = ClassNames()
    elif named.names and unknown and _may_be_shifted(unknown, counts, named.names):
        if options.classes is not None and all(map(str.isdecimal, options.classes)):
            return _choice(keys, {key: key for key in counts}, file, options)
        raise UnnamedClassesError(
            f"results and ground truth number their classes differently: category_id "
            f"{', '.join(sorted(unknown))} of the results is none of {', '.join(named.names)}, "
            "the ids of the ground truth, and each id more or less by one would be: only you know "
            f"which numbers of the results are {options.objects.plural}",
            file=file.name,
            steps=(Step(Remedy.CLASSES),),
        )
    choice = choose_categories(counts, named, options, file=file.name, numbers="category_id")
    if counts and not counts.keys() & {*choice.counted}:
        expected = ", ".join(
            f"{key} ({named.names[key]})" if key in named.names else key for key in choice.counted
        )
        raise file.fault(
            f"expected results of category_id {expected or options.objects.plural}, found "
            + ", ".join(f"{key} ({n} results)" for key, n in counts.items()),
            steps=(Step(Remedy.CLASSES),),
        )
    if not named.names and options.classes is None and counts and "1" not in counts:
        finding = warning(
            "unusual-category",
            len(keys),
            f"All results have category_id {next(iter(counts))}, not 1 (person); all count.",
            "Check that they are pedestrians; naming the class ends this warning.",
            role="detections",
            file=file.name,
            example="result 1",
            steps=(Step(Remedy.CLASSES, next(iter(counts))),),
        )
        choice = replace(choice, findings=(*choice.findings, finding))
    return choice, named


def _may_be_shifted(unknown: Iterable[str], present: Iterable[str], names: Collection[str]) -> bool:
    """Whether ids that count from another number would all be known, such as 0 in place of 1."""
    numbers = [int(key) for key in {*unknown, *present} if key.isdecimal()]
    return len(numbers) == len({*unknown, *present}) and any(
        all(str(number + step) in names for number in numbers) for step in (1, -1)
    )


@dataclass(frozen=True)
class _Places:
    """Recording and frame of every result, with a text on how they were found."""

    recording: np.ndarray
    frame: np.ndarray
    is_known: np.ndarray
    fact: str
    findings: tuple[Finding, ...] = ()


def _places(
    columns: ResultColumns,
    is_wanted: np.ndarray,
    file: SourceFile,
    images: pd.DataFrame | None,
    options: ReadOptions,
) -> _Places:
    """Find the frames of results by the names of their pictures, else by image_id."""
    ids, pictures = columns.image_id, columns.picture
    by_name = None if pictures is None else _places_by_name(pictures, file, images, options)
    if by_name is not None and by_name.is_known.all() and _are_ids_repeated(images):
        return by_name
    by_id = None if ids is None else _places_by_id(ids, file, images, options)
    if pictures is not None and by_name is not None:
        if by_id is None or not by_name.is_known.all():
            return by_name if by_id is None or by_name.is_known.any() else by_id
        given = pd.Series([]) if ids is None else ids
        differs = by_id.is_known & (
            (by_id.recording != by_name.recording) | (by_id.frame != by_name.frame)
        )
        return replace(
            by_name,
            findings=tuple(
                rows_finding(
                    differs,
                    "image-id-contradicted",
                    "The image_id of results is that of another picture in the truth than their "
                    "file name: the name was taken.",
                    "Nothing to do if the names are right.",
                    role="detections",
                    place=lambda row: (
                        file.name,
                        f"result {row + 1}, {pictures.iloc[row]}, image_id {given.iloc[row]}",
                    ),
                    severity=Severity.NOTE,
                )
            ),
        )
    assert ids is not None
    assert by_id is not None
    if is_integer_dtype(ids.dtype) and not _has_numeric_names(images):
        return by_id
    by_stem = _places_by_stem(ids, images)
    n_by_id, n_by_stem = int(by_id.is_known.sum()), int(by_stem.is_known.sum())
    if n_by_stem == 0 or n_by_stem < n_by_id:
        return by_id
    is_same = (by_id.recording == by_stem.recording) & (by_id.frame == by_stem.frame)
    if n_by_stem == n_by_id and not is_same.all() and options.boxes is not None:
        # both interpretations apply to every result, so the boxes decide
        fits = [_fit(columns.box, places, is_wanted, options.boxes) for places in (by_id, by_stem)]
        if fits[1] > fits[0]:
            return replace(by_stem, fact=f"{by_stem.fact}, as the boxes fit so")
        return by_id
    return by_stem if n_by_stem > n_by_id else by_id


def _places_by_id(
    ids: pd.Series, file: SourceFile, images: pd.DataFrame | None, options: ReadOptions
) -> _Places:
    """Find frames by the ids of the image list. Other text is the name of a picture."""
    if images is None and options.named is not None and not is_integer_dtype(ids.dtype):
        return _places_by_name(ids, file, images, options)
    if images is None:
        raise MissingFactError(
            "results name their images by id, and only the truth says which frame an id is; give "
            "a truth with an image list (COCO)",
            file=file.name,
        )
    if _are_ids_repeated(images):
        # the truth has several files with ids of their own: the file's name must identify one
        if not is_integer_dtype(ids.dtype):
            by_name = _places_by_name(ids, file, images, options)
            if by_name.is_known.all():
                return by_name
        name = recording_of(file.name, tuple(images["recording"].unique()))
        images = images[images["recording"] == name]
        if images["image_id"].duplicated().any() or images.empty:
            raise file.fault(
                "image ids stand for different images in the truth's files; expected results in "
                "one file per recording, named by it"
            )
    return _Places(
        *places_of_rows(images, rows_by_id(ids, images["image_id"])),
        "recording and frame from the image list by image_id",
    )


def _are_ids_repeated(images: pd.DataFrame | None) -> bool:
    """Whether the truth has several files that use the same image ids."""
    return images is not None and bool(images["image_id"].duplicated().any())


def _has_numeric_names(images: pd.DataFrame | None) -> bool:
    """Whether the first picture, and so probably all, may be named by a number alone."""
    if images is None or images.empty or "file_name" not in images:
        return False
    return plain_name(str(images["file_name"].iloc[0])).rpartition("/")[2].isdecimal()


def _places_by_stem(ids: pd.Series, images: pd.DataFrame | None) -> _Places:
    """Find frames by ids that are names of pictures: 12 or "000012" for 000012.jpg."""
    codes, texts = pd.factorize(ids.map(id_text))
    row = np.full(len(texts), -1)
    if images is not None and "file_name" in images:
        listed = images["file_name"].tolist()
        row = rows_by_name([*texts], listed)[0]
        if (row < 0).all():
            stems = [name.rpartition("/")[2] for name in plain_names(listed)[0]]
            numbers = [str(int(stem)) if stem.isdecimal() else "" for stem in stems]
            row = rows_by_text([*texts], numbers)
    else:
        images = pd.DataFrame()
    return _Places(
        *places_of_rows(images, row[codes]),
        "recording and frame from the image list by image_id = file name",
    )


def _fit(box: np.ndarray, places: _Places, rows: np.ndarray, truth: pd.DataFrame) -> float:
    """Estimate the mean best IoU of results with the truth of their frame, 0 to 1."""
    rows = np.flatnonzero(rows & places.is_known)
    rows = rows[:: max(1, len(rows) // MOST_COMPARED)]
    here = pd.DataFrame(box[rows], columns=["x", "y", "w", "h"])
    here = here.assign(recording=places.recording[rows], frame=places.frame[rows])
    return float(best_overlaps(here, truth).sum() / max(1, len(rows)))


def _places_by_name(
    pictures: pd.Series, file: SourceFile, images: pd.DataFrame | None, options: ReadOptions
) -> _Places:
    """Find frames by file names in the image list, or parse the names."""
    fact = "recording and frame from the pictures' names"
    if images is not None and "file_name" in images:
        codes, names = pd.factorize(pictures)
        row = rows_by_name([*map(str, names)], images["file_name"].tolist())[0]
        if np.any(row >= 0):
            return _Places(*places_of_rows(images, row[codes]), fact)
    recording, frame, _ = places_of_pictures(
        pictures,
        options,
        lambda _row, name: file.fault(
            f"expected a frame number at the end of the file name, found {name!r}"
        ),
    )
    return _Places(recording, frame, np.ones(len(frame), dtype=bool), fact)


@dataclass(frozen=True)
class ResultColumns:
    """Columns of the results, with one entry per result, or None if no result has the field.

    Attributes
    ----------
    box
        x, y, w, h in pixels, float64, shape (n, 4).
    score
        float64, shape (n,); NaN where missing.
    category, image_id
        Whole numbers or text.
    picture
        File name of the picture.
    track
        Track id as a number or text.
    kind
        Name of the category beside its id, text.
    names
        Names of the categories by their ids as text, if the file lists them.
    images
        The file's own image list.
    """

    box: np.ndarray
    score: np.ndarray | None
    category: pd.Series | None
    image_id: pd.Series | None
    picture: pd.Series | None
    track: pd.Series | None
    kind: pd.Series | None = None
    names: Mapping[str, str] = field(default_factory=dict)
    images: pd.DataFrame | None = None

    def __len__(self) -> int:
        return len(self.box)


def _fast(file: SourceFile) -> ResultColumns | None:
    """Read a plain list by pyarrow, four times as fast, or return None to use `_careful`.

    Pyarrow reads one object per line, so the commas between objects are replaced by line ends.
    Pyarrow refuses files where this is not enough, such as with an unusual type.
    """
    content = read_bytes(file).strip()
    if not content.startswith(b"[") or not content.endswith(b"]"):
        return None
    try:
        first = json.JSONDecoder().raw_decode(
            content[1:10_000].decode("utf-8", "replace").lstrip()
        )[0]
    except (ValueError, RecursionError):
        return None
    schema = _schema(first)
    if schema is None:
        return None
    lines = content[1:-1].strip()
    for between in (b"},{", b"}, {", b"},\n{"):
        lines = lines.replace(between, b"}\n{")
    n_lines = lines.count(b"\n") + 1
    try:
        table = pyarrow.json.read_json(
            io.BytesIO(lines),
            read_options=pyarrow.json.ReadOptions(block_size=1 << 24),
            parse_options=pyarrow.json.ParseOptions(
                explicit_schema=schema, unexpected_field_behavior="ignore"
            ),
        )
    except pa.ArrowInvalid:
        return None
    table = table.combine_chunks()
    box = table["bbox"].combine_chunks()
    lengths = box.value_lengths().to_numpy(zero_copy_only=False)
    numbers = box.flatten()
    is_whole = len(table) == n_lines and np.all(lengths == 4) and not numbers.null_count
    gaps = {table[name].null_count for name in table.column_names} - {0, n_lines}
    columns = {
        name: table[name].to_pandas()
        for name in table.column_names
        if name != "bbox" and not table[name].null_count
    }
    picture = next((columns[name] for name in NAME_KEYS if name in columns), None)
    if gaps or not is_whole or (picture is None and "image_id" not in columns):
        return None
    return ResultColumns(
        box=numbers.to_numpy().reshape(-1, 4),
        score=columns["score"].to_numpy() if "score" in columns else None,
        category=columns.get("category_id"),
        image_id=columns.get("image_id"),
        picture=picture,
        track=columns.get("track_id"),
        kind=columns.get(KIND),
    )


_ARROW: Final = {list: pa.list_(pa.float64()), int: pa.int64(), str: pa.string()}
_USUAL: Final[dict[str, tuple[type, ...]]] = {
    "bbox": (list,),
    "score": (float, int),
    "category_id": (int,),
    "image_id": (int, str),
    **dict.fromkeys(NAME_KEYS, (str,)),
    "track_id": (int, str),
    KIND: (str,),
}
"""Types of the fields. The first type is the default if the first record lacks the field."""


def _schema(first: object) -> pa.Schema | None:
    """Infer the types of fields from the first record, or return None if it is unusual."""
    if not (isinstance(first, dict) and "bbox" in first):
        return None
    types = {name: type(first.get(name, usual[0]())) for name, usual in _USUAL.items()}
    if any(types[name] not in usual for name, usual in _USUAL.items()):
        return None
    return pa.schema(
        {name: _ARROW.get(kind, pa.float64()) for name, kind in types.items()}
        | {"score": pa.float64()}
    )


def _careful(file: SourceFile, options: ReadOptions) -> ResultColumns:
    """Read the records one by one."""
    document = read_json(file)
    own, key = None, ""
    names: dict[str, str] = {}
    if isinstance(document, dict):
        key = "annotations"
        if document.get("images"):
            own = read_images(document, file, options)[1]
        names = category_names(document, file)
        document = document.get(key)
    records = Records(document, file, "result", key)
    category = records.values("category_id")
    picture = records.values(*NAME_KEYS)
    texts: set[type] = {str, type(None)}
    records.check_types(category or [], texts | {int, float}, "a number or text as category_id")
    records.check_types(picture or [], texts, "a number or text as file name")
    kind = records.values(KIND)
    records.check_types(kind or [], texts, f"text as {KIND}")
    track = id_texts(records, "track_id", "track_id")
    has_ids = records.values("image_id") is not None and (
        picture is None or None not in (records.values("image_id") or [])
    )
    if len(records) and not has_ids and (picture is None or None in picture):
        first = picture.index(None) if picture is not None else 0
        raise records.error(first, 'expected the field "image_id" or "image_filepath", found none')
    return ResultColumns(
        box=records.boxes() if len(records) else np.empty((0, 4)),
        score=records.numbers("score"),
        category=None if category is None else pd.Series(category, dtype=object).map(id_text),
        image_id=image_ids(records, "image_id") if has_ids else None,
        picture=None if picture is None else pd.Series(picture, dtype=object),
        track=track,
        kind=None if kind is None or None in kind else pd.Series(kind, dtype=object),
        names=names,
        images=own,
    )


FORMAT = Format("coco-results", "COCO results", ("detections",), (".json",), recognise, read)
