"""Detectability studies in a database file: each answer is on disk before the next picture."""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Final

from nvcore.driver.study.pictures import StudyPicture
from nvcore.driver.study.plan import Trial, plan_trials
from nvcore.driver.study.records import Answer, DetectabilityStudy, Participant
from nvcore.driver.study.settings import StudySettings
from nvcore.errors import InputError
from nvcore.people.form import check_answers
from nvcore.people.participants import (
    MOST_NAME,
    PARTICIPANTS,
    delete_ended,
    join,
    known_name,
    new_code,
    record_of,
    remove,
)
from nvcore.people.store import AnswerFile, new_names

MOST_DEVICE: Final = 200
MOST_STUDIES: Final = 1000
MOST_PARTICIPANTS: Final = 2000
"""Of a study; on a server that is open to all somebody may try how many there can be."""
TABLES: Final = f"""
CREATE TABLE IF NOT EXISTS study (
    token TEXT PRIMARY KEY, conductor TEXT NOT NULL UNIQUE, settings TEXT NOT NULL,
    pictures TEXT NOT NULL, folder TEXT NOT NULL, begun_at TEXT NOT NULL, ends_at TEXT NOT NULL);
{PARTICIPANTS}
CREATE TABLE IF NOT EXISTS form (
    study TEXT NOT NULL, participant TEXT NOT NULL, consented_at TEXT NOT NULL,
    answers TEXT NOT NULL, plan TEXT NOT NULL, has_practised INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (study, participant),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
CREATE TABLE IF NOT EXISTS showing (
    study TEXT NOT NULL, participant TEXT NOT NULL, place INTEGER NOT NULL, n INTEGER NOT NULL,
    shown_at TEXT NOT NULL, PRIMARY KEY (study, participant, place),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
CREATE TABLE IF NOT EXISTS showing_report (
    study TEXT NOT NULL, participant TEXT NOT NULL, place INTEGER NOT NULL, name TEXT NOT NULL,
    PRIMARY KEY (study, participant, place),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
CREATE TABLE IF NOT EXISTS trial (
    study TEXT NOT NULL, participant TEXT NOT NULL, place INTEGER NOT NULL,
    measured_s REAL NOT NULL, shown_s REAL NOT NULL, touch_x REAL, touch_y REAL,
    response_s REAL, is_answered INTEGER NOT NULL, n_shown INTEGER NOT NULL,
    device TEXT NOT NULL, answered_at TEXT NOT NULL,
    PRIMARY KEY (study, participant, place),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
"""
OF_PARTICIPANT: Final = ("trial", "showing_report", "showing", "form")
"""Tables with what a participant left."""


class DetectabilityStore(AnswerFile):
    """Studies, participants and their trials in one SQLite file.

    Studies whose time is over are deleted, with all answers, whenever the file is opened.

    Parameters
    ----------
    path
        The file; it and its folder are created if necessary.
    now
        The time, UTC; None: the clock's.

    Raises
    ------
    StoreError
        Here and in every call: if the file cannot be used.
    """

    def __init__(self, path: Path, *, now: datetime | None = None):
        super().__init__(path, TABLES, what="study")
        with self.connect() as base:
            delete_ended(base, now or datetime.now(UTC), OF_PARTICIPANT)

    def begin(
        self,
        settings: StudySettings,
        pictures: Sequence[StudyPicture],
        *,
        folder: str,
        now: datetime | None = None,
    ) -> DetectabilityStudy:
        """A new study of these pictures.

        Raises
        ------
        InputError
            If there are too few pictures for the design, or too many studies.
        """
        plan_trials(len(pictures), 0, design=settings.design, timing=settings.timing)
        begun_at = now or datetime.now(UTC)
        ends_at = begun_at + timedelta(days=settings.keep_days)
        names = new_names()
        study = DetectabilityStudy(*names, settings, tuple(pictures), folder, begun_at, ends_at)
        row = (
            *names,
            json.dumps(settings.to_json()),
            json.dumps([asdict(picture) for picture in pictures]),
            *(folder, begun_at.isoformat(), ends_at.isoformat()),
        )
        with self.connect() as base:
            _check_room(base, "SELECT COUNT(*) FROM study", (), MOST_STUDIES, "studies")
            base.execute("INSERT INTO study VALUES (?, ?, ?, ?, ?, ?, ?)", row)
        return study

    def study(self, token: str) -> DetectabilityStudy | None:
        """The study that participants know by that name, if there is one."""
        return self._study("SELECT * FROM study WHERE token = ?", token)

    def study_of_conductor(self, conductor: str) -> DetectabilityStudy | None:
        """The study that its conductor knows by that name, if there is one."""
        return self._study("SELECT * FROM study WHERE conductor = ?", conductor)

    def _study(self, query: str, name: str) -> DetectabilityStudy | None:
        with self.connect() as base:
            row = base.execute(query, (name,)).fetchone()
        if row is None:
            return None
        token, conductor, settings, pictures, folder, begun_at, ends_at = row
        return DetectabilityStudy(
            token,
            conductor,
            StudySettings.from_json(json.loads(settings)),
            tuple(StudyPicture(**picture) for picture in json.loads(pictures)),
            folder,
            datetime.fromisoformat(begun_at),
            datetime.fromisoformat(ends_at),
        )

    def join(
        self, study: DetectabilityStudy, form: Mapping[str, str], *, now: datetime | None = None
    ) -> Participant:
        """A new participant, who agrees to the text of consent and has filled in the form.

        The pseudonym is drawn; the plan of the trials is kept.

        Raises
        ------
        InputError
            If the study's form has no such field, an answer is too long, or the study is full.
        """
        check_answers(study.settings.form, form)
        code, consented_at = new_code(), now or datetime.now(UTC)
        with self.connect() as base:
            number = join(base, study.token, code)
            query = "SELECT COUNT(*) - 1 FROM participant WHERE study = ?"
            _check_room(base, query, (study.token,), MOST_PARTICIPANTS, "participants")
            plan = plan_trials(
                len(study.pictures),
                number,
                design=study.settings.design,
                timing=study.settings.timing,
            )
            base.execute(
                "INSERT INTO form (study, participant, consented_at, answers, plan) "
                "VALUES (?, ?, ?, ?, ?)",
                (
                    *(study.token, code, consented_at.isoformat()),
                    *(json.dumps(dict(form)), json.dumps(plan)),
                ),
            )
        return Participant(code, number, consented_at, dict(form), plan, False)

    def participant(self, study: DetectabilityStudy, code: str) -> Participant | None:
        """The participant with this code, however it is typed; None: there is none."""
        with self.connect() as base:
            name = known_name(base, study.token, code)
        people = [] if name is None else self._people(study, name)
        return people[0] if people else None

    def participants(self, study: DetectabilityStudy) -> list[Participant]:
        """All who take part, by their number."""
        return self._people(study)

    def _people(self, study: DetectabilityStudy, name: str | None = None) -> list[Participant]:
        """All who take part, or the one of this name."""
        with self.connect() as base:
            rows = base.execute(
                "SELECT name, number, consented_at, answers, plan, has_practised "
                "FROM participant JOIN form ON form.study = participant.study "
                "AND form.participant = participant.name "
                "WHERE participant.study = ?1 AND (?2 IS NULL OR participant.name = ?2) "
                "ORDER BY number",
                (study.token, name),
            ).fetchall()
        return [
            Participant(
                *(code, number, datetime.fromisoformat(consented_at), json.loads(answers)),
                tuple(Trial(*trial) for trial in json.loads(plan)),
                bool(has_practised),
            )
            for code, number, consented_at, answers, plan, has_practised in rows
        ]

    def end_practice(self, study: DetectabilityStudy, code: str) -> None:
        """Remember that the participant has seen the practice to its end."""
        with self.connect() as base:
            base.execute(
                "UPDATE form SET has_practised = 1 WHERE study = ? AND participant = ?",
                (study.token, code),
            )

    def note_showing(
        self, study: DetectabilityStudy, code: str, place: int, name: str = ""
    ) -> None:
        """Remember that a picture appears: who reloads the page then has seen it.

        Parameters
        ----------
        place
            ``order`` of the trial, from 1.
        name
            Of this showing: the last report, sent again, is not counted again; empty: it is.

        Raises
        ------
        InputError
            If there is no such participant or trial.
        """
        with self.connect() as base:
            _trial_at(base, study, code, place)
            now = datetime.now(UTC).isoformat()
            report = base.execute(
                "INSERT INTO showing_report VALUES (?, ?, ?, ?) "
                "ON CONFLICT DO UPDATE SET name = excluded.name WHERE name <> excluded.name",
                (study.token, code, place, name[:MOST_NAME]),
            )
            if name and not report.rowcount:
                return
            base.execute(
                "INSERT INTO showing VALUES (?, ?, ?, 1, ?) ON CONFLICT DO UPDATE SET n = n + 1, "
                "shown_at = excluded.shown_at",
                (study.token, code, place, now),
            )

    def answer(self, study: DetectabilityStudy, code: str, place: int, answer: Answer) -> None:
        """Keep an answer; another one to the same picture changes nothing.

        Parameters
        ----------
        place
            ``order`` of the trial, from 1.

        Raises
        ------
        InputError
            If there is no such participant or trial, or the touch is outside the trial's picture.
        """
        with self.connect() as base:
            trial = _trial_at(base, study, code, place)
            _check_touch(study.pictures[trial.picture], answer)
            shown = base.execute(
                "SELECT n FROM showing WHERE study = ? AND participant = ? AND place = ?",
                (study.token, code, place),
            ).fetchone()
            touch = (_none_for_nan(answer.touch_x), _none_for_nan(answer.touch_y))
            n_shown = shown[0] if shown else 0
            row = (
                *(study.token, code, place, answer.measured_s, answer.shown_s, *touch),
                *(_none_for_nan(answer.response_s), answer.is_answered, n_shown),
                *(answer.device[:MOST_DEVICE], datetime.now(UTC).isoformat()),
            )
            base.execute(
                "INSERT INTO trial VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
                "ON CONFLICT DO NOTHING",
                row,
            )

    def answers(self, study: DetectabilityStudy) -> dict[str, dict[int, tuple[Answer, int]]]:
        """Answers by participant and ``order``, each with how often its picture was shown.

        0: the browser never reported that it was.
        """
        with self.connect() as base:
            rows = base.execute(
                "SELECT participant, place, measured_s, shown_s, touch_x, touch_y, response_s, "
                "is_answered, n_shown, device FROM trial WHERE study = ? ORDER BY place",
                (study.token,),
            ).fetchall()
        answers: dict[str, dict[int, tuple[Answer, int]]] = {}
        for (
            code,
            place,
            measured_s,
            shown_s,
            x,
            y,
            response_s,
            is_answered,
            n_shown,
            device,
        ) in rows:
            x, y, response_s = (
                math.nan if value is None else value for value in (x, y, response_s)
            )
            answer = Answer(
                measured_s=measured_s,
                shown_s=shown_s,
                touch_x=x,
                touch_y=y,
                response_s=response_s,
                is_answered=bool(is_answered),
                device=device,
            )
            answers.setdefault(code, {})[place] = answer, n_shown
        return answers

    def left(self, study: DetectabilityStudy, participant: Participant) -> list[Trial]:
        """Trials without an answer, in their order."""
        with self.connect() as base:
            rows = base.execute(
                "SELECT place FROM trial WHERE study = ? AND participant = ?",
                (study.token, participant.code),
            ).fetchall()
        answered = {place for (place,) in rows}
        return [trial for trial in participant.plan if trial.order not in answered]

    def record(self, study: DetectabilityStudy, code: str) -> dict[str, Any] | None:
        """All that the file holds of a participant, as values of JSON; None: there is none."""
        participant = self.participant(study, code)
        if participant is None:
            return None
        with self.connect() as base:
            tables = record_of(base, study.token, participant.code, OF_PARTICIPANT[::-1])
        for row in tables["form"]:
            row |= {name: json.loads(row[name]) for name in ("answers", "plan")}
        return {"code": participant.code, "number": participant.number, **tables}

    def delete(self, study: DetectabilityStudy, code: str) -> bool:
        """Delete a participant with all that the file holds of them; whether there was one."""
        with self.connect() as base:
            return remove(base, study.token, code, OF_PARTICIPANT)


def _check_room(
    base: sqlite3.Connection, query: str, values: tuple[str, ...], most: int, what: str
) -> None:
    if base.execute(query, values).fetchone()[0] >= most:
        raise InputError(f"there are {most:,} {what} already, which is all that there may be")


def _trial_at(base: sqlite3.Connection, study: DetectabilityStudy, code: str, place: int) -> Trial:
    row = base.execute(
        "SELECT plan FROM form WHERE study = ? AND participant = ?", (study.token, code)
    ).fetchone()
    if row is None:
        raise InputError("nobody takes part in this study with that code")
    plan = json.loads(row[0])
    if not 1 <= place <= len(plan):
        raise InputError(f"the participant has no trial {place}")
    return Trial(*plan[place - 1])


def _check_touch(picture: StudyPicture, answer: Answer) -> None:
    x, y = answer.touch_x, answer.touch_y
    if answer.is_seen and not (0 <= x < picture.width and 0 <= y < picture.height):
        raise InputError(
            f"the touch ({x:g}, {y:g}) is outside the picture "
            f"({picture.width} x {picture.height} px)"
        )


def _none_for_nan(value: float) -> float | None:
    return None if math.isnan(value) else value
