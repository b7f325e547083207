"""A file of answers: each is on disk before the next question is asked."""

from __future__ import annotations

import os
import secrets
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Final

from nvcore.errors import InputError, StoreError

WAIT_S: Final = 10.0
"""Timeout of a write that waits for another, seconds."""


class AnswerFile:
    """One SQLite file with the answers of people.

    Parameters
    ----------
    path
        The file; it and its folder are created if necessary, for this user alone. A file that is
        there keeps its permissions.
    tables
        SQL that creates what is not there yet.
    what
        What the answers are, as in "the file of the answers".

    Notes
    -----
    Every call has a connection of its own, so that any thread may call. What is written is
    committed with ``synchronous=FULL``: it outlives a crash of program or machine. What is deleted
    is overwritten.

    Raises
    ------
    StoreError
        Here and in every call: if the file cannot be used.
    """

    def __init__(self, path: Path, tables: str, *, what: str):
        self._path, self._what = path, what
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as error:
            raise InputError(
                f"the folder of the {what} cannot be made ({error.strerror})"
            ) from error
        try:
            _create(path)
        except OSError as error:
            raise InputError(f"the file of the {what} cannot be used ({error.strerror})") from error
        with self.connect() as base:
            base.executescript(tables)

    @contextmanager
    def connect(self) -> Iterator[sqlite3.Connection]:
        """A connection; what was written is committed at the end, or rolled back after an error."""
        try:
            with closing(sqlite3.connect(self._path, timeout=WAIT_S)) as base:
                base.execute("PRAGMA foreign_keys = ON")
                base.execute("PRAGMA synchronous = FULL")
                base.execute("PRAGMA secure_delete = ON")
                with base:  # commits, or rolls back
                    yield base
        except sqlite3.IntegrityError:
            raise
        except sqlite3.DatabaseError as error:
            raise StoreError(f"the file of the {self._what} cannot be used ({error})") from error


def _create(path: Path) -> None:
    """Create the file if it is not there, for this user alone; SQLite's journals take its mode."""
    if not path.exists():  # to close a file that is in use would drop SQLite's locks on it
        os.close(os.open(path, os.O_CREAT | os.O_WRONLY, 0o600))


def new_names() -> tuple[str, str]:
    """Names of a study for participants and for its conductor; neither can be guessed."""
    return secrets.token_urlsafe(16), secrets.token_urlsafe(16)
