"""Files for the tests of readers, and the tables that come of them as lists."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
from places import DATA

from nvcore.common.findings import Finding
from nvcore.inputs.readers.base import Reading, SourceFile


def source(folder: Path, content: str | bytes, name: str) -> SourceFile:
    """A file of this content, named by its path below the folder."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return SourceFile(path, name)


def golden(folder: str, *names: str) -> list[SourceFile]:
    """Files of `tests/data/<folder>`, named by their paths below it."""
    return [SourceFile(DATA / folder / name, name) for name in names]


def rows(table: pd.DataFrame | None, columns: str) -> list[list[Any]]:
    """These columns, row by row; numbers to nine decimals, NaN is None."""
    assert table is not None
    values = table[columns.split()].round(9).astype(object)
    return values.where(values.notna(), None).to_numpy().tolist()


def only_finding(reading: Reading, code: str) -> Finding:
    """The only finding of all, which is of this code."""
    (finding,) = reading.findings
    assert finding.code == code
    return finding
