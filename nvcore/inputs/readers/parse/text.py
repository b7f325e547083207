"""Fast reading of delimited number tables, with errors that name the line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa
import pyarrow.csv

from nvcore.common.file_kinds import binary_kind
from nvcore.common.wording import shortened
from nvcore.inputs.readers.base import Lines, SourceFile

MAX_INTEGER = 2.0**53
"""Largest number that is exact as float64: frame numbers and track ids stay below it."""
_SMALL = 2048
"""Bytes below which the careful parser is as fast as starting pyarrow (one file per frame)."""
_ODD_BLOCK = 1 << 20
"""Bytes of a block of lines that is read line by line if one of them is odd."""
BLOCK = 1 << 24
"""Bytes that pyarrow reads at a time. Measured: twice as fast as its default of 1 MiB."""


def read_bytes(file: SourceFile) -> bytes:
    """Read the decompressed content of a file.

    Raises
    ------
    InputError
        If it cannot be opened.
    """
    with file.open() as stream:
        return stream.read()


def read_text(file: SourceFile) -> str:
    """Read a UTF-8 text file, without its byte order mark.

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is not text.
    """
    return _decode(read_bytes(file), file)


def read_text_bytes(file: SourceFile) -> bytes:
    """Read a UTF-8 text file as bytes, which is faster than `read_text`."""
    content = read_bytes(file)
    if not content.isascii():
        _decode(content, file)
    return content.removeprefix(b"\xef\xbb\xbf")


def _decode(content: bytes, file: SourceFile) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        kind = binary_kind(content)
        if kind is not None:
            raise file.fault(f"expected UTF-8 text, found {kind}") from error
        # the codec counts from the end of the byte order mark
        before, wrong = error.object[: error.start], error.object[error.start]
        raise file.fault(
            f"expected UTF-8 text, found byte 0x{wrong:02x}; is it another kind of file?",
            before.count(b"\n") + 1,
        ) from error


@dataclass(frozen=True)
class NumberTable:
    """Table of numbers from text files.

    Attributes
    ----------
    columns
        One float64 array of shape (n,) per column of numbers. Empty and missing fields are NaN.
    lines
        File and line of each row.
    label
        Column of text, object, shape (n,), if the layout has one.
    """

    columns: list[np.ndarray]
    lines: Lines
    label: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.lines)


@dataclass(frozen=True)
class TextLayout:
    """Layout of the rows of a text file without header.

    Attributes
    ----------
    n_columns
        Allowed numbers of columns.
    what
        Names of the fields, for errors: "frame,id,left,top,width,height,...".
    delimiter
        ``","`` or ``" "`` (any white space).
    label_at
        Position (0-based) of the one column that is text.
    whole
        Columns of whole numbers, which distinguish this format from others.
    comment
        Prefix of lines to skip. Empty: there are no comments.
    """

    n_columns: tuple[int, ...]
    what: str
    delimiter: str = ","
    label_at: int | None = None
    whole: tuple[int, ...] = ()
    comment: str = ""

    @property
    def n_numbers(self) -> int:
        """Number of columns with numbers in the longest rows."""
        return max(self.n_columns) - (self.label_at is not None)

    def fits(self, head: str, *, n_rows: int = 20) -> bool:
        """Whether a file has rows and the first ones have this layout."""
        rows = rows_of_text(head, delimiter=self.delimiter)[:n_rows]
        return bool(rows) and all(map(self._is_row, rows))

    def _is_row(self, fields: list[str]) -> bool:
        """Whether the number and kinds of a row's fields are right."""
        if len(fields) not in self.n_columns or not all(is_whole(fields[i]) for i in self.whole):
            return False
        if self.label_at is None:
            return are_numbers(fields)
        before, behind = fields[: self.label_at], fields[self.label_at + 1 :]
        return not are_numbers(fields[self.label_at : self.label_at + 1]) and are_numbers(
            before + behind
        )


def read_numbers(file: SourceFile, layout: TextLayout) -> NumberTable:
    """Read a text file without header in which every field except one label is a number.

    Empty lines are skipped. An empty file gives no rows.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If a line has another number of columns, or a field is not a number, with the first line.
    """
    content = read_bytes(file).removeprefix(b"\xef\xbb\xbf")
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if len(content) >= _SMALL and not layout.comment:
        table = _fast(content, file, layout)
        if table is not None:
            return table
        if len(content) > _ODD_BLOCK:
            return _by_blocks(content, file, layout)
    return _careful(_decode(content, file), file, layout)


def stacked(tables: Sequence[NumberTable]) -> NumberTable:
    """Concatenate the rows of several files.

    Parameters
    ----------
    tables
        Tables of one layout, each of a single file.

    Raises
    ------
    AssertionError
        If there is no table.
    """
    assert tables
    if len(tables) == 1:
        return tables[0]
    lines = Lines(
        [file for table in tables for file in table.lines.files],
        np.repeat(np.arange(len(tables)), [len(table) for table in tables]),
        np.concatenate([table.lines.line for table in tables]),
    )
    columns = [np.concatenate(parts) for parts in zip(*(t.columns for t in tables), strict=True)]
    labels = [table.label for table in tables if table.label is not None]
    return NumberTable(columns, lines, np.concatenate(labels) if labels else None)


def _fast(
    content: bytes, file: SourceFile, layout: TextLayout, first_line: int = 1
) -> NumberTable | None:
    """Parse the table by pyarrow, or return None to use `_careful`."""
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
            read_options=pyarrow.csv.ReadOptions(column_names=list(types), block_size=BLOCK),
            parse_options=pyarrow.csv.ParseOptions(delimiter=layout.delimiter, quote_char=False),
            convert_options=pyarrow.csv.ConvertOptions(column_types=types, null_values=[""]),
        )
    except pa.ArrowInvalid:
        return None
    # with blanks as delimiter, an empty field is only a second blank
    if layout.delimiter == " " and any(column.null_count for column in table.columns):
        return None
    columns = [column.to_numpy() for column in table.columns]
    label = None if layout.label_at is None else columns.pop(layout.label_at)
    columns += [np.full(table.num_rows, np.nan) for _ in range(layout.n_numbers - len(columns))]
    line = _lines(content, table.num_rows) + (first_line - 1)
    return NumberTable(columns, Lines.of(file, line), label)


def line_blocks(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the number of lines before each block, and blocks of about `_ODD_BLOCK` bytes."""
    start = n_before = 0
    while start < len(content):
        end = content.find(b"\n", start + _ODD_BLOCK) + 1 or len(content)
        block = content[start:end]
        yield n_before, block
        start, n_before = end, n_before + block.count(b"\n")


def _by_blocks(content: bytes, file: SourceFile, layout: TextLayout) -> NumberTable:
    """Parse the table by blocks of lines, row by row only in blocks with an odd line."""
    if not content.isascii():
        _decode(content, file)
    tables = []
    for n_before, block in line_blocks(content):
        table = _fast(block, file, layout, n_before + 1)
        if table is None:
            table = _careful(block.decode(), file, layout, n_before + 1)
        tables.append(table)
    joined = stacked(tables)
    return replace(joined, lines=Lines.of(file, joined.lines.line))


def _lines(content: bytes, n_rows: int) -> np.ndarray:
    """Return the 1-based line of each row, since pyarrow skips empty lines without counting."""
    if n_rows == content.count(b"\n") + (not content.endswith(b"\n")):
        return np.arange(1, n_rows + 1)
    ends = np.flatnonzero(np.frombuffer(content + b"\n", dtype=np.uint8) == ord("\n"))
    return np.flatnonzero(np.diff(ends, prepend=-1) > 1) + 1


def _careful(text: str, file: SourceFile, layout: TextLayout, first: int = 1) -> NumberTable:
    """Parse row by row, for files with ragged rows, odd spacing or an error to report."""
    rows: list[list[float]] = []
    lines: list[int] = []
    labels: list[str] = []
    # a loop over lines: only for small files and those that the fast parser refused
    for number, raw in enumerate(text.split("\n"), first):
        stripped = raw.strip()
        if not stripped or (layout.comment and stripped.startswith(layout.comment)):
            continue
        fields = stripped.split() if layout.delimiter == " " else raw.split(layout.delimiter)
        if len(fields) not in layout.n_columns:
            raise file.fault(
                f"expected {' or '.join(map(str, layout.n_columns))} fields ({layout.what}), "
                f"found {len(fields)}: {shortened(stripped, 60)!r}",
                number,
            )
        if layout.label_at is not None:
            labels.append(fields.pop(layout.label_at).strip())
        row = [number_of(field) for field in fields]
        if None in row:
            wrong = fields[row.index(None)].strip()
            raise file.fault(
                f"expected numbers ({layout.what}), found {shortened(wrong, 60)!r}", number
            )
        rows.append([*row, *[np.nan] * (layout.n_numbers - len(row))])  # type: ignore[list-item]
        lines.append(number)
    values = np.array(rows, dtype=float).reshape(len(rows), layout.n_numbers)
    return NumberTable(
        [values[:, i].copy() for i in range(layout.n_numbers)],
        Lines.of(file, np.array(lines, np.int64)),
        None if layout.label_at is None else np.array(labels, dtype=object),
    )


def number_of(field: str) -> float | None:
    """Parse a field as a number, NaN if it is empty, or return None."""
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


def whole_numbers(values: np.ndarray, lines: Lines, what: str) -> np.ndarray:
    """Convert whole numbers to int64.

    Raises
    ------
    FormatError
        If a value is not a whole number (``1.0`` is one), with the first line.
    """
    with np.errstate(invalid="ignore"):
        whole = values.astype(np.int64, copy=False)
        # not np.abs, which is negative for the lowest integer, the result of NaN and infinity
        is_good = (whole > -MAX_INTEGER) & (whole < MAX_INTEGER)
        if whole is not values:
            is_good &= whole == values
    lines.refuse(~is_good, lambda row: f"expected a whole number as {what}, found {values[row]:g}")
    return whole


def rows_of_text(head: str, *, delimiter: str = ",") -> list[list[str]]:
    """Split the first lines of a file into fields, without an incomplete last line.

    Parameters
    ----------
    head
        Beginning of the file as text.
    delimiter
        See `TextLayout`.
    """
    lines = head.removeprefix("\ufeff").splitlines()
    if len(lines) > 1 and not head.endswith(("\n", "\r")):
        lines.pop()
    return [
        line.split() if delimiter == " " else line.split(delimiter)
        for line in lines
        if line.strip()
    ]


def are_numbers(fields: Sequence[str]) -> bool:
    """Whether every field is a number or empty."""
    return all(number_of(field) is not None for field in fields)


def is_whole(field: str) -> bool:
    """Whether the field is a whole number (``1.0`` is one)."""
    value = number_of(field)
    return value is not None and value.is_integer()
