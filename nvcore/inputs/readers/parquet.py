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
TEXTS_AT_ONCE: Final = 4096
"""Rows of a column of text that are decoded at a time: sizes in the file are claims."""
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
        raise FormatError(
            f"row {error.line - 1}: {error.message}", file=error.file, steps=error.steps
        ) from error
    return replace(reading, findings=tuple(with_row(finding) for finding in reading.findings))


def _named_columns(file: SourceFile) -> NamedColumns:
    import pyarrow.parquet as pq

    content = pa.BufferReader(read_bytes(file))
    with _faults_named(file):
        metadata = pq.read_metadata(content)
        # one text many times takes no more than its number: a small file may hold a million rows
        table = pq.ParquetFile(content, read_dictionary=_numbered_texts(metadata))
        header = header_of([name.strip() for name in table.schema_arrow.names])
        problem = missing_columns(header)
        if problem is not None:
            raise file.fault(f"expected {problem}")
        places = sorted(header.place.values())
        _check(table, header, places, content.size(), file)
        names = [table.schema_arrow.names[place] for place in places]
        columns = dict(zip(places, _read(table, names, content.size(), file).values(), strict=True))
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
    groups = [table.metadata.row_group(i).num_rows for i in range(table.num_row_groups)]
    n_rows = max(table.metadata.num_rows, sum(groups))  # one of them may lie
    needed = n_rows * len(places) * _BYTES_OF_A_NUMBER
    needed += _text_bytes(table.metadata, {names[place] for place in places})
    if min(n_rows, *groups, 0) < 0 or _is_too_much(needed, n_bytes):
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


class _Budget:
    """Counts what is decoded; FormatError once it is more than a file of this size may hold."""

    def __init__(self, file: SourceFile, n_bytes: int):
        self._file, self._n_bytes, self._n_read = file, n_bytes, 0

    def take(self, n_read: int) -> None:
        self._n_read += n_read
        if _is_too_much(self._n_read, self._n_bytes):
            raise _too_much("takes more than", self._n_read, self._n_bytes, self._file)


def _numbered_texts(metadata: pq.FileMetaData) -> list[str]:
    """Columns stored as numbers of texts throughout; pyarrow decodes others as texts alone."""
    groups = (metadata.row_group(i) for i in range(metadata.num_row_groups))
    chunks = [group.column(i) for group in groups for i in range(group.num_columns)]
    others = {
        chunk.path_in_schema
        for chunk in chunks
        if any("DELTA" in encoding for encoding in chunk.encodings)
    }
    texts = [field.name for field in metadata.schema.to_arrow_schema() if _is_text(field.type)]
    return [name for name in texts if name not in others]


def _read(
    table: pq.ParquetFile, names: Sequence[str], n_bytes: int, file: SourceFile
) -> dict[str, pa.ChunkedArray]:
    """These columns by name; FormatError once they take more than they may."""
    budget = _Budget(file, n_bytes)
    texts = [name for name in names if _holds_text(table.schema_arrow.field(name).type)]
    numbers = [name for name in names if name not in texts]
    groups = [_numbers(table, number, numbers, budget) for number in range(table.num_row_groups)]
    columns = pa.concat_tables(groups or [table.schema_arrow.empty_table().select(numbers)])
    for name in texts:
        columns = columns.append_column(name, _texts(table, name, budget, file))
    return {name: columns.column(name) for name in names}


def _numbers(table: pq.ParquetFile, group: int, names: list[str], budget: _Budget) -> pa.Table:
    """Numbers of a row group at once: they take what the number of rows says."""
    part = table.read_row_group(group, columns=names)
    budget.take(part.nbytes)
    return part


def _texts(table: pq.ParquetFile, name: str, budget: _Budget, file: SourceFile) -> pa.ChunkedArray:
    """Texts by number, a few rows at a time: how long they are is known when they are decoded."""
    chunks: list[pa.DictionaryArray] = []
    for batch in table.iter_batches(batch_size=TEXTS_AT_ONCE, columns=[name]):
        chunk = batch.column(0)
        if not pa.types.is_dictionary(chunk.type):
            chunk = chunk.dictionary_encode()
        if chunks and chunk.dictionary.equals(chunks[-1].dictionary):  # each comes with a copy
            chunk = pa.DictionaryArray.from_arrays(chunk.indices, chunks[-1].dictionary)
            budget.take(chunk.indices.nbytes)
        else:
            budget.take(chunk.nbytes)
            _check_texts(chunk.dictionary, file)
        chunks.append(chunk)
    if not chunks:
        return table.schema_arrow.empty_table().column(name)
    return pa.chunked_array(chunks)


def _check_texts(texts: pa.Array, file: SourceFile) -> None:
    """Raise FormatError for a text that no name is as long as."""
    longest = pc.max(pc.binary_length(texts)).as_py() or 0
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


def _holds_text(kind: pa.DataType) -> bool:
    return _is_text(kind.value_type if pa.types.is_dictionary(kind) else kind)


def _is_text(kind: pa.DataType) -> bool:
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


FORMAT: Final = Format("parquet", "Parquet", BOTH_ROLES, (".parquet", ".pq"), recognise, read)
