"""A table of the recordings as CSV: what the data do not say of each.

    recording,width,height,fps,context,speed_kmh,horizon,tags,pictures
    night_01,640,480,20,rural,80,236,night;rain,night_01.mp4

Columns may stand in any order; all but `recording` may be missing, and their cells empty. Tags are
separated by semicolons. Paths of pictures start from the folder of the file; first_picture is the
number of the frame that the first of them shows. A title is what the recording is called in place
of its name in the data, a unit what it is part of (a drive, a route, a car). Columns are separated
by commas, semicolons (with tags in quotes; a comma may then be the decimal sign) or tabs.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from io import StringIO
from pathlib import Path, PurePosixPath
from typing import Any, Final

from nvcore.errors import SessionError
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.text import read_text
from nvcore.inputs.session import RecordingEntry, RecordingsFile, Session
from nvcore.output.csv_text import without_safeguard
from nvcore.params.traffic import parse_context
from nvcore.wording import did_you_mean

NAME: Final = "recording"
MAX_BYTES: Final = 16 << 20
"""Tens of thousands of recordings."""
MOST_RECORDINGS: Final = 100_000


def _number(text: str) -> float:
    try:
        return float("" if "_" in text else text)  # Python's own 1_000 is no number in a table
    except ValueError as error:
        raise ValueError(f"expected a number, found {text!r}") from error


def _whole_number(text: str) -> int:
    number = _number(text)
    if not number.is_integer():
        raise ValueError(f"expected a whole number, found {text!r}")
    return int(number)


def _tags(text: str) -> tuple[str, ...]:
    return tuple(tag.strip() for tag in text.split(";") if tag.strip())


COLUMNS: Final[dict[str, Callable[[str], Any]]] = {
    NAME: str,
    "width": _number,
    "height": _number,
    "fps": _number,
    "context": parse_context,
    "speed_kmh": _number,
    "horizon": _number,
    "tags": _tags,
    "pictures": str,
    "first_picture": _whole_number,
    "title": str,
    "unit": str,
}
"""What the file may hold, and how a cell is read."""


def with_recordings_file(session: Session, *, goes_first: bool = False) -> Session:
    """The session with the table of recordings that it names read into its `recordings`.

    Parameters
    ----------
    goes_first
        Whether the table goes before what the session itself says of a recording.

    Raises
    ------
    InputError
        If the file cannot be used; with the line.
    """
    table = session.recordings_file
    if table is None or table.line_of is not None:
        return session
    rows = read_recordings_file(session.folder / table.path, table.path)
    entries = {entry.name: entry for entry in session.recordings}
    for name, (_, row) in rows.items():
        own = entries.get(name, RecordingEntry(name))
        entries[name] = _filled(row, own) if goes_first else _filled(own, row)
    line_of = {name: line for name, (line, _) in rows.items()}
    return replace(
        session,
        recordings=tuple(entries.values()),
        recordings_file=RecordingsFile(table.path, line_of),
    )


def _filled(entry: RecordingEntry, other: RecordingEntry) -> RecordingEntry:
    """The entry with what it does not say taken from the other."""
    missing = {
        spec.name: getattr(other, spec.name)
        for spec in fields(RecordingEntry)
        if getattr(entry, spec.name) in (None, ())
    }
    return replace(entry, **missing)


def read_recordings_file(path: Path, name: str) -> dict[str, tuple[int, RecordingEntry]]:
    """Line and content of each recording, by its name; paths of pictures as of `name`.

    Parameters
    ----------
    path
        The file.
    name
        What it is called in errors; paths of its pictures start from there.

    Raises
    ------
    InputError
        If it cannot be used; with the line.
    """
    file = SourceFile(path, name)
    rows = _rows(file)
    header_line, header = next(rows, (1, []))
    columns = _columns(file, header_line, header)
    entries: dict[str, tuple[int, RecordingEntry]] = {}
    for line, cells in rows:
        if len(cells) != len(columns):
            raise file.fault(
                f"expected {len(columns)} cells, as in the first line, found {len(cells)}", line
            )
        if len(entries) >= MOST_RECORDINGS:
            raise file.fault(f"expected {MOST_RECORDINGS:,} recordings at the most", line)
        entry = _entry(file, line, dict(zip(columns, cells, strict=True)))
        if entry.name in entries:
            raise file.fault(
                f"the recording {entry.name!r} stands in line {entries[entry.name][0]} already; "
                "leave one of the two",
                line,
            )
        entries[entry.name] = line, entry
    return entries


def _rows(file: SourceFile) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of each row that is not empty, white space around cells removed."""
    if file.is_larger_than(MAX_BYTES):
        raise file.fault(f"expected a table of recordings, found more than {MAX_BYTES >> 20} MiB")
    text = read_text(file)
    delimiter = max(",;\t", key=text.lstrip().split("\n", 1)[0].count)
    reader = csv.reader(StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        for cells in reader:
            row = [without_safeguard(cell.strip()) for cell in cells]
            if any(row):
                yield reader.line_num, [*map(_with_point, row)] if delimiter == ";" else row
    except csv.Error as error:
        raise file.fault(f"is no CSV: {error}", reader.line_num) from error


def _with_point(cell: str) -> str:
    """A number with a decimal comma as one with a point."""
    whole, comma, rest = cell.partition(",")
    is_number = comma and whole.isascii() and whole.isdigit() and rest.isascii() and rest.isdigit()
    return f"{whole}.{rest}" if is_number else cell


def _columns(file: SourceFile, line: int, header: list[str]) -> list[str]:
    columns = [cell.lower() for cell in header]
    expected = f"expected a first line such as {','.join(COLUMNS)}"
    if NAME not in columns:
        raise file.fault(f"{expected}; the column {NAME} is missing", line)
    for number, name in enumerate(columns):
        if name not in COLUMNS:
            hint = did_you_mean(name, COLUMNS, f"the columns are {', '.join(COLUMNS)}")
            raise file.fault(f"there is no column {name!r}; {hint}", line)
        if name in columns[:number]:
            raise file.fault(f"the column {name} stands there twice", line)
    return columns


def _entry(file: SourceFile, line: int, cells: dict[str, str]) -> RecordingEntry:
    values: dict[str, Any] = {}
    for column, text in cells.items():
        if not text:
            continue
        try:
            values[column] = COLUMNS[column](text)
        except ValueError as error:
            raise file.fault(f"{column}: {error}", line) from error
    name = values.pop(NAME, None)
    if name is None:
        raise file.fault("expected a name of the recording, found an empty cell", line)
    if "pictures" in values:
        values["pictures"] = (PurePosixPath(file.name).parent / values["pictures"]).as_posix()
    try:
        return RecordingEntry(name, **values)
    except SessionError as error:
        raise file.fault(error.message, line) from error
