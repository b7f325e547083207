"""Rating sessions in a database file: each rating is on disk before the next clip is shown."""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple

import pandas as pd

from nvcore.errors import InputError
from nvcore.people.form import check_answers, check_questions, form_of
from nvcore.people.participants import (
    KEPT_DAYS,
    PARTICIPANTS,
    check_terms,
    counterbalanced_order,
    delete_ended,
    join,
    known_name,
    record_of,
    remove,
)
from nvcore.people.store import AnswerFile, new_names
from nvcore.ratings.clips import clip_name
from nvcore.ratings.worth import ANSWERS, Alert
from nvcore.wording import listed

MOST_CLIPS: Final = 500
TABLES: Final = f"""
CREATE TABLE IF NOT EXISTS study (
    token TEXT PRIMARY KEY, conductor TEXT NOT NULL UNIQUE, fingerprint TEXT NOT NULL,
    clips TEXT NOT NULL, low INTEGER NOT NULL, high INTEGER NOT NULL,
    thresholds TEXT NOT NULL, consent TEXT NOT NULL DEFAULT '', ends_at TEXT,
    alerts TEXT NOT NULL DEFAULT '[]', form TEXT NOT NULL DEFAULT '{{}}');
{PARTICIPANTS}
CREATE TABLE IF NOT EXISTS consent (
    study TEXT NOT NULL, participant TEXT NOT NULL, consented_at TEXT NOT NULL,
    PRIMARY KEY (study, participant),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
CREATE TABLE IF NOT EXISTS rating (
    study TEXT NOT NULL, participant TEXT NOT NULL, clip INTEGER NOT NULL, rating INTEGER NOT NULL,
    rated_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP, n_plays INTEGER, first_rating INTEGER,
    PRIMARY KEY (study, participant, clip),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
CREATE TABLE IF NOT EXISTS worth (
    study TEXT NOT NULL, participant TEXT NOT NULL, alert INTEGER NOT NULL, answer TEXT NOT NULL,
    answered_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP,
    PRIMARY KEY (study, participant, alert),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
CREATE TABLE IF NOT EXISTS form (
    study TEXT NOT NULL, participant TEXT NOT NULL, field TEXT NOT NULL, answer TEXT NOT NULL,
    PRIMARY KEY (study, participant, field),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
"""

ADDED: Final = {
    "rating": {"n_plays": "INTEGER", "first_rating": "INTEGER"},
    "study": {
        "consent": "TEXT NOT NULL DEFAULT ''",
        "ends_at": "TEXT",
        "alerts": "TEXT NOT NULL DEFAULT '[]'",
        "form": "TEXT NOT NULL DEFAULT '{}'",
    },
}
"""Columns that files of earlier versions lack, by table."""
OF_PARTICIPANT: Final = ("consent", "rating", "worth", "form")
"""Tables with what a participant left."""
FORM: Final = ("age", "sex", "licence", "night_driving")
"""Fields of the form before a session's own questions."""
CONSENT: Final = """\
You watch short clips of drives at night, and say after each how annoying the mistakes of a driver \
assistance system are.

We keep your ratings and answers, when you gave them, how often you played each clip, what you \
say about yourself, and the name or code that you enter on this page; no one needs your real \
name. You may stop at any time, without a reason. Tell the person who conducts the session your \
name or code, and you get a copy of your ratings, or they are deleted.
"""
RATE: Final = """
INSERT INTO rating (study, participant, clip, rating, n_plays) VALUES (?, ?, ?, ?, ?)
ON CONFLICT (study, participant, clip) DO UPDATE SET
    first_rating = CASE WHEN rating.rating = excluded.rating THEN rating.first_rating
        ELSE COALESCE(rating.first_rating, rating.rating) END,
    n_plays = CASE WHEN excluded.n_plays IS NULL THEN rating.n_plays
        ELSE COALESCE(rating.n_plays, 0) + excluded.n_plays END,
    rating = excluded.rating, rated_at = CURRENT_TIMESTAMP
"""


class Clip(NamedTuple):
    """What is rated: a recording, or a stretch of it, with the boxes of one system.

    Attributes
    ----------
    start_s, end_s
        Seconds since the recording's first frame; None: all of it.
    reason
        What the stretch was cut around (`nvcore.ratings.clips.cut_clips`).
    """

    recording: str
    system: str
    start_s: float | None = None
    end_s: float | None = None
    reason: str = ""

    @property
    def stretch_s(self) -> tuple[float, float]:
        """Start and end; NaN: all of it."""
        none = self.start_s is None or self.end_s is None
        return (math.nan, math.nan) if none else (self.start_s, self.end_s)  # type: ignore[return-value]

    @property
    def name(self) -> str:
        """What it is called in tables of ratings."""
        return clip_name(self.recording, *self.stretch_s)


@dataclass(frozen=True)
class Study:
    """What participants rate.

    Attributes
    ----------
    token
        Name of the study for participants; cannot be guessed.
    conductor
        Its name for whoever conducts it and sees the ratings; cannot be derived from `token`.
    fingerprint
        Of the dataset that the clips are from.
    clips
        What is rated.
    low, high
        Ends of the scale: not annoying at all, very annoying.
    thresholds
        Score threshold of each system, None where every detection is shown: all participants see
        the same boxes.
    consent
        Text that participants agree to before they begin; empty: none is shown.
    ends_at
        When the study is deleted with all ratings, UTC; None: it is not, by itself.
    alerts
        Of each it is asked whether it was worth it, after the clips.
    form
        Labels of the fields that participants are asked to fill in, by field; empty: no form.
    """

    token: str
    conductor: str
    fingerprint: str
    clips: tuple[Clip, ...]
    low: int
    high: int
    thresholds: Mapping[str, float | None]
    consent: str = ""
    ends_at: datetime | None = None
    alerts: tuple[Alert, ...] = ()
    form: Mapping[str, str] = field(default_factory=dict)


OF_STUDY: Final = tuple(column.name for column in fields(Study))
"""Columns of a study; files of earlier versions have them in another order."""


class RatingStore(AnswerFile):
    """Studies, participants and their ratings in one SQLite file.

    Parameters
    ----------
    path
        The file; it and its folder are created if necessary.
    now
        The time, UTC; None: the clock's. Studies whose time is over are deleted.

    Notes
    -----
    A rating outlives a crash of program or machine (`nvcore.people.store`).

    Raises
    ------
    InputError
        Here and in every call: if the file cannot be used.
    """

    def __init__(self, path: Path, *, now: datetime | None = None):
        super().__init__(path, TABLES, what="ratings")
        with self.connect() as base:
            _add_columns(base)
            delete_ended(base, now or datetime.now(UTC), OF_PARTICIPANT)

    def begin(
        self,
        fingerprint: str,
        clips: Sequence[tuple[Any, ...]],
        *,
        low: int = 1,
        high: int = 7,
        thresholds: Mapping[str, float | None] | None = None,
        consent: str | None = None,
        keep_days: int = KEPT_DAYS,
        alerts: Sequence[Alert] = (),
        questions: Sequence[str] | None = None,
        now: datetime | None = None,
    ) -> Study:
        """A new study of these clips.

        Parameters
        ----------
        clips
            Fields of `Clip`: recording and system at least.
        consent
            Text that participants agree to; None: they are asked elsewhere.
        keep_days
            After so many days the study is deleted with all ratings.
        alerts
            Of `nvcore.ratings.worth.read_alerts`.
        questions
            Own questions of the form; None: participants fill in none.
        now
            When it begins, UTC; None: the clock's time.

        Raises
        ------
        InputError
            If there is no clip, one twice or too many, the scale has no two steps, or the terms
            cannot be.
        """
        shown = tuple(Clip(*clip) for clip in clips)
        if not 0 < len(shown) <= MOST_CLIPS or len(set(shown)) < len(shown):
            raise InputError(f"a rating session needs 1 to {MOST_CLIPS} clips, each once")
        if low >= high:
            raise InputError(f"the scale must rise; it goes from {low} to {high}")
        if len(alerts) > MOST_CLIPS:
            raise InputError(
                f"a rating session asks of {MOST_CLIPS} alerts at most; got {len(alerts):,}"
            )
        check_questions(questions or ())
        check_terms(CONSENT if consent is None else consent, keep_days)
        token, conductor = new_names()
        study = Study(
            *(token, conductor, fingerprint, shown, low, high, dict(thresholds or {})),
            consent=consent or "",
            ends_at=(now or datetime.now(UTC)) + timedelta(days=keep_days),
            alerts=tuple(alerts),
            form={} if questions is None else form_of(FORM, questions),
        )
        row = [getattr(study, column) for column in OF_STUDY]
        values = [of.isoformat() if isinstance(of, datetime) else of for of in row]
        with self.connect() as base:
            base.execute(
                f"INSERT INTO study ({', '.join(OF_STUDY)}) VALUES "  # noqa: S608  # our own names
                f"({', '.join('?' * len(OF_STUDY))})",
                [json.dumps(of) if isinstance(of, tuple | dict) else of for of in values],
            )
        return study

    def study(self, token: str) -> Study | None:
        """The study that participants know by that name, if there is one."""
        return self._study("token", token)

    def study_of_conductor(self, conductor: str) -> Study | None:
        """The study that its conductor knows by that name, if there is one."""
        return self._study("conductor", conductor)

    def _study(self, column: str, name: str) -> Study | None:
        query = f"SELECT {', '.join(OF_STUDY)} FROM study WHERE {column} = ?"  # noqa: S608  # our own names
        with self.connect() as base:
            values = base.execute(query, (name,)).fetchone()
        if values is None:
            return None
        row = dict(zip(OF_STUDY, values, strict=True))
        row |= {of: json.loads(row[of]) for of in ("clips", "thresholds", "alerts", "form")}
        row["clips"] = tuple(Clip(*clip) for clip in row["clips"])
        row["alerts"] = tuple(Alert(*alert) for alert in row["alerts"])
        row["ends_at"] = row["ends_at"] and datetime.fromisoformat(row["ends_at"])
        return Study(**row)

    def agree(self, study: Study, participant: str, *, now: datetime | None = None) -> None:
        """Keep that somebody agrees to the text of consent, and when; a new name joins.

        Raises
        ------
        InputError
            If the name is empty or too long.
        """
        when = (now or datetime.now(UTC)).isoformat()
        with self.connect() as base:
            join(base, study.token, participant)
            name = known_name(base, study.token, participant)
            base.execute(
                "INSERT INTO consent VALUES (?, ?, ?) ON CONFLICT DO NOTHING",
                (study.token, name, when),
            )

    def fill_in(self, study: Study, participant: str, answers: Mapping[str, str]) -> None:
        """Keep what a participant who has joined says in the form; what was said before stays.

        Raises
        ------
        InputError
            If the form has no such field, or an answer is too long.
        """
        check_answers(study.form, answers)
        with self.connect() as base:
            name = _joined(base, study, participant)
            base.executemany(
                "INSERT INTO form VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING",
                [(study.token, name, *answer) for answer in answers.items()],
            )

    def forms(self, study: Study) -> pd.DataFrame:
        """What everybody says in the form: ``participant`` and its fields; "" where left empty."""
        rows = self._rows(study, "form", "field, answer")
        people = self.participants(study)["participant"]
        said = {person: dict.fromkeys(study.form, "") for person in people}
        for person, field_name, answer in rows:
            said[person][field_name] = answer
        table = pd.DataFrame([*said.values()], columns=[*study.form])
        table.insert(0, "participant", [*said])
        return table

    def judge(self, study: Study, participant: str, alert: int, answer: str) -> None:
        """Keep whether an alert was worth it; another answer to the same replaces it.

        Raises
        ------
        InputError
            If there is no such alert, answer or participant.
        """
        if not 0 <= alert < len(study.alerts):
            raise InputError(f"there is no alert {alert + 1}")
        if answer not in ANSWERS:
            raise InputError(f"an answer is {listed([*ANSWERS])}; given {answer!r}")
        with self.connect() as base:
            name = _joined(base, study, participant)
            base.execute(
                "INSERT INTO worth (study, participant, alert, answer) VALUES (?, ?, ?, ?) "
                "ON CONFLICT DO UPDATE SET answer = excluded.answer",
                (study.token, name, alert, answer),
            )

    def worth(self, study: Study) -> pd.DataFrame:
        """All answers: ``participant``, ``alert`` (its number), ``answer``, fields of `Alert`."""
        rows = self._rows(study, "worth", "alert, answer")
        table = pd.DataFrame(rows, columns=["participant", "alert", "answer"])
        alerts = pd.DataFrame(study.alerts, columns=[*Alert._fields])
        return table.join(alerts, on="alert")

    def judged(self, study: Study, participant: str) -> set[int]:
        """Numbers of the alerts that this participant has answered."""
        return {alert for _, alert in self._rows(study, "worth", "alert", participant)}

    def may_rate(self, study: Study, participant: str) -> bool:
        """Whether nothing has to be agreed to first: there is no text, or it was agreed to."""
        return not study.consent or bool(self._rows(study, "consent", "consented_at", participant))

    def _rows(
        self, study: Study, table: str, columns: str, participant: str | None = None
    ) -> list[tuple[Any, ...]]:
        """Participant and these columns of what one, or all, left in a table, in this order."""
        with self.connect() as base:
            name = None if participant is None else known_name(base, study.token, participant)
            return base.execute(
                f"SELECT participant, {columns} FROM {table} JOIN participant ON "  # noqa: S608  # our own names
                f"participant.study = {table}.study AND participant.name = {table}.participant "
                f"WHERE {table}.study = ? AND (? OR name = ?) ORDER BY number, {columns}",
                (study.token, participant is None, name),
            ).fetchall()

    def record(self, study: Study, participant: str) -> dict[str, Any] | None:
        """All that the file holds of a participant, as values of JSON; None: there is none."""
        with self.connect() as base:
            name = known_name(base, study.token, participant)
            if name is None:
                return None
            tables = record_of(base, study.token, name, OF_PARTICIPANT)
        for row in tables["rating"]:
            clip = study.clips[row["clip"]]._asdict()
            row["clip"] = {name: value for name, value in clip.items() if value not in (None, "")}
        for row in tables["worth"]:
            row["alert"] = study.alerts[row["alert"]]._asdict()
        return {"participant": name, **tables}

    def delete(self, study: Study, participant: str) -> bool:
        """Delete a participant with all that the file holds of them; whether there was one."""
        with self.connect() as base:
            return remove(base, study.token, participant, OF_PARTICIPANT)

    def order(
        self, study: Study, participant: str, *, of: Literal["clips", "alerts"] = "clips"
    ) -> list[int]:
        """Clips (or alerts) in this participant's own order; who is new gets the next free one.

        Names that differ in capitals or spaces only are one participant, here and in every call.

        Raises
        ------
        InputError
            If the name is empty or too long.
        """
        with self.connect() as base:
            number = join(base, study.token, participant)
        return [int(place) for place in counterbalanced_order(len(getattr(study, of)), number)]

    def ratings_of(self, study: Study, participant: str) -> dict[int, int]:
        """Ratings that this participant has given, by clip."""
        rows = self._rows(study, "rating", "clip, rating", participant)
        return {clip: rating for _, clip, rating in rows}

    def rate(
        self, study: Study, participant: str, clip: int, rating: int, *, n_plays: int | None = None
    ) -> None:
        """Keep a rating; another one of the same clip replaces it; the first one is returned.

        Parameters
        ----------
        n_plays
            How often the clip was played to its end before this rating (again, for another one of
            the same clip); None: not known.

        Raises
        ------
        InputError
            If there is no such clip or participant, or the rating is not on the scale.
        """
        if not 0 <= clip < len(study.clips):
            raise InputError(f"there is no clip {clip + 1}")
        if not study.low <= rating <= study.high:
            raise InputError(f"a rating is {study.low} to {study.high}; given {rating}")
        with self.connect() as base:
            name = _joined(base, study, participant)
            base.execute(RATE, (study.token, name, clip, rating, n_plays))

    def participants(self, study: Study) -> pd.DataFrame:
        """How far everybody has come: ``participant`` and ``n_rated``, in the order of joining."""
        with self.connect() as base:
            rows = base.execute(
                "SELECT name, COUNT(clip) FROM participant LEFT JOIN rating ON rating.study = "
                "participant.study AND rating.participant = participant.name "
                "WHERE participant.study = ? GROUP BY number ORDER BY number",
                (study.token,),
            ).fetchall()
        return pd.DataFrame(rows, columns=["participant", "n_rated"])

    def ratings(self, study: Study) -> pd.DataFrame:
        """All ratings of a study, as `read_ratings` gives them, and more.

        Returns
        -------
        Also ``n_plays``, how often the clip was played to its end (missing: not recorded), and
        ``first_rating``, what `rating` was before it was changed (missing: it never was); both
        Int64. Where clips are stretches, ``recording``, ``start_s``, ``end_s`` and ``reason``.
        """
        rows = self._rows(study, "rating", "clip, rating, n_plays, first_rating")
        clips = [study.clips[row[1]] for row in rows]
        table = pd.DataFrame(
            {
                "participant": pd.Series([row[0] for row in rows], dtype=str),
                "clip": pd.Series([clip.name for clip in clips], dtype=str),
                "system": pd.Series([clip.system for clip in clips], dtype=str),
                "rating": pd.Series([row[2] for row in rows], dtype=float),
                "n_plays": pd.Series([row[3] for row in rows], dtype="Int64"),
                "first_rating": pd.Series([row[4] for row in rows], dtype="Int64"),
            }
        )
        if all(clip.start_s is None for clip in study.clips):
            return table
        own = pd.DataFrame(clips, columns=[*Clip._fields]).drop(columns="system")
        return table.join(own.astype({"start_s": float, "end_s": float}))


def _joined(base: sqlite3.Connection, study: Study, participant: str) -> str:
    """The name of somebody who takes part, as it was given first."""
    name = known_name(base, study.token, participant)
    if name is None:
        raise InputError(f"{participant} has not joined this rating session")
    return name


def _add_columns(base: sqlite3.Connection) -> None:
    """Add the columns that a file of an earlier version lacks."""
    for table, columns in ADDED.items():
        existing = {row[1] for row in base.execute(f"PRAGMA table_info({table})")}
        for column, kind in columns.items():
            if column not in existing:
                try:
                    base.execute(f"ALTER TABLE {table} ADD COLUMN {column} {kind}")
                except sqlite3.OperationalError as error:
                    if "duplicate column" not in str(error):  # somebody else has just done it
                        raise
