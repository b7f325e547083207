"""Rating sessions: people rate clips, then say whether alerts were worth it."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, ClassVar, Final, NamedTuple

import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.wording import listed
from nvcore.subjects.people.form import KEPT_DAYS, check_terms, form_of
from nvcore.subjects.people.participants import counterbalanced_order
from nvcore.subjects.people.store import Person, Study, StudyStore, Table
from nvcore.subjects.ratings.clips import clip_name
from nvcore.subjects.ratings.worth import ANSWERS, Alert

MOST_CLIPS: Final = 500
FORM: Final = ("age", "sex", "licence", "night_driving")
"""Fields of the form before a session's own questions."""
CONSENT: Final = """\
You watch short clips of drives at night, and say after each how annoying the mistakes of a driver \
assistance system are.

We keep your ratings and answers, when you gave them, how often you played each clip, what you \
say about yourself, and the name or pseudonym that you enter on this page; no one needs your real \
name. You may stop at any time, without a reason. Tell the person who conducts the session your \
name or code, and you get a copy of your ratings, or they are deleted.
"""
REPLACE: Final = """(study, participant, clip) DO UPDATE SET
    first_rating = CASE WHEN rating.rating = excluded.rating THEN rating.first_rating
        ELSE COALESCE(rating.first_rating, rating.rating) END,
    n_plays = CASE WHEN excluded.n_plays IS NULL THEN rating.n_plays
        ELSE COALESCE(rating.n_plays, 0) + excluded.n_plays END,
    rating = excluded.rating, rated_at = CURRENT_TIMESTAMP
"""


class Clip(NamedTuple):
    """Recording, or part of it, with the boxes of one system.

    Attributes
    ----------
    start_s, end_s
        Seconds since the recording's first frame; None: the whole recording.
    reason
        Event that the clip was cut around (`nvcore.subjects.ratings.clips.cut_clips`).
    """

    recording: str
    system: str
    start_s: float | None = None
    end_s: float | None = None
    reason: str = ""

    @property
    def stretch_s(self) -> tuple[float, float]:
        """Start and end, s. NaN: the whole recording."""
        if self.start_s is None or self.end_s is None:
            return math.nan, math.nan
        return self.start_s, self.end_s

    @property
    def name(self) -> str:
        """Name in tables of ratings."""
        return clip_name(self.recording, *self.stretch_s)


class Shown(NamedTuple):
    """Trial of a rating session: a clip (answered in ``rating``) or an alert (in ``worth``)."""

    table: str
    place: int


@dataclass(frozen=True, kw_only=True)
class RatingStudy(Study):
    """Rating session.

    Attributes
    ----------
    fingerprint
        Fingerprint of the dataset that the clips are from.
    low, high
        Ends of the scale: not annoying at all, very annoying.
    thresholds
        Score threshold of each system, None if every detection is shown. All participants see the
        same boxes.
    alerts
        Alerts that participants judge after the clips.
    """

    fingerprint: str
    clips: tuple[Clip, ...]
    low: int
    high: int
    thresholds: Mapping[str, float | None]
    alerts: tuple[Alert, ...] = ()

    def plan(self, number: int) -> tuple[Shown, ...]:
        """Return the clips, then the alerts, each in the participant's own balanced order."""
        items = (("rating", len(self.clips)), ("worth", len(self.alerts)))
        return tuple(
            Shown(table, int(place))
            for table, n in items
            for place in counterbalanced_order(n, number)
        )


class RatingStore(StudyStore[RatingStudy]):
    """Store of rating sessions in one file (see `nvcore.subjects.people.store.StudyStore`)."""

    content = "ratings"
    study_columns = """fingerprint TEXT NOT NULL, clips TEXT NOT NULL, low INTEGER NOT NULL,
        high INTEGER NOT NULL, thresholds TEXT NOT NULL, consent TEXT NOT NULL DEFAULT '',
        ends_at TEXT, alerts TEXT NOT NULL DEFAULT '[]', form TEXT NOT NULL DEFAULT '{}'"""
    entry: ClassVar = {
        "consent": Table("consented_at TEXT NOT NULL"),
        "form": Table("field TEXT NOT NULL, answer TEXT NOT NULL", key="field"),
    }
    tables: ClassVar = {
        "rating": Table(
            """clip INTEGER NOT NULL, rating INTEGER NOT NULL,
            rated_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP, n_plays INTEGER,
            first_rating INTEGER""",
            key="clip",
        ),
        "worth": Table(
            """alert INTEGER NOT NULL, answer TEXT NOT NULL,
            answered_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP""",
            key="alert",
        ),
    }
    trial = Shown
    people = (
        "SELECT name, number, consented_at, (SELECT json_group_object(field, answer) FROM form "
        "WHERE form.study = participant.study AND form.participant = name), NULL, 1 "
        "FROM participant LEFT JOIN consent ON consent.study = participant.study "
        "AND consent.participant = name"
    )

    def study_of(self, row: dict[str, Any]) -> RatingStudy:
        """Return the session of a row of the file."""
        row |= {of: json.loads(row[of]) for of in ("clips", "thresholds", "alerts", "form")}
        row["clips"] = tuple(Clip(*clip) for clip in row["clips"])
        row["alerts"] = tuple(Alert(*alert) for alert in row["alerts"])
        return RatingStudy(**row)

    def _entry(self, person: Person) -> Iterator[tuple[str, dict[str, Any]]]:
        if person.consented_at is not None:
            yield "consent", {"consented_at": person.consented_at.isoformat()}
        for asked, answer in person.form.items():
            yield "form", {"field": asked, "answer": answer}

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
    ) -> RatingStudy:
        """Begin a session with these clips.

        Parameters
        ----------
        clips
            Fields of `Clip`: recording and system at least.
        consent
            Text that participants agree to; None: they are asked elsewhere.
        keep_days
            Days after which the session is deleted with all ratings.
        alerts
            Alerts from `nvcore.subjects.ratings.worth.read_alerts`.
        questions
            Own questions of the form; None: participants fill in none.
        now
            Time of the beginning, UTC. None: the current time.

        Raises
        ------
        InputError
            If there is no clip, one twice or too many, the scale does not rise, or the terms are
            invalid.
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
        check_terms(CONSENT if consent is None else consent, keep_days, questions or ())
        study = RatingStudy(
            fingerprint=fingerprint,
            clips=shown,
            low=low,
            high=high,
            thresholds=dict(thresholds or {}),
            consent=consent or "",
            ends_at=(now or datetime.now(UTC)) + timedelta(days=keep_days),
            alerts=tuple(alerts),
            form={} if questions is None else form_of(FORM, questions),
        )
        return self._begin(study)

    def rate(
        self, study: RatingStudy, name: str, clip: int, rating: int, *, n_plays: int | None = None
    ) -> None:
        """Keep a rating. Another one of the same clip replaces it, but the first is remembered.

        Parameters
        ----------
        n_plays
            Number of times that the clip was played to its end before this rating (again, for
            another one of the same clip); None: not known.
        """
        if not 0 <= clip < len(study.clips):
            raise InputError(f"there is no clip {clip + 1}")
        if not study.low <= rating <= study.high:
            raise InputError(f"a rating is {study.low} to {study.high}; given {rating}")
        row = {"clip": clip, "rating": rating, "n_plays": n_plays}
        self.keep(study, name, "rating", row, conflict=REPLACE)

    def judge(self, study: RatingStudy, name: str, alert: int, answer: str) -> None:
        """Keep whether an alert was worth it, by one of `ANSWERS`. Another answer replaces it."""
        if not 0 <= alert < len(study.alerts):
            raise InputError(f"there is no alert {alert + 1}")
        if answer not in ANSWERS:
            raise InputError(f"an answer is {listed([*ANSWERS])}; given {answer!r}")
        self.keep(
            study, name, "worth", {"alert": alert, "answer": answer},
            conflict="DO UPDATE SET answer = excluded.answer",
        )  # fmt: skip

    def ratings_of(self, study: RatingStudy, name: str) -> dict[int, int]:
        """Return the ratings that this participant has given, by clip."""
        return {
            clip: rating for _, clip, rating in self.rows(study, "rating", "clip, rating", name)
        }

    def forms(self, study: RatingStudy) -> pd.DataFrame:
        """Return ``participant`` and the form's fields of everybody, "" where left empty."""
        rows = [(of.name, *of.filled(study.form)) for of in self.participants(study)]
        return pd.DataFrame(rows, columns=["participant", *study.form])

    def progress(self, study: RatingStudy) -> pd.DataFrame:
        """Return ``participant``, ``n_rated`` and ``n_answered`` of everybody who has joined."""
        rated, answered = (
            Counter(row[0] for row in self.rows(study, *of))
            for of in (("rating", "clip"), ("worth", "alert"))
        )
        names = [of.name for of in self.participants(study)]
        rows = [(name, rated[name], answered[name]) for name in names]
        return pd.DataFrame(rows, columns=["participant", "n_rated", "n_answered"])

    def ratings(self, study: RatingStudy) -> pd.DataFrame:
        """Return all ratings of a session as `read_ratings` does, with more columns.

        Returns
        -------
        Also ``n_plays``, how often the clip was played to its end (missing: not recorded), and
        ``first_rating``, the rating before it was changed (missing: it never was); both Int64.
        Where clips are stretches, ``recording``, ``start_s``, ``end_s`` and ``reason``.
        """
        rows = self.rows(study, "rating", "clip, rating, n_plays, first_rating")
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

    def worth(self, study: RatingStudy) -> pd.DataFrame:
        """Return ``participant``, ``alert`` (number), ``answer`` and the fields of `Alert`."""
        rows = self.rows(study, "worth", "alert, answer")
        table = pd.DataFrame(rows, columns=["participant", "alert", "answer"])
        alerts = pd.DataFrame(study.alerts, columns=[*Alert._fields])
        return table.join(alerts, on="alert")

    def record(self, study: RatingStudy, person: Person) -> dict[str, Any]:
        """Return all that the file holds of a participant, with clips and alerts in full."""
        record = super().record(study, person)
        for row in record["rating"]:
            clip = study.clips[row["clip"]]._asdict()
            row["clip"] = {name: value for name, value in clip.items() if value not in (None, "")}
        for row in record["worth"]:
            row["alert"] = study.alerts[row["alert"]]._asdict()
        return record
