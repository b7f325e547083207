"""Who takes part in a study: terms, names, numbers, orders, and leaving it without a trace.

Functions with a connection work within a transaction of the file that
`nvcore.people.store.AnswerFile` opens; its tables include `PARTICIPANTS`.
"""

from __future__ import annotations

import secrets
import sqlite3
from collections.abc import Sequence
from datetime import datetime
from itertools import count
from typing import Any, Final

import numpy as np

from nvcore.errors import InputError

MOST_TEXT: Final = 20_000
"""Characters of a text of consent."""
LONGEST_KEPT_DAYS: Final = 3650
KEPT_DAYS: Final = 365
"""Days that answers are kept, unless the conductor says otherwise."""
MOST_NAME: Final = 64
PARTICIPANTS: Final = """
CREATE TABLE IF NOT EXISTS participant (
    study TEXT NOT NULL REFERENCES study, name TEXT NOT NULL, number INTEGER NOT NULL,
    PRIMARY KEY (study, name), UNIQUE (study, number));
"""
CODE_LETTERS: Final = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
"""Letters and figures that are not mistaken for each other."""
CODE_LENGTH: Final = 8
"""Forty bits: nobody guesses another participant's code."""


def fold_name(participant: str) -> str:
    """A person's name in the form that is the same however it is typed.

    Examples
    --------
    >>> fold_name(" Anna  K") == fold_name("anna k")
    True
    """
    return " ".join(participant.split()).casefold()


def new_code() -> str:
    """A pseudonym for a participant: says nothing about the person, and cannot be guessed."""
    return "".join(secrets.choice(CODE_LETTERS) for _ in range(CODE_LENGTH))


def known_name(base: sqlite3.Connection, study: str, participant: str) -> str | None:
    """A participant's name as it was given first; None: no one of that name has joined."""
    names = [
        name
        for (name,) in base.execute(
            "SELECT name FROM participant WHERE study = ? ORDER BY number", (study,)
        )
    ]
    if participant.strip() in names:  # files of earlier versions may have two spellings
        return participant.strip()
    folded = fold_name(participant)
    return next((name for name in names if fold_name(name) == folded), None)


def join(base: sqlite3.Connection, study: str, participant: str) -> int:
    """0-based number of a participant; a new one gets the first that is free.

    Who has left makes room: then the balance of the orders is kept.

    Raises
    ------
    InputError
        If the name is empty or too long.
    """
    name = participant.strip()
    if not 0 < len(name) <= MOST_NAME:
        raise InputError(f"a participant's name or code has 1 to {MOST_NAME} characters")
    if not base.in_transaction:
        base.execute("BEGIN IMMEDIATE")  # no one else joins in between
    known = known_name(base, study, name)
    if known is not None:
        row = base.execute(
            "SELECT number FROM participant WHERE study = ? AND name = ?", (study, known)
        ).fetchone()
        return int(row[0])
    taken = {
        number
        for (number,) in base.execute("SELECT number FROM participant WHERE study = ?", (study,))
    }
    number = next(number for number in count() if number not in taken)
    base.execute("INSERT INTO participant VALUES (?, ?, ?)", (study, name, number))
    return number


def record_of(
    base: sqlite3.Connection, study: str, participant: str, tables: Sequence[str]
) -> dict[str, list[dict[str, Any]]]:
    """The rows that these tables hold of a participant, by table; `participant` as `known_name`.

    Parameters
    ----------
    tables
        As of `remove`.
    """
    record: dict[str, list[dict[str, Any]]] = {}
    for table in tables:
        rows = base.execute(
            f"SELECT * FROM {table} WHERE study = ? AND participant = ?",  # noqa: S608  # our own names
            (study, participant),
        )
        names = [column[0] for column in rows.description]
        record[table] = [
            {
                name: value
                for name, value in zip(names, row, strict=True)
                if name not in ("study", "participant")
            }
            for row in rows
        ]
    return record


def delete_ended(base: sqlite3.Connection, now: datetime, tables: Sequence[str]) -> None:
    """Delete the studies whose time is over, with their participants and these tables' rows.

    Parameters
    ----------
    now
        UTC. A study ends at its ``ends_at`` (ISO 8601, UTC); NULL: never.
    tables
        As of `remove`.
    """
    ended = base.execute("SELECT token FROM study WHERE ends_at <= ?", (now.isoformat(),))
    for (token,) in ended.fetchall():
        for table in (*tables, "participant"):
            base.execute(f"DELETE FROM {table} WHERE study = ?", (token,))  # noqa: S608  # our own names
        base.execute("DELETE FROM study WHERE token = ?", (token,))


def remove(base: sqlite3.Connection, study: str, participant: str, tables: Sequence[str]) -> bool:
    """Delete a participant, and what these tables hold of them; whether there was one.

    Parameters
    ----------
    tables
        Names of tables with the columns ``study`` and ``participant``.
    """
    name = known_name(base, study, participant)
    if name is None:
        return False
    for table in tables:
        base.execute(f"DELETE FROM {table} WHERE study = ? AND participant = ?", (study, name))  # noqa: S608  # our own names
    base.execute("DELETE FROM participant WHERE study = ? AND name = ?", (study, name))
    return True


def counterbalanced_order(n_clips: int, participant: int) -> np.ndarray:
    """Clips in the order for one participant: a row of Williams' balanced Latin square (1949).

    Over `n_clips` participants (twice as many where that is odd) every clip stands in every place
    equally often, and follows every other clip equally often.

    Parameters
    ----------
    participant
        0-based number of the participant; beyond the square it starts again.

    Examples
    --------
    >>> counterbalanced_order(4, 0).tolist(), counterbalanced_order(4, 1).tolist()
    ([0, 1, 3, 2], [1, 2, 0, 3])
    """
    steps = np.arange(n_clips)
    zigzag = np.where(steps % 2 == 1, (steps + 1) // 2, (n_clips - steps // 2) % max(n_clips, 1))
    order: np.ndarray = (zigzag + participant) % max(n_clips, 1)
    is_mirrored = n_clips % 2 == 1 and participant // max(n_clips, 1) % 2 == 1
    return order[::-1] if is_mirrored else order


def check_terms(consent: str, keep_days: int) -> None:
    """Refuse terms that cannot be.

    Raises
    ------
    InputError
        If there is no text or too long a one, or answers would be kept too briefly or too long.
    """
    if not 0 < len(consent.strip()) <= MOST_TEXT:
        raise InputError(f"the text of consent has 1 to {MOST_TEXT:,} characters")
    if not 1 <= keep_days <= LONGEST_KEPT_DAYS:
        raise InputError(f"answers are kept 1 to {LONGEST_KEPT_DAYS} days")
