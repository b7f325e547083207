"""The engine of studies with people: studies, participants and answers in one SQLite file.

To add a task, derive a store from `StudyStore`, as `nvcore.subjects.ratings.clip_task` does:

1. Derive a frozen dataclass from `Study`: the task's settings, and ``plan(number)``, which returns
   a participant's trials.
2. A trial is a named tuple that has ``table`` and ``place``: where its answer is kept.
3. Declare the ``content`` of the file, the ``trial``, a `Table` for each kind of answer, and
   ``study_columns``: every field of the study but its two names (composite values become JSON),
   ``ends_at`` among them. By these the file is created, exported and emptied.
4. Give ``study_of`` (a row as a study, its JSON decoded), ``begin`` (check the settings, then
   ``_begin``), and a method for each kind of answer that checks it and calls ``keep``.
5. Return answers as DataFrames: their columns are those of the CSV files.
6. On the page, derive from `ui.subjects.people.studies.Studies`, and return it by `studies` of the
subject.

The smallest task is in ``tests/people/test_store.py``.
"""

from __future__ import annotations

import json
import re
import secrets
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Any, ClassVar, Final, Generic, NamedTuple, TypeVar

from nvcore.common.errors import InputError
from nvcore.common.output.sqlite_file import SqliteFile
from nvcore.common.wording import fold_name
from nvcore.subjects.people.form import check_answers
from nvcore.subjects.people.participants import MOST_NAME, draw_code, draw_pseudonym, hash_code

MOST_STUDIES: Final = 1000
MOST_PARTICIPANTS: Final = 2000
"""Maximum number of participants of a study, as anybody with its link can join."""
STUDY: Final = "token TEXT PRIMARY KEY, conductor TEXT NOT NULL UNIQUE"
PARTICIPANT: Final = """study TEXT NOT NULL REFERENCES study, name TEXT NOT NULL,
    number INTEGER NOT NULL, code TEXT, PRIMARY KEY (study, name), UNIQUE (study, number)"""
OF_PARTICIPANT: Final = """study TEXT NOT NULL, participant TEXT NOT NULL, {columns},
    PRIMARY KEY ({key}), FOREIGN KEY (study, participant) REFERENCES participant (study, name)"""


def _draw_secret() -> str:
    return secrets.token_urlsafe(16)


@dataclass(frozen=True, kw_only=True)
class Study:
    """Study of any task. Tasks derive their own.

    Attributes
    ----------
    token
        Name of the study in participants' links. It cannot be guessed.
    conductor
        Name of the study for its conductor. It cannot be derived from `token`.
    ends_at
        Time (UTC) at which the study is deleted with all answers; None: never.
    consent
        Text that participants agree to; empty: none is shown.
    form
        Labels of the fields that participants are asked to fill in.
    """

    token: str = field(default_factory=_draw_secret)
    conductor: str = field(default_factory=_draw_secret)
    ends_at: datetime | None = None
    consent: str = ""
    form: Mapping[str, str] = field(default_factory=dict)

    def plan(self, number: int, /) -> tuple[Any, ...]:
        """Return the trials of a participant, by their number, in their order."""
        raise NotImplementedError


S = TypeVar("S", bound=Study)


class Table(NamedTuple):
    """Kind of record that participants leave.

    Its `columns` are SQL; those that files of earlier versions lack need a default. The `key` is
    the column that tells the records of a participant apart, and has the `place` of a trial; empty:
    there is one record each, and no trial names this table.
    """

    columns: str
    key: str = ""


JSON: Final = ("answers", "plan")
FORM: Final = Table(
    """consented_at TEXT NOT NULL, answers TEXT NOT NULL, plan TEXT NOT NULL,
    has_practised INTEGER NOT NULL DEFAULT 0"""
)


@dataclass(frozen=True)
class Person:
    """Participant of a study.

    Attributes
    ----------
    number
        0-based row of the design.
    consented_at
        Time (UTC) at which they agreed; None: they didn't, or there is no text.
    has_practised
        True if there is no practice, or it was seen to its end.
    """

    name: str
    number: int
    consented_at: datetime | None
    form: Mapping[str, str]
    plan: tuple[Any, ...]
    has_practised: bool = True

    def filled(self, form: Iterable[str]) -> tuple[str, ...]:
        """Return what they entered in these fields, "" where left empty."""
        return tuple(self.form.get(of, "") for of in form)


class StudyStore(SqliteFile, Generic[S]):
    """Studies of one task in one SQLite file. Opening it deletes the studies whose time is over.

    Parameters
    ----------
    path
        See `SqliteFile`.
    now
        The time, UTC; None: the clock's.
    """

    study_columns: ClassVar[str]
    """SQL of the fields of a study, but for its two names."""
    tables: ClassVar[Mapping[str, Table]]
    """Answers that participants give."""
    trial: ClassVar[type[Any]]
    """Named tuple of a trial."""
    entry: ClassVar[Mapping[str, Table]] = {"form": FORM}
    """What participants leave when they join; another one needs its own `people` and `_entry`."""
    people: ClassVar[str] = (
        "SELECT name, number, consented_at, answers, plan, has_practised FROM participant "
        "JOIN form ON form.study = participant.study AND form.participant = name"
    )
    """SQL of all participants. ``answers`` and ``plan`` are JSON; NULL: the plan is not stored."""
    has_names: ClassVar[bool] = True
    """False: participants get pseudonyms, which are also the codes of those without a hash."""

    def __init_subclass__(cls) -> None:
        if "ends_at" not in cls.study_columns:
            raise TypeError(f"{cls.__name__}: study_columns need ends_at")

    def __init__(self, path: Path, *, now: datetime | None = None):
        super().__init__(path)
        with self.connect() as base:
            if self._missing(base):
                base.execute("BEGIN IMMEDIATE")  # nobody else extends the file in between
                for statement in self._missing(base):
                    base.execute(statement)
            time = (now or datetime.now(UTC)).isoformat()
            ended = base.execute("SELECT token FROM study WHERE ends_at <= ?", (time,)).fetchall()
            for (token,) in ended:
                self._delete(base, token, name=None)
                base.execute("DELETE FROM study WHERE token = ?", (token,))

    def _missing(self, base: sqlite3.Connection) -> list[str]:
        """Return SQL that adds the tables and columns that a new or earlier file lacks."""
        wanted = {"study": f"{STUDY}, {self.study_columns}", "participant": PARTICIPANT}
        for name, (columns, key) in {**self.entry, **self.tables}.items():
            keys = ", ".join(filter(None, ("study", "participant", key)))
            wanted[name] = OF_PARTICIPANT.format(columns=columns, key=keys)
        statements = []
        for name, columns in wanted.items():
            existing = {row[1] for row in base.execute(f"PRAGMA table_info({name})")}
            if existing:
                statements += [
                    f"ALTER TABLE {name} ADD COLUMN {column}"
                    for column in _columns(columns.partition("PRIMARY KEY (")[0])
                    if column.split()[0] not in existing
                ]
            else:
                statements.append(f"CREATE TABLE {name} ({columns})")
        return statements

    def study_of(self, row: dict[str, Any]) -> S:
        """Return the study of a row of the file, whose times are already parsed."""
        raise NotImplementedError

    def _begin(self, study: S) -> S:
        """Keep a new study."""
        columns = [of.split()[0] for of in _columns(f"{STUDY}, {self.study_columns}")]
        row = {column: _stored(getattr(study, column)) for column in columns}
        with self.connect() as base:
            (n,) = base.execute("SELECT COUNT(*) FROM study").fetchone()
            _check_room(n, MOST_STUDIES, "studies")
            _insert(base, "study", row)
        if self.study(study.token) != study:
            raise TypeError(f"study_columns or study_of of {type(self).__name__} lose a field")
        return study

    def study(self, token: str) -> S | None:
        """Return the study that participants know by that name, if there is one."""
        return self._study("token", token)

    def study_of_conductor(self, conductor: str) -> S | None:
        """Return the study that its conductor knows by that name, if there is one."""
        return self._study("conductor", conductor)

    def _study(self, column: str, name: str) -> S | None:
        rows = self.execute(f"SELECT * FROM study WHERE {column} = ?", name)  # noqa: S608  # our own names
        if not rows:
            return None
        row = dict(rows[0])
        times = {of: value for of, value in row.items() if of.endswith("_at") and value}
        return self.study_of(row | {of: datetime.fromisoformat(times[of]) for of in times})

    def join(
        self, study: S, answers: Mapping[str, str], *, name: str = "", now: datetime | None = None
    ) -> tuple[Person, str]:
        """Add a participant who agrees to the terms, and return them with their personal code.

        The participant gets the first free number: deleted participants make room, so that orders
        stay balanced. The file keeps only a hash of the code.

        Parameters
        ----------
        answers
            Answers in the form, by field.
        name
            Name that they typed, where the task has names.

        Raises
        ------
        InputError
            If somebody of that name takes part, the form has no such field, an answer or the name
            is too long, or the study is full.
        """
        check_answers(study.form, answers)
        name = name.strip() if self.has_names else draw_pseudonym()
        if not 0 < len(name) <= MOST_NAME:
            raise InputError(f"a name or pseudonym has 1 to {MOST_NAME} characters")
        code = draw_code()
        query = "SELECT name, number FROM participant WHERE study = ?"
        with self.connect() as base:
            base.execute("BEGIN IMMEDIATE")  # no one else joins in between
            taken = base.execute(query, (study.token,)).fetchall()
            _check_room(len(taken), MOST_PARTICIPANTS, "participants")
            if fold_name(name) in {fold_name(known) for known, _ in taken}:
                raise InputError(
                    f"somebody called {name} takes part already: choose another name, or go on "
                    "with the personal code of that participant"
                )
            numbers = {number for _, number in taken}
            number = next(number for number in count() if number not in numbers)
            consented_at = (now or datetime.now(UTC)) if study.consent else None
            person = Person(name, number, consented_at, dict(answers), study.plan(number))
            hashed = hash_code(study.token, code)
            values = {"study": study.token, "name": name, "number": number, "code": hashed}
            _insert(base, "participant", values)
            for table, row in self._entry(person):
                _insert(base, table, {"study": study.token, "participant": name, **row})
        return self.participants(study, name)[0], code

    def _entry(self, person: Person) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield the rows, with their tables, that a new participant leaves."""
        time = "" if person.consented_at is None else person.consented_at.isoformat()
        answers, plan = json.dumps(person.form), json.dumps(person.plan)
        yield "form", {"consented_at": time, "answers": answers, "plan": plan}

    def participants(self, study: S, name: str | None = None) -> list[Person]:
        """Return all participants by number, or only the one with exactly this name."""
        query = f"{self.people} WHERE participant.study = ?1 AND (?2 IS NULL OR name = ?2)"
        rows = self.execute(f"{query} ORDER BY number", study.token, name)
        return [
            Person(
                name,
                number,
                datetime.fromisoformat(consented_at) if consented_at else None,
                json.loads(answers),
                study.plan(number)
                if plan is None
                else tuple(self.trial(*trial) for trial in json.loads(plan)),
                bool(has_practised),
            )
            for name, number, consented_at, answers, plan, has_practised in rows
        ]

    def by_code(self, study: S, code: str) -> Person | None:
        """Return the participant with this personal code, however it is typed."""
        rows = self.execute(
            "SELECT name FROM participant WHERE study = ?1 AND "
            "(code = ?2 OR ?3 AND code IS NULL AND name = ?4)",
            *(study.token, hash_code(study.token, code), not self.has_names, code.strip().upper()),
        )
        people = self.participants(study, rows[0]["name"]) if rows else []
        return people[0] if people else None

    def find(self, study: S, text: str) -> Person | None:
        """Return the participant with this name or code, for the study's conductor."""
        people = self.participants(study)
        for person in sorted(people, key=lambda person: person.name != text.strip()):
            # files of earlier versions may have two spellings
            if fold_name(person.name) == fold_name(text):
                return person
        return self.by_code(study, text)

    def new_code(self, study: S, person: Person) -> str:
        """Issue a new personal code to a participant who has agreed. The old one becomes invalid.

        Raises
        ------
        InputError
            If they have not agreed to the terms, or were deleted.
        """
        if study.consent and person.consented_at is None:
            raise InputError(
                f"{person.name} has not agreed to the terms; delete them, and let them begin anew"
            )
        code = draw_code()
        changed = self.execute(
            "UPDATE participant SET code = ? WHERE study = ? AND name = ? RETURNING number",
            *(hash_code(study.token, code), study.token, person.name),
        )
        if not changed:
            raise InputError(f"{person.name} does not take part in this study any more")
        return code

    def keep(
        self,
        study: S,
        name: str,
        table: str,
        row: Mapping[str, Any],
        *,
        conflict: str = "DO NOTHING",
    ) -> None:
        """Keep an answer of a participant in a table.

        Parameters
        ----------
        conflict
            SQL of ``ON CONFLICT``, for a trial that has an answer already.

        Raises
        ------
        InputError
            If there is no such participant.
        """
        try:
            with self.connect() as base:
                values = {"study": study.token, "participant": name, **row}
                _insert(base, table, values, f"ON CONFLICT {conflict}")
        except sqlite3.IntegrityError as error:
            raise InputError(f"{name} does not take part in this study") from error

    def rows(
        self, study: S, table: str, columns: str, name: str | None = None
    ) -> list[tuple[Any, ...]]:
        """Return participant and these columns of all records in a table, or of one participant.

        Records are sorted by the participant's number, then by the columns.
        """
        found = self.execute(
            f"SELECT participant, {columns} FROM {table} JOIN participant ON "  # noqa: S608  # our own names
            f"participant.study = {table}.study AND participant.name = {table}.participant "
            f"WHERE {table}.study = ?1 AND (?2 IS NULL OR participant.name = ?2) "
            f"ORDER BY number, {columns}",
            *(study.token, name),
        )
        return [tuple(row) for row in found]

    def left(self, study: S, person: Person) -> list[Any]:
        """Return the participant's trials that have no answer, in their order."""
        done = {
            (table, place)
            for table in {trial.table for trial in person.plan}
            for _, place in self.rows(study, table, self.tables[table].key, person.name)
        }
        return [trial for trial in person.plan if (trial.table, trial.place) not in done]

    def record(self, study: S, person: Person) -> dict[str, Any]:
        """Return all data of a participant except the hash of the code, as values of JSON."""
        record: dict[str, Any] = {"participant": person.name, "number": person.number}
        for table in (*self.entry, *self.tables):
            query = f"SELECT * FROM {table} WHERE study = ? AND participant = ?"  # noqa: S608  # our own names
            record[table] = [
                {
                    column: json.loads(row[column]) if column in JSON else row[column]
                    for column in row.keys()[2:]  # but study and participant
                }
                for row in self.execute(query, study.token, person.name)
            ]
        return record

    def delete(self, study: S, person: Person) -> None:
        """Delete a participant with all that the file holds of them."""
        with self.connect() as base:
            self._delete(base, study.token, name=person.name)

    def _delete(self, base: sqlite3.Connection, token: str, *, name: str | None) -> None:
        """Delete the participant with this name, or all of a study if it is None."""
        columns = {
            **dict.fromkeys((*self.entry, *self.tables), "participant"),
            "participant": "name",
        }
        for table, column in columns.items():
            query = f"DELETE FROM {table} WHERE study = ?1 AND (?2 IS NULL OR {column} = ?2)"  # noqa: S608  # our own names
            base.execute(query, (token, name))


def _columns(sql: str) -> list[str]:
    """Return the columns of a declaration, whose brackets, as of a CHECK, may hold commas."""
    return [column for part in re.split(r",(?![^()]*\))", sql) if (column := part.strip())]


def _insert(
    base: sqlite3.Connection, table: str, row: Mapping[str, Any], conflict: str = ""
) -> None:
    places = ", ".join("?" * len(row))
    base.execute(
        f"INSERT INTO {table} ({', '.join(row)}) VALUES ({places}) {conflict}",  # noqa: S608  # our own names
        [*row.values()],
    )


def _stored(value: Any) -> Any:
    """Return a field of a study as a value of SQLite: times and composite values as text."""
    if isinstance(value, datetime):
        return value.isoformat()
    if value is None or isinstance(value, str | int):
        return value
    return json.dumps(value, default=asdict)


def _check_room(n: int, most: int, what: str) -> None:
    if n >= most:
        raise InputError(f"the limit of {most:,} {what} is reached")
