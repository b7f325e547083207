"""Small CSV tables with a header, whose fields are read by the names of their columns."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from io import StringIO
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import FormatError, InputError
from nvcore.common.output.csv_text import without_safeguard
from nvcore.common.wording import listed, shortened
from nvcore.inputs.readers.parse.text import MAX_INTEGER, number_of

MOST_ROWS: Final = 1_000_000
MOST_COLUMNS: Final = 100
MOST_BYTES: Final = 1 << 28
SEPARATORS: Final = ",;\t"
LONGEST_S: Final = 1e8
"""Largest time of a recording in seconds."""
_FLAGS: Final = {"1": True, "true": True, "yes": True, "0": False, "false": False, "no": False}


@dataclass(frozen=True)
class TextTable:
    """Table of text whose columns are validated when they are read.

    Attributes
    ----------
    name
        Name of the file, for errors.
    fields
        Stripped text of each column, object, shape (n,), by the column's name in lower case.
    lines
        1-based line of each row, int64, shape (n,).
    has_decimal_comma
        Whether numbers may have a decimal comma, since fields are separated by semicolons.
    """

    name: str
    fields: dict[str, NDArray[np.object_]]
    lines: NDArray[np.int64]
    has_decimal_comma: bool

    def __len__(self) -> int:
        return len(self.lines)

    def __contains__(self, column: str) -> bool:
        return column in self.fields

    def fault(self, row: int, message: str) -> FormatError:
        """Return an error that names the line of a row, for the caller to raise."""
        return FormatError(message, file=self.name, line=int(self.lines[row]))

    def refuse(self, is_wrong: NDArray[np.bool_], message: Callable[[int], str]) -> None:
        """Raise FormatError with `message` for the first wrong row, if there is one."""
        if is_wrong.any():
            row = int(np.argmax(is_wrong))
            raise self.fault(row, message(row))

    def texts(self, column: str, *, may_be_empty: bool = False) -> NDArray[np.object_]:
        """Return the column as text, without the apostrophe that escapes formulas in spreadsheets.

        Raises
        ------
        FormatError
            If a field is empty, with the first such line.
        """
        texts = self.fields[column]
        if not may_be_empty:
            self.refuse(texts == "", lambda _row: f"{column} is empty")
        return texts

    def numbers(
        self, column: str, *, low: float = -np.inf, high: float = np.inf, may_be_empty: bool = False
    ) -> NDArray[np.float64]:
        """Return the column as float64, shape (n,), with empty fields as NaN if `may_be_empty`.

        Raises
        ------
        FormatError
            If a field is not a finite number in the range, with the first such line.
        """
        texts = self.fields[column]
        values = np.full(len(texts), np.nan)
        for row, text in enumerate(texts):  # small tables: every field may be wrong by itself
            if text == "" and may_be_empty:
                continue
            number = number_of(text.replace(",", ".") if self.has_decimal_comma else text)
            if number is None or not np.isfinite(number):
                raise self.fault(row, f"{column}: expected a number, found {shortened(text, 40)!r}")
            if not low <= number <= high:
                limits = f"{low:g} or more" if high == np.inf else f"{low:g} to {high:g}"
                raise self.fault(row, f"{column}: expected {limits}, found {text}")
            values[row] = number
        return values

    def whole_numbers(
        self, column: str, *, low: int = 0, if_empty: int | None = None
    ) -> NDArray[np.int64]:
        """Return the column as whole numbers of at least `low`, int64, shape (n,).

        Parameters
        ----------
        if_empty
            Value of an empty field. None: it is refused.

        Raises
        ------
        FormatError
            If there is another field, with the first such line.
        """
        may_be_empty = if_empty is not None
        numbers = self.numbers(column, low=low, high=MAX_INTEGER, may_be_empty=may_be_empty)
        if may_be_empty:
            numbers[np.isnan(numbers)] = if_empty
        self.refuse(
            numbers != np.floor(numbers),
            lambda row: f"{column}: expected a whole number, found {self.fields[column][row]}",
        )
        return numbers.astype(np.int64)

    def flags(self, column: str) -> NDArray[np.bool_]:
        """Return the column of 1 and 0 (or true and false, yes and no) as bool, shape (n,).

        Raises
        ------
        FormatError
            If there is another field, with the first such line.
        """
        texts = [text.lower() for text in self.fields[column]]
        self.refuse(
            np.array([text not in _FLAGS for text in texts], dtype=np.bool_),
            lambda row: f"{column}: expected 1 or 0, found {shortened(texts[row], 40)!r}",
        )
        return np.array([_FLAGS[text] for text in texts], dtype=np.bool_)

    def unique(self, columns: Sequence[str], message: str) -> None:
        """Refuse a row that repeats an earlier one in these columns.

        Raises
        ------
        FormatError
            With `message` and the lines of both. It may refer to columns, as in ``{subject}``.
        """
        seen: dict[tuple[str, ...], int] = {}
        for row, key in enumerate(zip(*(self.fields[column] for column in columns), strict=True)):
            first = seen.setdefault(key, row)
            if first != row:
                text = message.format(**dict(zip(columns, key, strict=True)))
                raise self.repeated(row, first, text)

    def repeated(self, row: int, first: int, message: str) -> FormatError:
        """Return an error that names the lines of both rows, for the caller to raise."""
        return self.fault(row, f"{message} (first in line {self.lines[first]})")


def parse_table(content: bytes, *, name: str, what: str, required: Sequence[str]) -> TextTable:
    """Parse CSV text with a header, whose columns may be in any order.

    Fields are separated by comma, semicolon or tab, whichever is commonest in the first line. Blank
    lines are skipped.

    Parameters
    ----------
    name
        Name of the file, for errors.
    what
        Kind of the rows, as in "this is no CSV table of boxes".
    required
        Required columns.

    Raises
    ------
    FormatError
        If the content is not such text, is empty or too large, a line has more or fewer fields
        than the first, or a column is missing or repeated.
    """
    no_table = f"this is no CSV table of {what}"
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(f"{no_table} ({error})", file=name) from error
    separator = max(SEPARATORS, key=text.partition("\n")[0].count)
    reader = csv.reader(
        StringIO(text, newline=""), delimiter=separator, skipinitialspace=True, strict=True
    )
    rows: list[list[str]] = []
    lines: list[int] = []
    try:
        for row in reader:
            if not any(field.strip() for field in row):
                continue
            if len(row) > MOST_COLUMNS:
                text = f"expected {MOST_COLUMNS} columns at the most, found {len(row):,}"
                raise FormatError(text, file=name, line=reader.line_num)
            if rows and len(row) != len(rows[0]):
                text = f"expected {len(rows[0])} fields, as in the first line; found {len(row)}"
                raise FormatError(text, file=name, line=reader.line_num)
            if len(rows) > MOST_ROWS:
                raise FormatError(f"more than {MOST_ROWS:,} {what}", file=name)
            rows.append(row)
            lines.append(reader.line_num)
    except csv.Error as error:
        raise FormatError(f"{no_table} ({error})", file=name, line=reader.line_num) from error
    if not rows:
        raise FormatError(f"{no_table} (it is empty)", file=name)
    header = [field.strip().lower() for field in rows[0]]
    line = lines[0]
    absent = [column for column in required if column not in header]
    if absent:
        raise FormatError(
            f"a table of {what} has the columns {', '.join(required)}; {listed(absent)} "
            f"{'is' if len(absent) == 1 else 'are'} missing, found "
            f"{shortened(', '.join(header), 120)}{_meant(absent, header, required)}",
            file=name,
            line=line,
        )
    for column in header:
        if column and header.count(column) > 1:
            raise FormatError(f"there are several columns {column}", file=name, line=line)
    fields = {
        column: np.array([without_safeguard(row[i].strip()) for row in rows[1:]], dtype=object)
        for i, column in enumerate(header)
    }
    return TextTable(name, fields, np.array(lines[1:], dtype=np.int64), separator == ";")


def read_table(path: Path, *, what: str, required: Sequence[str]) -> TextTable:
    """Read a CSV file as `parse_table` does.

    Raises
    ------
    InputError
        If the file cannot be opened or is not such a table.
    """
    try:
        with path.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=path) from error
    if len(content) > MOST_BYTES:
        raise FormatError(f"a table of {what} has {MOST_BYTES >> 20} MiB at most", file=path)
    return parse_table(content, name=str(path), what=what, required=required)


def read_series(
    path: Path, column: str, *, what: str, high: float = np.inf, zero: str = "frame 0"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Read a CSV file of readings over the time of a recording.

    Parameters
    ----------
    column
        Column of the readings, next to time_s.
    what
        Kind of the readings, as in `parse_table`.
    high
        Largest possible reading.
    zero
        Frame of the recording that is at 0 s.

    Returns
    -------
    Seconds (ascending) and readings (0 to `high`), float64, shape (n,).

    Raises
    ------
    InputError
        If the file cannot be opened, a field is not a number, a reading is out of range, or a time
        is too large (`LONGEST_S`) or not after the one before, with the line.
    """
    table = read_table(path, what=what, required=("time_s", column))
    time_s = table.numbers("time_s")
    table.refuse(
        np.abs(time_s) > LONGEST_S,
        lambda row: (
            f"time_s: expected seconds from {zero} of the recording, {-LONGEST_S:g} to "
            f"{LONGEST_S:g}, found {time_s[row]:g}; subtract the time of {zero}"
        ),
    )
    readings = table.numbers(column, low=0, high=high)
    table.refuse(
        np.diff(time_s, prepend=-np.inf) <= 0,
        lambda row: (
            f"time_s: expected a time after {time_s[row - 1]:g} of the row before, "
            f"found {time_s[row]:g}"
        ),
    )
    return time_s, readings


def _meant(absent: Sequence[str], header: Sequence[str], required: Sequence[str]) -> str:
    """Suggest other columns that may be misspelt required ones, or return an empty text."""
    others = [column for column in header if column and column not in required]
    close = [(column, get_close_matches(column, absent, n=1)) for column in others]
    return "".join(f"; is {column} {names[0]}?" for column, names in close if names)
