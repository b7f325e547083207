"""Parquet: a table whose columns are called as in plain CSV."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from nvcore.errors import FormatError
from nvcore.inputs.packed import MAX_RATIO, MAX_UNPACKED_BYTES, RATIO_FROM_BYTES
from nvcore.inputs.readers.base import BOTH_ROLES, Format, Reading, ReadOptions, Role, SourceFile
from nvcore.inputs.readers.csv import NamedColumns, missing_columns, read_named_columns
from nvcore.inputs.readers.csv_columns import Header, header_of
from nvcore.inputs.readers.parse.text import read_bytes
from nvcore.inputs.readers.table import parse_columns, with_row
from nvcore.wording import shortened

if TYPE_CHECKING:
    import pyarrow.parquet as pq

MAGIC: Final = "PAR1"
MAX_TEXT_BYTES: Final = 1 << 14
"""Longest text, several times the longest path that systems take."""
_BYTES_OF_A_NUMBER: Final = 8


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether it begins as Parquet does, and is no text."""
    del name, role
    return head.startswith(MAGIC) and "\x00" in head


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read Parquet files as if they were plain CSV; see `nvcore.inputs.readers.csv.read`.

    Numbers may be of any numeric type, or text; text may be coded as a dictionary. A null is an
    empty field.

    Raises
    ------
    FormatError
        With the row, counted from 0, of what is no number; or if the file is damaged, lacks a
        column, has one of another type, or would be too large in memory.
    """
    try:
        reading = read_named_columns([_named_columns(file) for file in files], options)
    except FormatError as error:
        if error.line is None:
            raise
        raise FormatError(f"row {error.line - 1}: {error.message}", file=error.file) from error
    return replace(reading, findings=tuple(with_row(finding) for finding in reading.findings))


def _named_columns(file: SourceFile) -> NamedColumns:
    import pyarrow.parquet as pq

    content = pa.BufferReader(read_bytes(file))
    with _faults_named(file):
        schema = pq.read_schema(content)
        # one text many times takes no more than its number: a small file may hold a million rows
        texts = [field.name for field in schema if _is_text(field.type)]
        table = pq.ParquetFile(content, read_dictionary=texts)
        header = header_of([name.strip() for name in table.schema_arrow.names])
        problem = missing_columns(header)
        if problem is not None:
            raise file.fault(f"expected {problem}")
        places = sorted(header.place.values())
        _check(table, header, places, content.size(), file)
        names = [table.schema_arrow.names[place] for place in places]
        columns = dict(zip(places, _read(table, names, content.size(), file).columns, strict=True))
        series = {name: _series(columns[place]) for name, place in header.place.items()}
        n_rows = len(columns[places[0]])
    parse = partial(parse_columns, series.__getitem__, n_rows, file, header)
    return NamedColumns(file, header, parse)


@contextmanager
def _faults_named(file: SourceFile) -> Iterator[None]:
    """Within it, what pyarrow raises for damaged and hostile files is a FormatError."""
    try:
        yield
    except (pa.ArrowException, OSError, ValueError, LookupError, OverflowError) as error:
        reason = shortened(" ".join(str(error).split()), 120)
        raise file.fault(f"expected a whole Parquet table, found a fault: {reason}") from error


def _check(
    table: pq.ParquetFile, header: Header, places: Sequence[int], n_bytes: int, file: SourceFile
) -> None:
    """Raise FormatError for columns that are no numbers or text, and for too many rows."""
    names = table.schema_arrow.names
    for place in places:
        title = shortened(header.names[place], 60)
        if names.count(names[place]) > 1:
            raise file.fault(f"expected one column {title}, found {names.count(names[place])}")
        kind = table.schema_arrow.field(place).type
        if not _is_simple(kind):
            raise file.fault(
                f"expected numbers or text in column {title}, found {shortened(str(kind), 60)}"
            )
    n_rows = table.metadata.num_rows
    needed = n_rows * len(places) * _BYTES_OF_A_NUMBER
    needed += _text_bytes(table.metadata, {names[place] for place in places})
    if n_rows < 0 or _is_too_much(needed, n_bytes):
        raise _too_much(f"declares {n_rows:,} rows, which would take", needed, n_bytes, file)


def _text_bytes(metadata: pq.FileMetaData, names: Collection[str]) -> int:
    """What the texts of these columns take as they are stored, unpacked."""
    groups = (metadata.row_group(i) for i in range(metadata.num_row_groups))
    chunks = (group.column(i) for group in groups for i in range(group.num_columns))
    return sum(
        max(chunk.total_uncompressed_size, 0)
        for chunk in chunks
        if chunk.physical_type == "BYTE_ARRAY" and chunk.path_in_schema in names
    )


def _read(table: pq.ParquetFile, names: list[str], n_bytes: int, file: SourceFile) -> pa.Table:
    """These columns, part by part; FormatError once they take more than they may."""
    if not table.num_row_groups:
        return table.read(columns=names)
    parts, n_read = [], 0
    for number in range(table.num_row_groups):
        part = table.read_row_group(number, columns=names)
        n_read += part.nbytes
        if _is_too_much(n_read, n_bytes):
            raise _too_much("takes more than", n_read, n_bytes, file)
        for column in part.columns:
            _check_texts(column, file)
        parts.append(part)
    return pa.concat_tables(parts)


def _check_texts(column: pa.ChunkedArray, file: SourceFile) -> None:
    """Raise FormatError for a text that no name is as long as."""
    for chunk in column.chunks:
        texts = chunk.dictionary if pa.types.is_dictionary(chunk.type) else chunk
        longest = (pc.max(pc.binary_length(texts)).as_py() if _is_text(texts.type) else None) or 0
        if longest > MAX_TEXT_BYTES:
            raise file.fault(
                f"expected texts of at most {MAX_TEXT_BYTES:,} bytes, found one of {longest:,}"
            )


def _is_too_much(needed: int, n_bytes: int) -> bool:
    is_bomb = needed > RATIO_FROM_BYTES and needed > MAX_RATIO * n_bytes
    return is_bomb or needed > MAX_UNPACKED_BYTES


def _too_much(what: str, needed: int, n_bytes: int, file: SourceFile) -> FormatError:
    return file.fault(
        f"{what} {needed / 2**30:,.1f} GiB, in a file of {n_bytes / 2**20:,.1f} MiB; expected at "
        f"most {MAX_RATIO} times its size, and {MAX_UNPACKED_BYTES >> 30} GiB: give several "
        "smaller files"
    )


def _is_simple(kind: pa.DataType) -> bool:
    value = kind.value_type if pa.types.is_dictionary(kind) else kind
    checks = (
        *(pa.types.is_integer, pa.types.is_floating, pa.types.is_decimal, pa.types.is_boolean),
        *(pa.types.is_string, pa.types.is_large_string, pa.types.is_null),
    )
    return any(check(value) for check in checks)


def _series(column: pa.ChunkedArray) -> pd.Series:
    """A column as pandas holds it: numbers, bool, or categories of text; nulls are missing."""
    kind = column.type
    if pa.types.is_null(kind):
        return pd.Series(np.full(len(column), np.nan))
    if pa.types.is_boolean(kind):
        return pd.Series(column.fill_null(False).to_numpy())
    if pa.types.is_decimal(kind) or pa.types.is_float16(kind):
        column = column.cast(pa.float64())
    if pa.types.is_dictionary(kind) and not _is_text(kind.value_type):
        column = column.cast(kind.value_type)
        return _series(column)
    if _is_text(kind):
        column = column.dictionary_encode()
    series: pd.Series = column.to_pandas()
    return series


def _is_text(kind: pa.DataType) -> bool:
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


FORMAT: Final = Format("parquet", "Parquet", BOTH_ROLES, (".parquet", ".pq"), recognise, read)
