"""Decode Parquet in a separate process, because Arrow aborts on some damaged files.

``python decoder.py`` answers requests of `nvcore.inputs.readers.parquet` on standard
input: a file's content with the names of its columns, then requested columns. Numbers follow an
answer in their memory layout, to be read into arrays. It imports only pyarrow, so that it starts in
a tenth of a second.
"""

from __future__ import annotations

import pickle
import signal
import sys
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Final

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

TEXTS_AT_ONCE: Final = 4096
"""Rows of text that are decoded at a time, since sizes in the file are not to be trusted."""
_BYTES_OF_A_NUMBER: Final = 8
_FAULTS: Final = (pa.ArrowException, OSError, ValueError, LookupError, OverflowError)
"""Exceptions that pyarrow raises for damaged and malicious files."""


class RefusedError(Exception):
    """An intact table that is not accepted, for the reason in the text."""


class ParquetTable:
    """Parquet file with the names of its columns, which are decoded on request."""

    def __init__(self, content: bytes) -> None:
        self._n_bytes, buffer = len(content), pa.BufferReader(content)
        metadata = pq.read_metadata(buffer)
        # dictionaries store a repeated text once, as a small file may repeat one a million times
        self._file = pq.ParquetFile(buffer, read_dictionary=_numbered_texts(metadata))
        self.names: list[str] = self._file.schema_arrow.names

    def columns(
        self, places: Sequence[int], limits: Mapping[str, int]
    ) -> dict[int, pa.ChunkedArray]:
        """Decode the columns at these positions, texts as a dictionary.

        Parameters
        ----------
        limits
            ``ratio``: most decoded bytes per byte of the file, if they exceed ``ratio_from``.
            ``unpacked``: most bytes in all. ``text``: most bytes of one text.

        Raises
        ------
        RefusedError
            If a column is of another kind, or the columns would be too large.
        """
        budget = _Budget(self._n_bytes, limits)
        self._check(places, budget)
        names = [self.names[place] for place in places]
        schema = self._file.schema_arrow
        texts = [name for name in names if _holds_text(schema.field(name).type)]
        numbers = [name for name in names if name not in texts]
        groups = []
        for number in range(self._file.num_row_groups):  # sized by their number of rows
            groups.append(self._file.read_row_group(number, columns=numbers))
            budget.take(groups[-1].nbytes)
        table = pa.concat_tables(groups or [schema.empty_table().select(numbers)])
        columns = {name: table.column(name) for name in numbers}
        columns |= {name: self._texts(name, budget, limits["text"]) for name in texts}
        for name, column in columns.items():
            if len(column) != len(columns[names[0]]):  # columns have separate pages
                raise ValueError(
                    f"column {_short(name)} has {len(column):,} rows, column {_short(names[0])} "
                    f"{len(columns[names[0]]):,}"
                )
        return {place: columns[name] for place, name in zip(places, names, strict=True)}

    def _check(self, places: Sequence[int], budget: _Budget) -> None:
        """Refuse columns that are neither numbers nor text, and too many rows."""
        schema, metadata = self._file.schema_arrow, self._file.metadata
        for place in places:
            name, kind = self.names[place], schema.field(place).type
            if self.names.count(name) > 1:
                raise RefusedError(
                    f"expected one column {_short(name)}, found {self.names.count(name)}"
                )
            if not _is_simple(kind):
                raise RefusedError(
                    f"expected numbers or text in column {_short(name)}, found {_short(str(kind))}"
                )
        groups = [metadata.row_group(i).num_rows for i in range(metadata.num_row_groups)]
        n_rows = max(metadata.num_rows, sum(groups))  # either may be wrong
        needed = n_rows * len(places) * _BYTES_OF_A_NUMBER
        needed += _text_bytes(metadata, {self.names[place] for place in places})
        if min(n_rows, *groups, 0) < 0 or budget.is_exceeded_by(needed):
            raise budget.exceeded(f"declares {n_rows:,} rows, which would take", needed)

    def _texts(self, name: str, budget: _Budget, longest_text: int) -> pa.ChunkedArray:
        """Decode texts as a dictionary, a few rows at a time, since their size is unknown."""
        chunks: list[pa.DictionaryArray] = []
        for batch in self._file.iter_batches(batch_size=TEXTS_AT_ONCE, columns=[name]):
            chunk = batch.column(0)
            if not pa.types.is_dictionary(chunk.type):
                chunk = chunk.dictionary_encode()
            if chunks and chunk.dictionary.equals(chunks[-1].dictionary):  # each has a copy
                chunk = pa.DictionaryArray.from_arrays(chunk.indices, chunks[-1].dictionary)
                budget.take(chunk.indices.nbytes)
            else:
                budget.take(chunk.nbytes)
                chunk.dictionary.validate(full=True)  # checks UTF-8, which nothing else does
                lengths = pc.binary_length(chunk.dictionary)
                longest = pc.max(lengths).as_py() or 0
                if longest > longest_text:
                    raise RefusedError(
                        f"expected texts of at most {longest_text:,} bytes, found one of "
                        f"{longest:,}"
                    )
            budget.take_texts(name, pc.sum(lengths.take(chunk.indices)).as_py() or 0)
            chunks.append(chunk)
        if not chunks:
            return self._file.schema_arrow.empty_table().column(name)
        # one chunk, so that the dictionary is sent once
        return pa.chunked_array([pa.chunked_array(chunks).unify_dictionaries().combine_chunks()])


class _Budget:
    """Counter of decoded bytes, with a limit by the size of the file."""

    def __init__(self, n_bytes: int, limits: Mapping[str, int]) -> None:
        self._n_bytes, self._limits = n_bytes, limits
        self._n_read = self._n_written_out = 0

    def take(self, n_bytes: int) -> None:
        """Count decoded bytes, or raise RefusedError over the limit."""
        self._n_read += n_bytes
        if self.is_exceeded_by(self._n_read):
            raise self.exceeded("takes more than", self._n_read)

    def take_texts(self, name: str, n_bytes: int) -> None:
        """Count bytes of texts with repetitions, limited as in a compressed CSV file."""
        self._n_written_out += n_bytes
        if self._n_written_out > self._limits["unpacked"]:
            raise RefusedError(
                f"repeats texts in column {_short(name)} so often that its rows have more than "
                f"{self._limits['unpacked'] >> 30} GiB of text; give several smaller files"
            )

    def is_exceeded_by(self, n_bytes: int) -> bool:
        """Whether this number of bytes exceeds the limits."""
        limits = self._limits
        is_bomb = n_bytes > limits["ratio_from"] and n_bytes > limits["ratio"] * self._n_bytes
        return is_bomb or n_bytes > limits["unpacked"]

    def exceeded(self, what: str, n_bytes: int) -> RefusedError:
        """Return the error for an exceeded limit."""
        return RefusedError(
            f"{what} {n_bytes / 2**30:,.1f} GiB, in a file of {self._n_bytes / 2**20:,.1f} MiB; "
            f"expected at most {self._limits['ratio']} times its size, and "
            f"{self._limits['unpacked'] >> 30} GiB: give several smaller files"
        )


def _numbered_texts(metadata: pq.FileMetaData) -> list[str]:
    """List text columns that pyarrow can decode as a dictionary (without delta encoding)."""
    groups = (metadata.row_group(i) for i in range(metadata.num_row_groups))
    chunks = [group.column(i) for group in groups for i in range(group.num_columns)]
    others = {
        chunk.path_in_schema
        for chunk in chunks
        if any("DELTA" in encoding for encoding in chunk.encodings)
    }
    texts = [field.name for field in metadata.schema.to_arrow_schema() if is_text(field.type)]
    return [name for name in texts if name not in others]


def _text_bytes(metadata: pq.FileMetaData, names: Collection[str]) -> int:
    """Return the size in bytes of the texts of these columns, as stored but uncompressed."""
    groups = (metadata.row_group(i) for i in range(metadata.num_row_groups))
    chunks = (group.column(i) for group in groups for i in range(group.num_columns))
    return sum(
        max(chunk.total_uncompressed_size, 0)
        for chunk in chunks
        if chunk.physical_type == "BYTE_ARRAY" and chunk.path_in_schema in names
    )


def _is_simple(kind: pa.DataType) -> bool:
    value = kind.value_type if pa.types.is_dictionary(kind) else kind
    checks = (
        *(pa.types.is_integer, pa.types.is_floating, pa.types.is_decimal, pa.types.is_boolean),
        *(pa.types.is_string, pa.types.is_large_string, pa.types.is_null),
    )
    return any(check(value) for check in checks)


def _holds_text(kind: pa.DataType) -> bool:
    return is_text(kind.value_type if pa.types.is_dictionary(kind) else kind)


def is_text(kind: pa.DataType) -> bool:
    """Whether values of this type are text."""
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def _short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= 60 else f"{text[:59]}…"


def _is_plain(column: pa.ChunkedArray) -> bool:
    """Whether the values are numbers that an array can hold, without missing ones."""
    kind = column.type
    is_number = pa.types.is_integer(kind) or pa.types.is_floating(kind)
    return is_number and not pa.types.is_float16(kind) and column.null_count == 0


def main() -> None:
    """Answer requests until there are no more by (state, value, types), or an error's text.

    The types and numbers of rows, by index, belong to columns that follow the answer.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles ^C, and ends this process
    requests, answers = sys.stdin.buffer, sys.stdout.buffer
    table: ParquetTable | None = None
    while True:
        try:
            content, places, limits = pickle.load(requests)  # noqa: S301  # of our own program
        except EOFError:
            return
        answer: tuple[str, Any, dict[int, tuple[type, int]]]
        plain: dict[int, pa.ChunkedArray] = {}
        try:
            if content is not None:
                table = None  # frees the previous table first
                table = ParquetTable(content)
                answer = ("fine", table.names, {})
            else:
                assert table is not None
                columns = table.columns(places, limits)
                plain = {place: columns.pop(place) for place in places if _is_plain(columns[place])}
                types = {place: (of.type.to_pandas_dtype(), len(of)) for place, of in plain.items()}
                answer = ("fine", columns, types)
        except RefusedError as error:
            answer = ("refused", str(error), {})
        except _FAULTS as error:
            answer = ("fault", str(error), {})
        pickle.dump(answer, answers, protocol=5)
        for column in plain.values():
            for chunk in column.chunks:
                answers.write(chunk.to_numpy())
        answers.flush()
        del content, answer, plain


if __name__ == "__main__":
    main()
