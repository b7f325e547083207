"""Read a table in memory with the columns of plain CSV, as if it were such a file."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import FormatError
from nvcore.common.findings import Finding
from nvcore.common.wording import shortened
from nvcore.dataset.schema import BOX_DTYPES, TABLE_ENDING, categories_of
from nvcore.inputs.readers.base import BOTH_ROLES, Format, Reading, ReadOptions, SourceFile
from nvcore.inputs.readers.csv import NamedColumns, missing_columns, read_named_columns
from nvcore.inputs.readers.csv.columns import FALSE, MISSING, NUMBERS, TRUE, Header, header_of
from nvcore.inputs.readers.meaning.names import LEAST_TIME
from nvcore.inputs.readers.parse.text import MAX_INTEGER

ONLY_RECORDING: Final = "recording"
"""Name of the recording of a truth table without recording names."""


def table_as_file(name: str) -> SourceFile:
    """Make a stand-in for the file of a table, for lists of files and errors."""
    return SourceFile(Path(), name + TABLE_ENDING)


def read_table(table: pd.DataFrame, file: SourceFile, options: ReadOptions) -> Reading:
    """Read a table whose columns are named as in plain CSV: frame, x, y, w, h, and more.

    Without a column for the recording, the table is a single recording, that of the truth.

    Parameters
    ----------
    file
        `table_as_file`.

    Raises
    ------
    FormatError
        If a cell is not a number, with the row from 0.
    """
    header = header_of([str(name).strip() for name in table.columns])
    if "recording" not in header.place and "frame" in header.place:
        if len(options.recordings) > 1:
            raise file.fault(
                "expected a column recording, as the ground truth has "
                f"{len(options.recordings)} recordings; found {', '.join(header.names)}"
            )
        table = table.assign(recording=[*options.recordings, ONLY_RECORDING][0])
        header = header_of([*header.names, "recording"])
    problem = missing_columns(header)
    if problem is not None:
        raise file.fault(f"expected {problem}")

    def column_of(name: str) -> pd.Series:
        return table.iloc[:, header.place[name]].reset_index(drop=True)

    columns = NamedColumns(
        file, header, partial(parse_columns, column_of, len(table), file, header)
    )
    try:
        reading = read_named_columns([columns], options)
    except FormatError as error:
        if error.line is None:
            raise
        where = f"{file.name}, row {error.line - 1}"
        raise FormatError(error.message, file=where, steps=error.steps) from error
    return replace(reading, findings=tuple(with_row(finding) for finding in reading.findings))


def with_row(finding: Finding) -> Finding:
    """Replace the line in a finding's example by the row, counted from 0."""
    return replace(
        finding,
        example=re.sub(r"^line (\d+)", lambda line: f"row {int(line[1]) - 1}", finding.example),
    )


def parse_columns(
    column_of: Callable[[str], pd.Series],
    n_rows: int,
    file: SourceFile,
    header: Header,
    names: Sequence[str],
) -> tuple[pd.DataFrame, np.ndarray, bool]:
    """Convert columns like `nvcore.inputs.readers.csv.columns.read_columns`.

    Raises
    ------
    FormatError
        If a cell is not a number, with the row from 1.
    """
    columns = {}
    for name in names:
        column = column_of(name)
        title = header.names[header.place[name]]
        if name == "frame" and column.dtype == np.int64 and column.max() < LEAST_TIME:
            columns[name] = column  # times are computed with as float64
        elif name in NUMBERS:
            columns[name] = _numbers(column, title, file)
        elif name == "ignore":
            columns[name] = _claims(column, title, file)
        elif name == "track" and (ids := _whole(column)) is not None:
            columns[name] = ids
        else:
            columns[name] = _texts(column)
    table = pd.DataFrame(columns, index=range(n_rows), copy=False)
    return table, np.arange(1, n_rows + 1, dtype=BOX_DTYPES["line"]), False


def _texts(column: pd.Series) -> pd.Series:
    """Convert a column to text, empty where missing."""
    if isinstance(column.dtype, pd.CategoricalDtype):  # each distinct text once
        codes = column.cat.codes.to_numpy()
        texts = [str(text).strip() for text in column.cat.categories]
        if codes.min(initial=0) < 0:
            texts.append("")
        places = {text: place for place, text in enumerate(dict.fromkeys(texts))}
        place_of = np.array([places[text] for text in texts], dtype=np.int32)
        return pd.Series(categories_of(place_of[codes], list(places)))
    return column.astype(object).where(column.notna(), "").map(str).str.strip().astype(object)


def _numbers(column: pd.Series, title: str, file: SourceFile) -> pd.Series:
    if column.dtype in (np.float64, np.int64):
        return column.astype("float64")
    if isinstance(column.dtype, pd.CategoricalDtype):  # each distinct text once
        distinct = pd.to_numeric(pd.Series(column.cat.categories, dtype=object), errors="coerce")
        numbers = pd.Series(np.append(distinct.to_numpy(np.float64), np.nan)[column.cat.codes])
    else:
        numbers = pd.to_numeric(column, errors="coerce").astype("float64")
    doubtful = (numbers.isna() & column.notna()).to_numpy(dtype=bool)
    if doubtful.any():
        doubtful = doubtful & ~_texts(column).isin(MISSING).to_numpy()
    _refuse(doubtful, f"a number as {title}", column, file)
    return numbers


def _claims(column: pd.Series, title: str, file: SourceFile) -> pd.Series:
    if column.dtype == np.bool_:
        return column
    texts = _texts(column)
    is_true = texts.isin(TRUE)
    is_odd = ~(is_true | texts.isin([*FALSE, *MISSING])).to_numpy()
    _refuse(is_odd, f"0, 1, true or false as {title}", column, file)
    return is_true


def _whole(column: pd.Series) -> pd.Series | None:
    """Convert track ids to int64 or float64, or return None unless all are exact integers."""
    if not pd.api.types.is_numeric_dtype(column):
        return None
    ids = column if column.dtype == np.int64 else column.astype("float64")
    is_exact = ids.between(-MAX_INTEGER, MAX_INTEGER, inclusive="neither")
    is_whole = ids.isna() | (is_exact & (ids == np.floor(ids)))
    return ids if is_whole.all() else None


def _refuse(is_odd: np.ndarray, expected: str, column: pd.Series, file: SourceFile) -> None:
    if is_odd.any():
        row = int(np.argmax(is_odd))
        value = repr(shortened(str(column.iloc[row]), 60))
        raise file.fault(f"expected {expected}, found {value}", row + 1)


def _no_files(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Raise AssertionError, in place of a reader of files."""
    raise AssertionError(f"a table is read by read_table: {files}, {options}")


FORMAT: Final = Format(
    "table",
    "table in memory",
    BOTH_ROLES,
    suffixes=(),
    recognise=lambda _name, _head, _role: False,
    read=_no_files,
)
"""Format that is not in the registry, since files cannot have it."""
