"""Parquet: a table with the column names of plain CSV."""

from __future__ import annotations

import atexit
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from io import BufferedReader
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
import pandas as pd
import pyarrow as pa

from nvcore.common.errors import FormatError, InputError
from nvcore.common.wording import shortened
from nvcore.inputs.files.packed import MAX_RATIO, MAX_UNPACKED_BYTES, RATIO_FROM_BYTES
from nvcore.inputs.readers.base import BOTH_ROLES, Format, Reading, ReadOptions, Role, SourceFile
from nvcore.inputs.readers.csv import NamedColumns, missing_columns, read_named_columns
from nvcore.inputs.readers.csv.columns import Header, header_of
from nvcore.inputs.readers.parquet.decoder import is_text
from nvcore.inputs.readers.parse.text import read_bytes
from nvcore.inputs.readers.parse.unknown import foreign_format
from nvcore.inputs.readers.table import parse_columns, with_row

MAGIC: Final = "PAR1"
_PIPE_BYTES: Final = 1 << 20
MAX_TEXT_BYTES: Final = 1 << 14
"""Longest text in bytes, several times the longest path of operating systems."""


def recognise(_name: str, head: str, _role: Role) -> bool:
    """Whether the content begins like Parquet and is not text."""
    return head.startswith(MAGIC) and "\x00" in head


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read Parquet files like plain CSV (see `nvcore.inputs.readers.csv.read`).

    Numbers may be of any numeric type, or text. Text may be encoded as a dictionary. A null is an
    empty field.

    Raises
    ------
    FormatError
        If a field is not a number, with the row from 0. If the file is damaged, lacks a column,
        has one of another type, or would be too large in memory.
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
    header, columns = _decoder.read(file)
    series = {name: _series(columns[place]) for name, place in header.place.items()}
    n_rows = len(next(iter(columns.values())))
    parse = partial(parse_columns, series.__getitem__, n_rows, file, header)
    return NamedColumns(file, header, parse)


class _Decoder:
    """Separate process of `nvcore.inputs.readers.parquet.decoder`, which a file may crash.

    The first file starts it, as does the next one after a crash. It ends with this process.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._said: IO[bytes] | None = None

    def read(self, file: SourceFile) -> tuple[Header, dict[int, pa.ChunkedArray | np.ndarray]]:
        """Read the header of a file and its recognised columns, by index.

        Columns of numbers without missing values are arrays.

        Raises
        ------
        FormatError
            If the file is damaged, crashes the process, lacks a column or is too large.
        """
        limits = {
            "ratio": MAX_RATIO,
            "ratio_from": RATIO_FROM_BYTES,
            "unpacked": MAX_UNPACKED_BYTES,
            "text": MAX_TEXT_BYTES,
        }
        content = read_bytes(file)
        with self._lock:
            header = header_of([name.strip() for name in self._ask(file, content, None, None)])
            problem = missing_columns(header)
            if problem is not None:
                known = foreign_format(",".join(header.names))
                raise file.fault(f"it is {known}" if known else f"expected {problem}")
            return header, self._ask(file, None, sorted(header.place.values()), limits)

    def end(self) -> None:
        """Close the process's input and wait for it to end, if it is running."""
        if self._process is not None:
            self._process.communicate()
            self._process = None
        if self._said is not None:
            self._said.close()
            self._said = None

    def _ask(self, file: SourceFile, *request: Any) -> Any:
        process = self._started()
        assert process.stdin is not None
        assert isinstance(process.stdout, BufferedReader)
        try:
            pickle.dump(request, process.stdin, protocol=5)
            process.stdin.flush()
            state, value, types = pickle.load(process.stdout)  # noqa: S301  # from our own process
            for place, (kind, n_rows) in types.items():
                value[place] = column = np.empty(n_rows, kind)
                if process.stdout.readinto(column.view(np.uint8).data) < column.nbytes:
                    raise EOFError
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            raise self._fault_of_end(file) from error
        except BaseException:  # ^C: its answer would be mistaken for the next one
            process.kill()
            self.end()
            raise
        if state == "fine":
            return value
        reason = shortened(" ".join(value.split()), 120)
        raise file.fault(
            f"expected a whole Parquet table, found a fault: {reason}"
            if state == "fault"
            else value
        )

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            path = os.pathsep.join(filter(None, sys.path))
            self._said = tempfile.TemporaryFile()  # noqa: SIM115  # as long as the process
            try:
                self._process = subprocess.Popen(  # noqa: S603  # our own module
                    # -P: its folder has modules with names of the standard library
                    [sys.executable, "-P", str(Path(__file__).with_name("decoder.py"))],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    pipesize=_PIPE_BYTES,
                    stderr=self._said,
                    env={**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"},
                )
            except OSError as error:
                raise InputError(
                    f"Parquet is read in a process of its own, and none starts ({error.strerror})"
                ) from error
        return self._process

    def _fault_of_end(self, file: SourceFile) -> Exception:
        """Return an error that explains why the process ended while it read a file."""
        process, self._process = self._process, None
        assert process is not None
        assert self._said is not None
        process.communicate()
        self._said.seek(0)
        text = self._said.read().decode("utf-8", "replace")
        self._said.close()
        if process.returncode == -signal.SIGKILL or "bad_alloc" in text or "MemoryError" in text:
            return MemoryError("decoding Parquet")
        if process.returncode >= 0:
            return RuntimeError(f"the decoder of Parquet has ended: {text}")
        reason = shortened(" ".join(text.rpartition("what():")[2].split()), 120)
        return file.fault(
            "expected a whole Parquet table, found damage that ends the program that decodes it "
            f"({reason or signal.Signals(-process.returncode).name}); write the table anew"
        )


_decoder: Final = _Decoder()
atexit.register(_decoder.end)


def _series(column: pa.ChunkedArray | np.ndarray) -> pd.Series:
    """Convert a column to pandas: numbers, bool, or categories of text, with nulls missing."""
    if isinstance(column, np.ndarray):
        return pd.Series(column, copy=False)
    kind = column.type
    if pa.types.is_null(kind):
        return pd.Series(np.full(len(column), np.nan))
    if pa.types.is_boolean(kind):
        return pd.Series(column.fill_null(False).to_numpy())
    if pa.types.is_decimal(kind) or pa.types.is_float16(kind):
        column = column.cast(pa.float64())
    if pa.types.is_dictionary(kind) and not is_text(kind.value_type):
        return _series(column.cast(kind.value_type))
    if is_text(kind):
        column = column.dictionary_encode()
    series: pd.Series = column.to_pandas()
    return series


FORMAT: Final = Format("parquet", "Parquet", BOTH_ROLES, (".parquet", ".pq"), recognise, read)
