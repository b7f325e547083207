"""Columns of a COCO result file, fast where it is written as such files usually are."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.json

from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.coco.images import NAME_KEYS, id_text, id_texts, image_ids, read_images
from nvcore.inputs.readers.coco.truth import category_names
from nvcore.inputs.readers.parse.json import Records, read_json
from nvcore.inputs.readers.parse.text import read_bytes

KIND: Final = "category_name"
"""Field in which SAHI and others name the category beside its id."""


@dataclass(frozen=True)
class ResultColumns:
    """What is taken of the results, one entry each; None for a field that no result has.

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
        Names of the categories by their ids as text, where the file lists them.
    """

    box: np.ndarray
    score: np.ndarray | None
    category: pd.Series | None
    image_id: pd.Series | None
    picture: pd.Series | None
    track: pd.Series | None
    kind: pd.Series | None = None
    names: Mapping[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.box)


def read_columns(
    file: SourceFile, options: ReadOptions
) -> tuple[ResultColumns, pd.DataFrame | None]:
    """The results of a file, and its own image list if it has one.

    Raises
    ------
    FormatError
        With the first record that is no COCO result.
    """
    columns = _fast(file)
    return (columns, None) if columns is not None else _careful(file, options)


def _fast(file: SourceFile) -> ResultColumns | None:
    """A plain list by pyarrow, four times as fast; None where the careful parser must look.

    Pyarrow reads one object a line, so the commas between the objects become line ends. Where
    that is not all there is to it (such a comma in a text, an unusual type), pyarrow refuses.
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


def _schema(first: object) -> pa.Schema | None:
    """Types of the fields that are taken, from the first record; None if it is not usual."""
    if not isinstance(first, dict):
        return None
    usual: dict[str, tuple[type, ...]] = {
        "bbox": (list,),
        "score": (int, float),
        "category_id": (int,),
        "image_id": (int, str),
        **dict.fromkeys(NAME_KEYS, (str,)),
        "track_id": (int, str),
        KIND: (str,),
    }
    kinds = {list: pa.list_(pa.float64()), int: pa.int64(), str: pa.string()}
    if "bbox" not in first or any(
        type(value) not in usual[name] for name, value in first.items() if name in usual
    ):
        return None
    fields = []
    for name, allowed in usual.items():
        kind = type(first[name]) if name in first else allowed[0]
        fields.append((name, pa.float64() if name == "score" else kinds[kind]))
    return pa.schema(fields)


def _careful(file: SourceFile, options: ReadOptions) -> tuple[ResultColumns, pd.DataFrame | None]:
    """The records one by one, and the file's own image list if it has one."""
    document = read_json(file)
    own, key = None, ""
    names: dict[str, str] = {}
    if isinstance(document, dict):
        key = "annotations"
        if document.get("images"):
            own = read_images(document, file, options).table
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
    ), own
