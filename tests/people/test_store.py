"""The engine of studies, with a task of its own: who takes part, and that nothing is lost."""

from __future__ import annotations

import os
import signal
import sqlite3
import stat
import warnings
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from typing import ClassVar, NamedTuple

import pytest

from nvcore.common.errors import InputError, StoreError
from nvcore.subjects.driver.study.pictures import StudyPicture
from nvcore.subjects.driver.study.settings import StudySettings
from nvcore.subjects.driver.study.touch_task import Answer, DetectabilityStore
from nvcore.subjects.people import store as engine
from nvcore.subjects.people.participants import counterbalanced_order
from nvcore.subjects.people.store import Study, StudyStore, Table
from nvcore.subjects.ratings.clip_task import RatingStore

NOW = datetime(2026, 3, 1, tzinfo=UTC)
FORM = {"age": "Age in years", "1. Shoe size": "Shoe size"}


class Question(NamedTuple):
    """A trial: a question with this number."""

    place: int
    table: str = "reply"


@dataclass(frozen=True, kw_only=True)
class Quiz(Study):
    """A study of the smallest task that there may be."""

    n: int
    form: ClassVar = FORM

    def plan(self, number: int) -> tuple[Question, ...]:
        return tuple(Question(place) for place in counterbalanced_order(self.n, number).tolist())


class QuizStore(StudyStore[Quiz]):
    """Quizzes in one file."""

    content = "replies"
    study_columns = "n INTEGER NOT NULL, ends_at TEXT, consent TEXT NOT NULL DEFAULT ''"
    tables: ClassVar = {"reply": Table("place INTEGER NOT NULL, text TEXT NOT NULL", key="place")}
    trial = Question

    def study_of(self, row):
        return Quiz(**row)

    def begin(self, n=4, *, days=10):
        ends_at = NOW + timedelta(days=days)
        return self._begin(Quiz(n=n, ends_at=ends_at, consent="We keep it."))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "new" / "replies.sqlite"


@pytest.fixture
def store(path):
    return QuizStore(path, now=NOW)


def joined(store, study, *names):
    return [store.join(study, {}, name=name)[0] for name in names]


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 9])
def test_orders_are_balanced(n):
    rows = [counterbalanced_order(n, i).tolist() for i in range(n if n % 2 == 0 else 2 * n)]
    assert all(sorted(row) == list(range(n)) for row in rows)
    places = Counter((place, clip) for row in rows for place, clip in enumerate(row))
    assert set(places.values()) == {len(rows) // n}
    follows = Counter(pair for row in rows for pair in pairwise(row))
    assert len(follows) == n * (n - 1)
    assert len(set(follows.values())) <= 1


def test_a_study_opens_by_its_two_names_alone(store, path):
    study, other = store.begin(), store.begin()
    assert len({study.token, study.conductor, other.token, other.conductor}) == 4
    again = QuizStore(path, now=NOW)
    assert again.study(study.token) == again.study_of_conductor(study.conductor) == study
    assert again.study(study.conductor) is None
    assert again.study_of_conductor(study.token) is None
    assert again.study("x' OR '1'='1") is None


def test_numbers_count_within_a_study_and_who_leaves_makes_room(store):
    study, other = store.begin(), store.begin()
    people = joined(store, study, "Ann", " Bob ", "Cem")
    assert [(of.name, of.number) for of in people] == [("Ann", 0), ("Bob", 1), ("Cem", 2)]
    assert joined(store, other, "Dan")[0].number == 0
    store.delete(study, people[1])
    assert store.find(study, "Bob") is None
    assert [of.number for of in joined(store, study, "Eve", "Fay")] == [1, 3]
    assert [of.name for of in store.participants(study)] == ["Ann", "Eve", "Cem", "Fay"]


def test_a_second_form_under_one_name_is_refused_and_the_first_one_stays(store):
    study = store.begin()
    first, code = store.join(study, {"age": "31"}, name="Anna K")
    for name in ("Anna K", " anna  k"):
        with pytest.raises(InputError, match=r"takes part already: choose another name, or go on"):
            store.join(study, {"age": "60"}, name=name)
    assert [of.number for of in store.participants(study)] == [0]
    assert store.by_code(study, code).name == first.name


def test_only_the_code_finds_a_participant_and_the_file_has_its_hash_alone(store, path):
    study, other = store.begin(), store.begin()
    anna, code = store.join(study, {}, name="Anna")
    _, bobs = store.join(study, {}, name="Bob")
    assert store.by_code(study, f" {code.lower().replace('-', '')}") == anna
    assert store.by_code(study, bobs).name == "Bob"
    for wrong in ("Anna", "", "ABCD-EFGH-JKLM", anna.name + code):
        assert store.by_code(study, wrong) is None
    assert store.by_code(other, code) is None
    assert store.find(study, "ANNA") == store.find(study, code) == anna
    content = path.read_bytes()
    assert b"Anna" in content
    assert code.encode() not in content
    assert code.replace("-", "").encode() not in content


def test_a_new_code_ends_the_one_before(store):
    study = store.begin()
    anna, code = store.join(study, {}, name="Anna")
    _, bobs = store.join(study, {}, name="Bob")
    new = store.new_code(study, anna)
    assert store.by_code(study, code) is None
    assert store.by_code(study, new) == anna
    assert store.by_code(study, bobs).name == "Bob"
    store.delete(study, anna)
    with pytest.raises(InputError, match="Anna does not take part in this study any more"):
        store.new_code(study, anna)


def test_who_has_not_agreed_gets_no_code(store):
    study = store.begin()
    with store.connect() as base:
        base.execute("INSERT INTO participant VALUES (?, 'Cem', 0, NULL)", (study.token,))
        row = (study.token, NOW.isoformat())
        base.execute("INSERT INTO form VALUES (?, 'Cem', ?, '{}', '[]', 1)", row)
    cem = store.find(study, "Cem")
    store.new_code(study, cem)
    stranger = replace(cem, consented_at=None)
    with pytest.raises(InputError, match="Cem has not agreed to the terms"):
        store.new_code(study, stranger)
    store.new_code(replace(study, consent=""), stranger)  # nothing to agree to


def test_answers_are_kept_once_and_trials_without_one_are_left(store):
    study = store.begin()
    ann, bob = joined(store, study, "Ann", "Bob")
    assert store.left(study, ann) == [*ann.plan]
    for text in ("yes", "no"):  # the second changes nothing
        store.keep(study, "Ann", "reply", {"place": ann.plan[0].place, "text": text})
    assert store.left(study, ann) == [*ann.plan[1:]]
    assert store.left(study, bob) == [*bob.plan]
    assert store.rows(study, "reply", "text") == [("Ann", "yes")]
    with pytest.raises(InputError, match="Eve does not take part"):
        store.keep(study, "Eve", "reply", {"place": 0, "text": "yes"})


def test_who_leaves_takes_the_answers_along_and_leaves_no_bytes(store, path):
    study, text = store.begin(), "my secret answer, of which nothing stays"
    ann, bob = joined(store, study, "Ann", "Bob")
    store.keep(study, "Ann", "reply", {"place": 0, "text": text})
    store.keep(study, "Bob", "reply", {"place": 1, "text": "x"})
    assert text.encode() in path.read_bytes()
    assert store.record(study, ann) == {
        "participant": "Ann", "number": 0, "reply": [{"place": 0, "text": text}],
        "form": [
            {
                "consented_at": ann.consented_at.isoformat(), "answers": {},
                "plan": [list(trial) for trial in ann.plan], "has_practised": 0,
            }
        ],
    }  # fmt: skip
    store.delete(study, ann)
    assert text.encode() not in path.read_bytes()
    assert store.participants(study) == [bob]
    assert store.rows(study, "reply", "text") == [("Bob", "x")]


def test_a_study_ends_with_all_answers_when_its_time_is_over(store, path):
    short, long = store.begin(days=10), store.begin(days=11)
    for study in (short, long):
        joined(store, study, "Ann")
        store.keep(study, "Ann", "reply", {"place": 0, "text": "yes"})
    assert QuizStore(path, now=NOW + timedelta(days=9.9)).study(short.token) == short
    after = QuizStore(path, now=NOW + timedelta(days=10))
    assert after.study(short.token) is None
    assert after.participants(short) == after.rows(short, "reply", "text") == []
    assert after.study(long.token) == long
    assert len(after.rows(long, "reply", "text")) == 1


@pytest.mark.parametrize(
    ("name", "answers", "words"),
    [
        ("  ", {}, "1 to 64 characters"),
        ("x" * 65, {}, "1 to 64 characters"),
        ("Ann", {"height": "2 m"}, "no field height"),
        ("Ann", {"age": "9" * 2001}, "2,000 characters"),
    ],
)
def test_what_cannot_be_entered_is_refused_and_nobody_joins(store, name, answers, words):
    study = store.begin()
    with pytest.raises(InputError, match=words):
        store.join(study, answers, name=name)
    assert store.participants(study) == []


def test_many_join_at_once_and_each_gets_a_number(store):
    study = store.begin()

    def join(number):
        try:
            return store.join(study, {}, name=f"P{number % 10}")[0].number
        except InputError:
            return None

    with ThreadPoolExecutor(8) as pool:
        numbers = list(pool.map(join, range(12)))
    assert sorted(n for n in numbers if n is not None) == list(range(10))


def test_there_is_room_for_so_many_and_no_more(store, monkeypatch):
    monkeypatch.setattr(engine, "MOST_PARTICIPANTS", 2)
    monkeypatch.setattr(engine, "MOST_STUDIES", 2)
    study = store.begin()
    joined(store, study, "Ann", "Bob")
    with pytest.raises(InputError, match="limit of 2 participants"):
        joined(store, study, "Cem")
    joined(store, store.begin(), "Ann")
    with pytest.raises(InputError, match="limit of 2 studies"):
        store.begin()


def test_no_acknowledged_answer_is_lost_when_the_program_is_killed(tmp_path):
    ratings, studies = RatingStore(tmp_path / "r.sqlite"), DetectabilityStore(tmp_path / "s.sqlite")
    session = ratings.begin("print", [("A", str(n)) for n in range(400)])
    ratings.join(session, {}, name="P1")
    picture = StudyPicture("a.png", "p", 10, 5, 6, 12, 40, 30, "0" * 64)
    study = studies.begin(StudySettings(), [picture] * 400, folder="sample")
    person, _ = studies.join(study, {})
    reader, writer = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # later versions of Python warn where threads run
        child = os.fork()
    if child == 0:
        try:
            for n in range(400):
                ratings.rate(session, "P1", n, 1 + n % 7)
                os.write(writer, f"rating {n}\n".encode())
                studies.answer(study, person.name, n + 1, Answer(measured_s=1, shown_s=0.5))
                os.write(writer, f"trial {n + 1}\n".encode())
        finally:
            os._exit(1)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        said = [pipe.readline().split() for _ in range(21)]
        os.kill(child, signal.SIGKILL)  # while it writes on
        said += [line.split() for line in pipe]
    _, status = os.waitpid(child, 0)
    assert os.WTERMSIG(status) == signal.SIGKILL
    rated, answered = ({int(n) for k, n in said if k == of} for of in ("rating", "trial"))
    assert 10 <= len(answered) < 400
    kept = ratings.ratings_of(session, "P1")
    assert rated <= set(kept)
    assert all(rating == 1 + n % 7 for n, rating in kept.items())
    assert answered <= set(studies.answers(study)[person.name])


def test_every_connection_waits_until_the_disk_has_what_is_written(store):
    with store.connect() as base:
        pragmas = ("synchronous", "secure_delete", "foreign_keys")
        assert [base.execute(f"PRAGMA {of}").fetchone()[0] for of in pragmas] == [2, 1, 1]


@pytest.fixture
def open_umask():
    """Permissions are those that the program asks for."""
    before = os.umask(0)
    yield
    os.umask(before)


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.usefixtures("open_umask")
def test_a_new_file_and_its_journal_are_readable_by_this_user_alone(store, path):
    with store.connect() as base:
        base.execute("INSERT INTO study VALUES ('a', 'b', 1, NULL, '')")
        modes = {file.name: mode(file) for file in path.parent.iterdir()}
    assert modes == {"replies.sqlite": 0o600, "replies.sqlite-journal": 0o600}
    assert mode(path.parent) == 0o700
    path.chmod(0o640)
    assert QuizStore(path, now=NOW).study("a") is not None
    assert mode(path) == 0o640  # a file that is there keeps its permissions


def test_a_file_of_an_earlier_version_gets_what_it_lacks(path):
    path.parent.mkdir()
    with sqlite3.connect(path) as base:
        base.executescript(
            "CREATE TABLE study (n INTEGER, token TEXT PRIMARY KEY, conductor TEXT UNIQUE);"
            "INSERT INTO study VALUES (4, 'a', 'b');"
        )
    base.close()
    store = QuizStore(path)
    assert store.study("a") == Quiz(token="a", conductor="b", n=4)
    joined(store, store.study("a"), "Ann")


def test_files_that_cannot_be_used_are_told(tmp_path, store):
    (tmp_path / "link.sqlite").symlink_to(tmp_path / "gone" / "answers.sqlite")
    with pytest.raises(InputError, match=r"file of the replies cannot be used \(No such file"):
        QuizStore(tmp_path / "link.sqlite")
    other = tmp_path / "other.sqlite"
    other.write_bytes(b"something else entirely " * 100)
    with pytest.raises(StoreError, match="file of the replies cannot be used"):
        QuizStore(other)
    assert other.read_bytes().startswith(b"something else")
    with pytest.raises(InputError, match="folder of the replies cannot be made"):
        QuizStore(other / "below" / "replies.sqlite")
    fill = "PRAGMA max_page_count = 1; CREATE TABLE a AS SELECT zeroblob(1000000)"
    with pytest.raises(StoreError, match="disk is full"), store.connect() as base:
        base.executescript(fill)
