"""CSV table of the recordings, with facts that the data lack.

    recording,width,height,fps,context,speed_kmh,horizon,tags,pictures
    night_01,640,480,20,rural,80,236,night;rain,night_01.mp4

Columns may be in any order. All but `recording` may be missing or have empty cells. Tags are
separated by semicolons. Paths of pictures are relative to the folder of the file. first_picture is
the frame number of the first picture. A title replaces the recording's name in the data. A unit is
a drive, a route or a car that it belongs to. Columns are separated by commas, tabs or semicolons
(with tags in quotes, and optionally a decimal comma).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import fields, replace
from pathlib import Path, PurePosixPath
from typing import Any, Final

import numpy as np

from nvcore.common.errors import SessionError
from nvcore.common.wording import did_you_mean
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.table import TextTable, parse_table
from nvcore.inputs.readers.parse.text import read_text_bytes
from nvcore.inputs.session import RecordingEntry, RecordingsFile, Session
from nvcore.inputs.session.changes import override_recordings
from nvcore.settings.defaults import as_names
from nvcore.settings.objects import Objects
from nvcore.settings.params.traffic import parse_context

NAME: Final = "recording"
MAX_BYTES: Final = 16 << 20
"""Size of tens of thousands of recordings."""
NUMBERS: Final = ("width", "height", "fps", "speed_kmh", "horizon", "first_picture")
COLUMNS: Final = (NAME, *NUMBERS, "context", "tags", "pictures", "title", "unit")
"""Columns that the file may have."""


def with_recordings_file(session: Session, *, goes_first: bool = False) -> Session:
    """Read the table of recordings that the session names into its `recordings`.

    Parameters
    ----------
    goes_first
        Whether the table takes precedence over the session's own facts about a recording.

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


def with_facts(
    session: Session,
    *,
    recordings: str | Path | None = None,
    codes: str | Path | None = None,
    tags: str | Iterable[str] = (),
    only: str | Iterable[str] = (),
    objects: Objects | None = None,
    **facts: Any,
) -> Session:
    """Return the session with the facts of a call or a command. None or empty keeps its own.

    Paths of `recordings` and `codes` start from the current folder. `tags` and `only` choose the
    recordings to compare. Size, fps and frames are those of `override_recordings`.

    Raises
    ------
    InputError
        If the table of recordings cannot be used; with the line.
    """
    here = Path() if session.folder == Path.cwd() else Path.cwd()
    if recordings is not None:
        session = replace(session, recordings_file=RecordingsFile(str(here / recordings)))
    if codes is not None:
        session = replace(session, codes_file=str(here / codes), codes=())
    session = with_recordings_file(session, goes_first=recordings is not None)
    session = replace(
        session,
        only_tags=tuple(dict.fromkeys(as_names(tags))) or session.only_tags,
        only=tuple(dict.fromkeys(as_names(only))) or session.only,
        objects=objects or session.objects,
    )
    return override_recordings(session, **facts)


def _filled(entry: RecordingEntry, other: RecordingEntry) -> RecordingEntry:
    """Fill the missing fields of an entry from another one."""
    missing = {
        spec.name: getattr(other, spec.name)
        for spec in fields(RecordingEntry)
        if getattr(entry, spec.name) in (None, ())
    }
    return replace(entry, **missing)


def read_recordings_file(path: Path, name: str) -> dict[str, tuple[int, RecordingEntry]]:
    """Read the line and the entry of each recording, by its name.

    Parameters
    ----------
    path
        The file.
    name
        Name of the file in errors. Paths of pictures are relative to its folder.

    Raises
    ------
    InputError
        If the file cannot be used, with the line.
    """
    file = SourceFile(path, name)
    if file.is_larger_than(MAX_BYTES):
        raise file.fault(f"expected a table of recordings, found more than {MAX_BYTES >> 20} MiB")
    table = parse_table(read_text_bytes(file), name=name, what="recordings", required=(NAME,))
    for column in table.fields:
        if column not in COLUMNS:
            hint = did_you_mean(column, COLUMNS, f"the columns are {', '.join(COLUMNS)}")
            raise file.fault(f"there is no column {column!r}; {hint}", 1)
    names = table.texts(NAME)
    table.unique((NAME,), "the recording {recording!r} is there twice; leave one of the two")
    numbers = {of: table.numbers(of, may_be_empty=True) for of in NUMBERS if of in table}
    first = numbers.get("first_picture", np.empty(0))
    table.refuse(
        (first % 1) > 0, lambda row: f"first_picture: expected a whole number, found {first[row]:g}"
    )
    entries: dict[str, tuple[int, RecordingEntry]] = {}
    for row, recording in enumerate(names):
        known: dict[str, Any] = {of: float(values[row]) for of, values in numbers.items()}
        known = {of: value for of, value in known.items() if not math.isnan(value)}
        known |= {"first_picture": int(known["first_picture"])} if "first_picture" in known else {}
        try:
            entry = RecordingEntry(recording, **known, **_texts(table, row, PurePosixPath(name)))
        except SessionError as error:
            raise table.fault(row, error.message) from error
        entries[recording] = int(table.lines[row]), entry
    return entries


def _texts(table: TextTable, row: int, file: PurePosixPath) -> dict[str, Any]:
    """Parse the cells of a row that are not numbers, by column, without empty ones."""
    columns = [of for of in ("context", "tags", "pictures", "title", "unit") if of in table]
    values: dict[str, Any] = {of: text for of in columns if (text := table.fields[of][row])}
    if "tags" in values:
        parts = map(str.strip, values["tags"].split(";"))
        values["tags"] = tuple(filter(None, parts))
    if "pictures" in values:
        values["pictures"] = (file.parent / values["pictures"]).as_posix()
    if "context" in values:
        text = values["context"]
        try:
            values["context"] = parse_context(
                text.replace(",", ".") if table.has_decimal_comma else text
            )
        except ValueError as error:
            raise table.fault(row, f"context: {error}") from error
    return values
