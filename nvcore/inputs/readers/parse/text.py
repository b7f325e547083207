"""Fast reading of delimited number tables, with errors that name the line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.csv

from nvcore.errors import FormatError, InputError
from nvcore.file_kinds import binary_kind
from nvcore.inputs.readers.base import SourceFile
from nvcore.wording import shortened

MAX_INTEGER = 2.0**53
"""Largest number that is exact as float64: frame numbers and track ids stay below it."""
_SMALL = 2048
"""Bytes below which the careful parser is as quick as starting pyarrow (one file per frame)."""
_BLOCK = 1 << 24
"""Bytes that pyarrow takes at a time; measured: twice as quick as its default of 1 MiB."""


def read_bytes(file: SourceFile) -> bytes:
    """Content of a file.

    Raises
    ------
    InputError
        If it cannot be opened.
    """
    try:
        return file.path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=file.name) from error


def read_text(file: SourceFile) -> str:
    """Content of a UTF-8 text file, without its byte order mark.

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is not text.
    """
    return _decode(read_bytes(file), file)


def _decode(content: bytes, file: SourceFile) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        kind = binary_kind(content)
        if kind is not None:
            raise FormatError(f"expected UTF-8 text, found {kind}", file=file.name) from error
        # the codec counts from behind the byte order mark
        before, wrong = error.object[: error.start], error.object[error.start]
        raise FormatError(
            f"expected UTF-8 text, found byte 0x{wrong:02x}; is it another kind of file?",
            file=file.name,
            line=before.count(b"\n") + 1,
        ) from error


@dataclass(frozen=True)
class NumberTable:
    """A table of numbers from a text file.

    Attributes
    ----------
    columns
        One float64 array of shape (n,) per column that is a number; empty fields and columns that
        a row lacks are NaN.
    line
        1-based line of each row, int64, shape (n,).
    label
        The column of text, object, shape (n,), where one was asked for.
    """

    columns: list[np.ndarray]
    line: np.ndarray
    label: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.line)


@dataclass(frozen=True)
class _Layout:
    """How the rows of a file look; see `read_numbers`."""

    n_columns: tuple[int, ...]
    delimiter: str
    what: str
    label_at: int | None
    comment: str

    @property
    def n_numbers(self) -> int:
        return max(self.n_columns) - (self.label_at is not None)


def read_numbers(
    file: SourceFile,
    *,
    n_columns: Sequence[int],
    delimiter: str = ",",
    what: str,
    label_at: int | None = None,
    comment: str = "",
) -> NumberTable:
    """Read a text file without header in which every field, but for one label, is a number.

    Parameters
    ----------
    file
        The file; empty lines are passed over, an empty file gives no rows.
    n_columns
        Allowed numbers of columns.
    delimiter
        ``","`` or ``" "`` (any white space).
    what
        What the fields are, for the error: "frame,id,left,top,width,height,...".
    label_at
        Position (0-based) of the one column that is text.
    comment
        Lines that begin with this are passed over; empty: there are no comments.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        With the first line that has another number of columns or a field that is no number.
    """
    layout = _Layout(tuple(n_columns), delimiter, what, label_at, comment)
    content = read_bytes(file).removeprefix(b"\xef\xbb\xbf")
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if len(content) >= _SMALL and not comment:
        table = _fast(content, layout)
        if table is not None:
            return table
    return _careful(_decode(content, file), file, layout)


def stacked(tables: Sequence[NumberTable]) -> tuple[NumberTable, np.ndarray]:
    """Rows of several files in one table, and the index of the file that each row is from.

    Raises
    ------
    AssertionError
        If there is no table; all must be of one layout.
    """
    assert tables
    file = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
    if len(tables) == 1:
        return tables[0], file
    columns = [np.concatenate(parts) for parts in zip(*(t.columns for t in tables), strict=True)]
    labels = [table.label for table in tables if table.label is not None]
    label = np.concatenate(labels) if labels else None
    return NumberTable(columns, np.concatenate([table.line for table in tables]), label), file


def _fast(content: bytes, layout: _Layout) -> NumberTable | None:
    """The table by pyarrow, or None where the careful parser must look."""
    begin = len(content) - len(content.lstrip())
    end = content.find(b"\n", begin)
    first = content[begin:end] if end >= 0 else content[begin:]
    n_first = len(first.split(layout.delimiter.encode()))
    if n_first not in layout.n_columns:
        return None
    types = {str(i): pa.float64() for i in range(n_first)}
    if layout.label_at is not None:
        types[str(layout.label_at)] = pa.string()
    try:
        table = pyarrow.csv.read_csv(
            pa.BufferReader(content),
            read_options=pyarrow.csv.ReadOptions(column_names=list(types), block_size=_BLOCK),
            parse_options=pyarrow.csv.ParseOptions(delimiter=layout.delimiter, quote_char=False),
            convert_options=pyarrow.csv.ConvertOptions(column_types=types, null_values=[""]),
        )
    except pa.ArrowInvalid:
        return None
    # between blanks, an empty field is only a second blank
    if layout.delimiter == " " and any(column.null_count for column in table.columns):
        return None
    columns = [column.to_numpy() for column in table.columns]
    label = None if layout.label_at is None else columns.pop(layout.label_at)
    missing = layout.n_numbers - len(columns)
    columns += [np.full(table.num_rows, np.nan) for _ in range(missing)]
    return NumberTable(columns, _lines(content, table.num_rows), label)


def _lines(content: bytes, n_rows: int) -> np.ndarray:
    """1-based line of each row: pyarrow passes over empty lines and does not count them."""
    if n_rows == content.count(b"\n") + (not content.endswith(b"\n")):
        return np.arange(1, n_rows + 1)
    ends = np.flatnonzero(np.frombuffer(content + b"\n", dtype=np.uint8) == ord("\n"))
    return np.flatnonzero(np.diff(ends, prepend=-1) > 1) + 1


def _careful(text: str, file: SourceFile, layout: _Layout) -> NumberTable:
    """Row by row, for files with ragged rows, odd spacing or a fault to be named."""
    rows: list[list[float]] = []
    lines: list[int] = []
    labels: list[str] = []
    # a loop over lines: only for small files and those that the fast parser refused
    for number, raw in enumerate(text.split("\n"), 1):
        stripped = raw.strip()
        if not stripped or (layout.comment and stripped.startswith(layout.comment)):
            continue
        fields = stripped.split() if layout.delimiter == " " else raw.split(layout.delimiter)
        if len(fields) not in layout.n_columns:
            expected = " or ".join(str(n) for n in layout.n_columns)
            raise FormatError(
                f"expected {expected} fields ({layout.what}), found {len(fields)}: "
                f"{shortened(stripped, 60)!r}",
                file=file.name,
                line=number,
            )
        if layout.label_at is not None:
            labels.append(fields.pop(layout.label_at).strip())
        row = [number_of(field) for field in fields]
        if None in row:
            wrong = fields[row.index(None)].strip()
            raise FormatError(
                f"expected numbers ({layout.what}), found {shortened(wrong, 60)!r}",
                file=file.name,
                line=number,
            )
        rows.append([*row, *[np.nan] * (layout.n_numbers - len(row))])  # type: ignore[list-item]
        lines.append(number)
    values = np.array(rows, dtype=float).reshape(len(rows), layout.n_numbers)
    return NumberTable(
        [values[:, i].copy() for i in range(layout.n_numbers)],
        np.array(lines, np.int64),
        None if layout.label_at is None else np.array(labels, dtype=object),
    )


def number_of(field: str) -> float | None:
    """The field as a number, NaN where it is empty, None where it is anything else."""
    field = field.strip()
    if len(field) > 1 and field[0] == field[-1] == '"':
        field = field[1:-1].strip()
    if not field:
        return float("nan")
    if "_" in field:  # Python's own notation, 1_000
        return None
    try:
        return float(field)
    except ValueError:
        return None


def whole_numbers(values: np.ndarray, file: SourceFile, line: np.ndarray, what: str) -> np.ndarray:
    """The values as int64.

    Raises
    ------
    FormatError
        With the line of the first value that is not a whole number (``1.0`` is one).
    """
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(values) < MAX_INTEGER) | (values != np.floor(values))
    if bad.any():
        first = int(np.argmax(bad))
        raise FormatError(
            f"expected a whole number as {what}, found {values[first]:g}",
            file=file.name,
            line=int(line[first]),
        )
    return values.astype(np.int64)


def rows_of_text(head: str, *, delimiter: str = ",", comment: str = "") -> list[list[str]]:
    """Fields of the first lines of a file, for telling its format; a cut last line is left out.

    Parameters
    ----------
    head
        Beginning of the file as text.
    delimiter
        ``","`` or ``" "`` (any white space).
    comment
        Lines that begin with this are passed over.
    """
    lines = head.removeprefix("\ufeff").splitlines()
    if len(lines) > 1 and not head.endswith(("\n", "\r")):
        lines.pop()
    lines = [line for line in lines if line.strip()]
    if comment:
        lines = [line for line in lines if not line.startswith(comment)]
    return [line.split() if delimiter == " " else line.split(delimiter) for line in lines]


def are_numbers(fields: Sequence[str]) -> bool:
    """Whether every field is a number or empty."""
    return all(number_of(field) is not None for field in fields)


def is_whole(field: str) -> bool:
    """Whether the field is a whole number (``1.0`` is one)."""
    value = number_of(field)
    return value is not None and value.is_integer()
