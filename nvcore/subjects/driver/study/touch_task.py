"""Detectability studies: participants touch the place where they saw the pedestrian."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime, timedelta
from typing import Any, ClassVar, Final

import pandas as pd

from nvcore.common.errors import InputError
from nvcore.subjects.driver.inputs.study_tables import (
    BOX,
    LONGEST_S,
    NO_ANSWER,
    PEDESTRIAN,
    TRIAL_COLUMNS,
    is_off_time,
)
from nvcore.subjects.driver.study.pictures import StudyPicture
from nvcore.subjects.driver.study.plan import Trial, plan_trials
from nvcore.subjects.driver.study.settings import StudySettings, Timing
from nvcore.subjects.people.participants import MOST_NAME
from nvcore.subjects.people.store import Person, Study, StudyStore, Table

MOST_DEVICE: Final = 200


@dataclass(frozen=True, kw_only=True)
class DetectabilityStudy(Study):
    """Detectability study.

    Attributes
    ----------
    settings
        Settings that the conductor chose.
    folder
        Folder of the pictures, as named by the user who began the study.
    """

    settings: StudySettings
    pictures: tuple[StudyPicture, ...]
    folder: str
    begun_at: datetime
    ends_at: datetime

    def plan(self, number: int) -> tuple[Trial, ...]:
        """Return the trials of a participant in order."""
        settings = self.settings
        return plan_trials(
            len(self.pictures), number, design=settings.design, timing=settings.timing
        )


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Answer of a participant to a picture, with the times of the picture.

    Attributes
    ----------
    measured_s
        Time from the change of light to the picture's appearance, by the animation clock.
    shown_s
        Duration for which the picture was visible, by the same clock.
    touch_x, touch_y
        Touched position, px of the picture. NaN: not seen, or no answer.
    response_s
        Time from the picture's appearance to the answer, at most 3,600 s. NaN: no answer.
    is_answered
        True for any answer, including that nobody was seen.
    device
        Input device, in words.

    Raises
    ------
    InputError
        If a number is missing or outside its range, or one of two coordinates is missing.
    """

    measured_s: float
    shown_s: float
    touch_x: float = math.nan
    touch_y: float = math.nan
    response_s: float = math.nan
    is_answered: bool = True
    device: str = ""

    def __post_init__(self) -> None:
        for name in ("measured_s", "shown_s", "response_s"):
            value = getattr(self, name)
            is_missing = name == "response_s" and math.isnan(value)
            if not is_missing and not 0 <= value <= LONGEST_S:
                raise InputError(f"{name}: expected 0 to {LONGEST_S:g} s, got {value:g}")
        place = (self.touch_x, self.touch_y)
        if not all(map(math.isnan, place)) and not all(abs(value) < 1e6 for value in place):
            raise InputError("a touch has two places, px of the picture")
        if self.is_seen and not self.is_answered:
            raise InputError("a touch is an answer")

    @property
    def is_seen(self) -> bool:
        """True if the participant touched a place."""
        return not math.isnan(self.touch_x)


class DetectabilityStore(StudyStore[DetectabilityStudy]):
    """Store of detectability studies in one file (see `store.StudyStore`)."""

    content = "study"
    study_columns = """settings TEXT NOT NULL, pictures TEXT NOT NULL, folder TEXT NOT NULL,
        begun_at TEXT NOT NULL, ends_at TEXT NOT NULL"""
    tables: ClassVar = {
        "showing": Table(
            "place INTEGER NOT NULL, n INTEGER NOT NULL, shown_at TEXT NOT NULL", key="place"
        ),
        "showing_report": Table("place INTEGER NOT NULL, name TEXT NOT NULL", key="place"),
        "trial": Table(
            """place INTEGER NOT NULL, measured_s REAL NOT NULL, shown_s REAL NOT NULL,
            touch_x REAL, touch_y REAL, response_s REAL, is_answered INTEGER NOT NULL,
            n_shown INTEGER NOT NULL, device TEXT NOT NULL, answered_at TEXT NOT NULL""",
            key="place",
        ),
    }
    trial = Trial
    has_names = False

    def study_of(self, row: dict[str, Any]) -> DetectabilityStudy:
        """Return the study of a row of the file."""
        settings = StudySettings.from_json(json.loads(row["settings"]))
        row["pictures"] = tuple(StudyPicture(**picture) for picture in json.loads(row["pictures"]))
        row |= {"settings": settings, "consent": settings.consent, "form": settings.form}
        return DetectabilityStudy(**row)

    def begin(
        self,
        settings: StudySettings,
        pictures: Sequence[StudyPicture],
        *,
        folder: str,
        now: datetime | None = None,
    ) -> DetectabilityStudy:
        """Begin a study of these pictures.

        Raises
        ------
        InputError
            If the design needs more pictures, or there are too many trials or studies.
        """
        begun_at = now or datetime.now(UTC)
        study = DetectabilityStudy(
            consent=settings.consent,
            form=settings.form,
            settings=settings,
            pictures=tuple(pictures),
            folder=folder,
            begun_at=begun_at,
            ends_at=begun_at + timedelta(days=settings.keep_days),
        )
        study.plan(0)  # rejects what the design does not allow
        return self._begin(study)

    def end_practice(self, study: DetectabilityStudy, name: str) -> None:
        """Record that the participant has finished the practice."""
        query = "UPDATE form SET has_practised = 1 WHERE study = ? AND participant = ?"
        self.execute(query, study.token, name)

    def note_showing(
        self, study: DetectabilityStudy, name: str, place: int, report: str = ""
    ) -> None:
        """Count an appearance of a trial's picture, which repeats after a reload.

        A `report` with the same name as the last one is a repetition and does not count. One
        without a name always counts.
        """
        self._trial(study, name, place)
        with self.connect() as base:
            changed = base.execute(
                "INSERT INTO showing_report VALUES (?, ?, ?, ?) "
                "ON CONFLICT DO UPDATE SET name = excluded.name WHERE name <> excluded.name",
                (study.token, name, place, report[:MOST_NAME]),
            )
            if changed.rowcount or not report:
                base.execute(
                    "INSERT INTO showing VALUES (?, ?, ?, 1, ?) "
                    "ON CONFLICT DO UPDATE SET n = n + 1, shown_at = excluded.shown_at",
                    (study.token, name, place, datetime.now(UTC).isoformat()),
                )

    def answer(self, study: DetectabilityStudy, name: str, place: int, answer: Answer) -> None:
        """Store the first answer to the trial with this ``order``, and ignore later ones.

        Raises
        ------
        InputError
            If there is no such participant or trial, or the touch is outside the trial's picture.
        """
        picture = study.pictures[self._trial(study, name, place).picture]
        x, y = answer.touch_x, answer.touch_y
        if answer.is_seen and not (0 <= x < picture.width and 0 <= y < picture.height):
            raise InputError(
                f"the touch ({x:g}, {y:g}) is outside the picture "
                f"({picture.width} x {picture.height} px)"
            )
        given = {
            of: None if isinstance(value, float) and math.isnan(value) else value
            for of, value in asdict(answer).items()
        }
        n_shown = dict(row[1:] for row in self.rows(study, "showing", "place, n", name)).get(
            place, 0
        )
        row = {"place": place, **given, "device": answer.device[:MOST_DEVICE], "n_shown": n_shown}
        row["answered_at"] = datetime.now(UTC).isoformat()
        self.keep(study, name, "trial", row)

    def _trial(self, study: DetectabilityStudy, name: str, place: int) -> Trial:
        people = self.participants(study, name)
        if not people:
            raise InputError("nobody takes part in this study under that name")
        if not 1 <= place <= len(people[0].plan):
            raise InputError(f"the participant has no trial {place}")
        trial: Trial = people[0].plan[place - 1]
        return trial

    def answers(self, study: DetectabilityStudy) -> dict[str, dict[int, tuple[Answer, int]]]:
        """Return answers by participant and ``order``, each with the number of times it was shown.

        A number of 0 means that the browser never reported the picture.
        """
        names = [field.name for field in fields(Answer)]
        answers: dict[str, dict[int, tuple[Answer, int]]] = {}
        for name, place, n_shown, *values in self.rows(
            study, "trial", f"place, n_shown, {', '.join(names)}"
        ):
            known = (math.nan if value is None else value for value in values)
            given: dict[str, Any] = dict(zip(names, known, strict=True))
            given["is_answered"] = bool(given["is_answered"])
            answers.setdefault(name, {})[place] = Answer(**given), n_shown
        return answers


def marks_of(trial: Trial, answer: Answer, n_shown: int, timing: Timing) -> list[str]:
    """Return the irregularities of a trial in words.

    A trial is marked if its picture came more than 50 ms early or late, was visible for 50 ms less
    or more than planned, was shown before (the page was reloaded before the answer), was never
    reported as shown, or has no answer within the time limit.

    Parameters
    ----------
    n_shown
        Number of times that the browser reported the picture.
    """
    late_s = answer.measured_s - trial.adaptation_s
    marks = {
        f"{abs(late_s):.2f} s {'late' if late_s > 0 else 'early'}": is_off_time(late_s),
        f"shown for {answer.shown_s:.2f} s": is_off_time(answer.shown_s - timing.show_s),
        f"shown {n_shown} times": n_shown > 1,
        "never reported as shown": n_shown == 0,
        NO_ANSWER: not answer.is_answered,
    }
    return [mark for mark, applies in marks.items() if applies]


def trials_table(store: DetectabilityStore, study: DetectabilityStudy) -> pd.DataFrame:
    """Return the exported table of trials that have an answer or whose time limit has passed.

    Returns
    -------
    The columns `TRIAL_COLUMNS`. ``subject`` is the participant's pseudonym. ``run``, ``position``
    (in the run) and ``order`` (of all trials of the subject) count from 1. Times are in seconds,
    places in pixels of the picture. ``not_seen`` is also true without an answer. ``device`` names
    the input device and, after "marked:", the irregularities (`marks_of`).
    """
    rows = []
    for person, trial, answer, marks in _answered(store, study, store.participants(study)):
        picture = study.pictures[trial.picture]
        device = [answer.device] if answer.device else []
        device += [f"marked: {', '.join(marks)}"] if marks else []
        rows.append(
            (
                *(person.name, trial.run, trial.position, trial.order),
                *(picture.image, picture.pedestrian, trial.adaptation_s, answer.measured_s),
                *(answer.touch_x, answer.touch_y, answer.response_s),
                *(not answer.is_seen, "; ".join(device)),
            )
        )
    table = pd.DataFrame(rows, columns=list(TRIAL_COLUMNS))
    kinds = dict.fromkeys(("run", "position", "order"), "int64")
    kinds |= dict.fromkeys(TRIAL_COLUMNS[6:11], "float64")
    return table.astype({**kinds, "not_seen": bool})


def _answered(
    store: DetectabilityStore, study: DetectabilityStudy, people: Sequence[Person]
) -> Iterator[tuple[Person, Trial, Answer, list[str]]]:
    """Yield all answered trials with their marks, by participant and order."""
    answers = store.answers(study)
    for person in people:
        for place, (answer, n_shown) in answers.get(person.name, {}).items():
            trial = person.plan[place - 1]
            yield person, trial, answer, marks_of(trial, answer, n_shown, study.settings.timing)


def participants_table(store: DetectabilityStore, study: DetectabilityStudy) -> pd.DataFrame:
    """Return a row for each participant.

    Returns
    -------
    ``subject``, ``joined`` (date), ``n_trials``, ``n_answered``, ``n_marked``, and the fields of
    the form, empty if not filled in.
    """
    people, n_answered, n_marked = store.participants(study), Counter[str](), Counter[str]()
    for person, _, _, marks in _answered(store, study, people):
        n_answered[person.name] += 1
        n_marked[person.name] += bool(marks)
    rows = [
        (
            *(of.name, of.consented_at.date().isoformat() if of.consented_at else ""),
            *(len(of.plan), n_answered[of.name], n_marked[of.name], *of.filled(study.form)),
        )
        for of in people
    ]
    first = ("subject", "joined", "n_trials", "n_answered", "n_marked")
    return pd.DataFrame(rows, columns=[*first, *study.form])


def boxes_table(study: DetectabilityStudy) -> pd.DataFrame:
    """Return ``image`` and ``pedestrian`` with their box ``x``, ``y``, ``w``, ``h`` (px)."""
    table = pd.DataFrame([asdict(picture) for picture in study.pictures])
    return table[[*PEDESTRIAN, *BOX]]


def about(study: DetectabilityStudy) -> dict[str, Any]:
    """Return settings, pictures and dates of a study as JSON values, without its participants."""
    return {
        "begun_at": study.begun_at.isoformat(),
        "deleted_at": study.ends_at.isoformat(),
        **asdict(study.settings),
        "pictures": [asdict(picture) for picture in study.pictures],
    }
