"""Rating sessions in a database file: each rating is on the disk before the next clip is shown."""

from __future__ import annotations

import json
import secrets
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pandas as pd

from nvcore.errors import InputError
from nvcore.ratings.order import counterbalanced

MOST_NAME: Final = 64
MOST_CLIPS: Final = 500
WAIT_S: Final = 10.0
"""How long a write waits for another one."""
TABLES: Final = """
CREATE TABLE IF NOT EXISTS study (
    token TEXT PRIMARY KEY, conductor TEXT NOT NULL UNIQUE, fingerprint TEXT NOT NULL,
    clips TEXT NOT NULL, low INTEGER NOT NULL, high INTEGER NOT NULL,
    thresholds TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS participant (
    study TEXT NOT NULL REFERENCES study, name TEXT NOT NULL, number INTEGER NOT NULL,
    PRIMARY KEY (study, name), UNIQUE (study, number));
CREATE TABLE IF NOT EXISTS rating (
    study TEXT NOT NULL, participant TEXT NOT NULL, clip INTEGER NOT NULL, rating INTEGER NOT NULL,
    rated_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP,
    PRIMARY KEY (study, participant, clip),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
"""


@dataclass(frozen=True)
class Study:
    """What participants rate.

    Attributes
    ----------
    token
        Name of the study for participants, not to be guessed.
    conductor
        Its name for who conducts it and sees the ratings; does not follow from `token`.
    fingerprint
        Of the dataset that the clips are from.
    clips
        Recording and system (whose boxes are shown) of each clip.
    low, high
        Ends of the scale: not annoying at all, very annoying.
    thresholds
        Score threshold of each system, None where every detection is shown: all participants see
        the same boxes.
    """

    token: str
    conductor: str
    fingerprint: str
    clips: tuple[tuple[str, str], ...]
    low: int
    high: int
    thresholds: Mapping[str, float | None]


class RatingStore:
    """Studies, participants and their ratings in one SQLite file.

    Parameters
    ----------
    path
        The file; it and its folder are made if need be.

    Notes
    -----
    Every call has a connection of its own, so that any thread may call. A rating is committed
    with ``synchronous=FULL``: it outlives a crash of program or machine.

    Raises
    ------
    InputError
        Here and in every call: if the file cannot be used.
    """

    def __init__(self, path: Path):
        self._path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as error:
            raise InputError(
                f"the folder of the ratings cannot be made ({error.strerror})"
            ) from error
        with self._connect() as base:
            base.executescript(TABLES)

    @contextmanager
    def _connect(self) -> Iterator[sqlite3.Connection]:
        try:
            with closing(sqlite3.connect(self._path, timeout=WAIT_S)) as base:
                base.execute("PRAGMA foreign_keys = ON")
                base.execute("PRAGMA synchronous = FULL")
                with base:  # commits, or rolls back
                    yield base
        except sqlite3.IntegrityError:
            raise
        except sqlite3.DatabaseError as error:
            raise InputError(f"the file of the ratings cannot be used ({error})") from error

    def begin(
        self,
        fingerprint: str,
        clips: Sequence[tuple[str, str]],
        *,
        low: int = 1,
        high: int = 7,
        thresholds: Mapping[str, float | None] | None = None,
    ) -> Study:
        """A new study of these clips, each a recording and a system.

        Raises
        ------
        InputError
            If there is no clip, one twice or too many, or the scale has no two steps.
        """
        if not 0 < len(clips) <= MOST_CLIPS or len(set(clips)) < len(clips):
            raise InputError(f"a rating session needs 1 to {MOST_CLIPS} clips, each once")
        if low >= high:
            raise InputError(f"the scale must rise; it goes from {low} to {high}")
        shown = dict(thresholds or {})
        token, conductor = secrets.token_urlsafe(16), secrets.token_urlsafe(16)
        study = Study(token, conductor, fingerprint, tuple(clips), low, high, shown)
        with self._connect() as base:
            base.execute(
                "INSERT INTO study VALUES (?, ?, ?, ?, ?, ?, ?)",
                (
                    token,
                    conductor,
                    fingerprint,
                    json.dumps(study.clips),
                    low,
                    high,
                    json.dumps(shown),
                ),
            )
        return study

    def study(self, token: str) -> Study | None:
        """The study that participants know by that name, if there is one."""
        return self._study("SELECT * FROM study WHERE token = ?", token)

    def conducted(self, conductor: str) -> Study | None:
        """The study that its conductor knows by that name, if there is one."""
        return self._study("SELECT * FROM study WHERE conductor = ?", conductor)

    def _study(self, query: str, name: str) -> Study | None:
        with self._connect() as base:
            row = base.execute(query, (name,)).fetchone()
        if row is None:
            return None
        token, conductor, fingerprint, clips, low, high, thresholds = row
        pairs = tuple((recording, system) for recording, system in json.loads(clips))
        return Study(token, conductor, fingerprint, pairs, low, high, json.loads(thresholds))

    def order(self, study: Study, participant: str) -> list[int]:
        """Clips in this participant's own order; a new participant gets the next free one.

        Raises
        ------
        InputError
            If the name is empty or too long.
        """
        name = participant.strip()
        if not 0 < len(name) <= MOST_NAME:
            raise InputError(f"a participant's name or code has 1 to {MOST_NAME} characters")
        with self._connect() as base:
            base.execute(
                "INSERT OR IGNORE INTO participant SELECT ?, ?, COUNT(*) FROM participant "
                "WHERE study = ?",
                (study.token, name, study.token),
            )
            (number,) = base.execute(
                "SELECT number FROM participant WHERE study = ? AND name = ?", (study.token, name)
            ).fetchone()
        return [int(clip) for clip in counterbalanced(len(study.clips), number)]

    def rated(self, study: Study, participant: str) -> dict[int, int]:
        """Ratings that this participant has given, by clip."""
        with self._connect() as base:
            return dict(
                base.execute(
                    "SELECT clip, rating FROM rating WHERE study = ? AND participant = ?",
                    (study.token, participant.strip()),
                ).fetchall()
            )

    def rate(self, study: Study, participant: str, clip: int, rating: int) -> None:
        """Keep a rating; a second one of the same clip takes the place of the first.

        Raises
        ------
        InputError
            If there is no such clip or participant, or the rating is not on the scale.
        """
        if not 0 <= clip < len(study.clips):
            raise InputError(f"there is no clip {clip + 1}")
        if not study.low <= rating <= study.high:
            raise InputError(f"a rating is {study.low} to {study.high}; given {rating}")
        try:
            with self._connect() as base:
                base.execute(
                    "INSERT OR REPLACE INTO rating (study, participant, clip, rating) "
                    "VALUES (?, ?, ?, ?)",
                    (study.token, participant.strip(), clip, rating),
                )
        except sqlite3.IntegrityError as error:
            raise InputError(f"{participant} has not joined this rating session") from error

    def participants(self, study: Study) -> pd.DataFrame:
        """How far everybody has come: ``participant`` and ``n_rated``, in the order of joining."""
        with self._connect() as base:
            rows = base.execute(
                "SELECT name, COUNT(clip) FROM participant LEFT JOIN rating ON rating.study = "
                "participant.study AND rating.participant = participant.name "
                "WHERE participant.study = ? GROUP BY number ORDER BY number",
                (study.token,),
            ).fetchall()
        return pd.DataFrame(rows, columns=["participant", "n_rated"])

    def ratings(self, study: Study) -> pd.DataFrame:
        """All ratings of a study, as `nvcore.ratings.reading.read_ratings` gives them."""
        with self._connect() as base:
            rows = base.execute(
                "SELECT participant, clip, rating FROM rating JOIN participant ON "
                "participant.study = rating.study AND participant.name = rating.participant "
                "WHERE rating.study = ? ORDER BY number, clip",
                (study.token,),
            ).fetchall()
        clips = [study.clips[clip] for _, clip, _ in rows]
        return pd.DataFrame(
            {
                "participant": [name for name, _, _ in rows],
                "clip": [recording for recording, _ in clips],
                "system": [system for _, system in clips],
                "rating": [float(rating) for _, _, rating in rows],
            }
        )
