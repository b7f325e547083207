"""A private SQLite file that several threads and processes may use."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, ClassVar, Final

from nvcore.common.errors import InputError, StoreError

WAIT_S: Final = 10.0
"""Timeout of a write that waits for another one, s."""


class SqliteFile:
    """A SQLite file. Writes outlive a crash of the program or the machine.

    They are committed with ``synchronous=FULL`` before a call returns. Deleted values are
    overwritten.

    Parameters
    ----------
    path
        The file. It and its folder are created if necessary, for this user alone. An existing file
        keeps its permissions.

    Raises
    ------
    InputError
        If the folder or the file cannot be created.
    StoreError
        Here and in every call: if the file cannot be used.
    """

    content: ClassVar[str]
    """Noun for the file's content, as in "the file of the ratings"."""

    def __init__(self, path: Path):
        self._path = path
        fault = f"the folder of the {self.content} cannot be made"
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            fault = f"the file of the {self.content} cannot be used"
            if not path.exists():  # to close a file that is in use would drop SQLite's locks on it
                os.close(os.open(path, os.O_CREAT | os.O_WRONLY, 0o600))
        except OSError as error:
            raise InputError(f"{fault} ({error.strerror})") from error

    @contextmanager
    def connect(self) -> Iterator[sqlite3.Connection]:
        """Open the file. Writes are committed at the end, or rolled back after an error."""
        try:
            with closing(sqlite3.connect(self._path, timeout=WAIT_S)) as base:
                base.row_factory = sqlite3.Row
                base.execute("PRAGMA foreign_keys = ON")
                base.execute("PRAGMA synchronous = FULL")
                base.execute("PRAGMA secure_delete = ON")
                with base:  # commits, or rolls back
                    yield base
        except sqlite3.IntegrityError:
            raise
        except sqlite3.DatabaseError as error:
            raise StoreError(f"the file of the {self.content} cannot be used ({error})") from error

    def execute(self, statement: str, *values: Any) -> list[sqlite3.Row]:
        """Execute one statement of SQL in a transaction of its own, and return its rows."""
        with self.connect() as base:
            return base.execute(statement, values).fetchall()
