"""Detectability studies: what is kept of pictures and answers, and the tables of them."""

import json
import math
import sqlite3
from contextlib import closing
from datetime import UTC, datetime

import pytest

from nvcore.common.errors import InputError
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.subjects.driver.study.pictures import StudyPicture
from nvcore.subjects.driver.study.settings import Facts, StudySettings
from nvcore.subjects.driver.study.touch_task import (
    TRIAL_COLUMNS,
    Answer,
    DetectabilityStore,
    about,
    boxes_table,
    participants_table,
    trials_table,
)

BOX = (10.0, 5.0, 6.0, 12.0, 40, 30, "0" * 64)
PICTURES = tuple(StudyPicture(f"{name}.png", "p", *BOX) for name in "abcdef")
SEEN = Answer(
    measured_s=1.0, shown_s=0.5, touch_x=12.5, touch_y=9.0, response_s=0.8, device="touch"
)


@pytest.fixture
def store(tmp_path):
    return DetectabilityStore(tmp_path / "studies.sqlite")


@pytest.fixture
def study(store):
    return store.begin(StudySettings(questions=("Glasses?",)), PICTURES, folder="sample")


def join(store, study, form=None):
    return store.join(study, form or {})[0]


def test_participants_get_pseudonyms_codes_and_the_rows_of_the_design(store, study, tmp_path):
    joined = [store.join(study, {"age": "30", "1. Glasses?": "no"}, name="Ann") for _ in range(6)]
    people = [person for person, _ in joined]
    assert [person.number for person in people] == list(range(6))
    assert len({person.name for person in people} - {"Ann"}) == 6
    shown = {(t.picture, t.adaptation_s) for person in people for t in person.plan}
    assert len(shown) == 36
    again = DetectabilityStore(tmp_path / "studies.sqlite")
    assert str(again.study(study.token)) == str(study)
    assert again.by_code(study, joined[2][1].lower()) == people[2]
    assert again.by_code(study, people[2].name) is None  # tables say it
    assert again.participants(study) == people


def test_answers_are_kept_once_and_the_next_trial_follows(store, study):
    person = join(store, study)
    assert store.left(study, person) == list(person.plan)
    store.answer(study, person.name, 1, SEEN)
    store.answer(study, person.name, 1, Answer(measured_s=9, shown_s=9))  # changes nothing
    assert store.left(study, person) == list(person.plan[1:])
    assert store.answers(study)[person.name] == {1: (SEEN, 0)}  # never reported as shown


def test_the_trials_are_a_table_with_the_columns_of_the_driver(store, study):
    assert tuple(trials_table(store, study)) == TRIAL_COLUMNS
    assert participants_table(store, study).columns[-1] == "1. Glasses?"
    person = join(store, study)
    first, second, third, *_ = person.plan
    store.note_showing(study, person.name, 1)
    store.note_showing(study, person.name, 2)
    store.answer(
        study, person.name, 1, Answer(**{**vars(SEEN), "measured_s": first.adaptation_s + 0.016})
    )
    store.answer(
        study,
        person.name,
        2,
        Answer(measured_s=second.adaptation_s + 0.12, shown_s=0.6, device="mouse", response_s=1.5),
    )
    store.note_showing(study, person.name, 3)
    store.note_showing(study, person.name, 3)
    store.answer(
        study, person.name, 3, Answer(measured_s=third.adaptation_s, shown_s=0.5, is_answered=False)
    )
    unreported = {**vars(SEEN), "measured_s": person.plan[3].adaptation_s}
    store.answer(study, person.name, 4, Answer(**unreported))
    table = trials_table(store, study)
    assert tuple(table) == TRIAL_COLUMNS
    assert table["order"].tolist() == [1, 2, 3, 4]
    assert table["position"].tolist() == [1, 2, 1, 2]
    assert table["not_seen"].tolist() == [False, True, True, False]
    assert table["image"].tolist() == [PICTURES[t.picture].image for t in person.plan[:4]]
    assert table["device"].tolist() == [
        "touch",
        "mouse; marked: 0.12 s late, shown for 0.60 s",
        "marked: shown 2 times, no answer",
        "touch; marked: never reported as shown",
    ]
    lines = to_csv_bytes(table).decode().splitlines()
    assert lines[0] == (
        "subject,run,position,order,image,pedestrian,adaptation_asked_s,adaptation_measured_s,"
        "touch_x,touch_y,response_s,not_seen,device"
    )
    assert lines[1].startswith(f"{person.name},1,1,1,{PICTURES[first.picture].image},p,")
    assert lines[1].endswith(",12.5,9,0.8,0,touch")
    people = participants_table(store, study)
    assert people[["n_trials", "n_answered", "n_marked"]].to_numpy().tolist() == [[6, 4, 3]]


def test_strangers_and_what_was_not_asked_are_refused(store, study):
    person = join(store, study)
    with pytest.raises(InputError, match="nobody takes part"):
        store.answer(study, "nobody", 1, SEEN)
    for place in (0, 7):
        with pytest.raises(InputError, match=f"no trial {place}"):
            store.note_showing(study, person.name, place)
    with pytest.raises(InputError, match="needs 2 pictures"):
        store.begin(StudySettings(design="all"), PICTURES[:1], folder="sample")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"measured_s": -1}, "measured_s"),
        ({"shown_s": math.inf}, "shown_s"),
        ({"response_s": -0.1}, "response_s"),
        ({"response_s": 3601}, "response_s: expected 0 to 3600 s, got 3601"),
        ({"response_s": 1e300}, "response_s"),
        ({"touch_y": math.nan}, "two places"),
        ({"touch_x": 1e9}, "two places"),
        ({"is_answered": False}, "is an answer"),
    ],
)
def test_answers_that_cannot_be_are_refused(wrong, words):
    with pytest.raises(InputError, match=words):
        Answer(**{**vars(SEEN), **wrong})


@pytest.mark.parametrize("place", [(-1, 5), (40, 5), (5, -0.5), (5, 30), (999_999, -999_999)])
def test_a_touch_outside_the_picture_is_refused(store, study, place):
    person = join(store, study)
    beside = Answer(**{**vars(SEEN), "touch_x": place[0], "touch_y": place[1]})
    with pytest.raises(InputError, match=r"outside the picture \(40 x 30 px\)"):
        store.answer(study, person.name, 1, beside)
    assert store.answers(study) == {}
    corner = Answer(**{**vars(SEEN), "touch_x": 39.9, "touch_y": 0})
    store.answer(study, person.name, 1, corner)
    assert store.answers(study)[person.name][1][0] == corner


def test_how_a_study_was_done_is_told_without_anybody(store, study):
    store.join(study, {"age": "seventy-seven"})  # digits may be those of a time
    facts = json.dumps(about(study), allow_nan=False)
    assert "seventy-seven" not in facts
    assert json.loads(facts)["timing"]["adaptation_s"] == [0, 1, 2.5, 4, 5.5, 7]
    assert boxes_table(study).to_numpy().tolist()[0] == ["a.png", "p", 10, 5, 6, 12]
    other = store.begin(StudySettings(facts=Facts(dark_lux=10)), PICTURES, folder="sample")
    assert about(other)["facts"] == {
        "screen_inch": None, "distance_cm": None, "bright_lux": None, "dark_lux": 10,
    }  # fmt: skip


# Written by the version before personal codes (SQL of its file).
EARLIER = """
CREATE TABLE form (
    study TEXT NOT NULL, participant TEXT NOT NULL, consented_at TEXT NOT NULL,
    answers TEXT NOT NULL, plan TEXT NOT NULL, has_practised INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (study, participant),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
INSERT INTO "form" VALUES('study-token','ANNASCDE','2026-03-01T00:00:00+00:00',
    '{"age": "30", "1. Glasses?": "no"}','[[1, 1, 1, 0, 0.0], [2, 1, 2, 1, 5.0]]',1);
INSERT INTO "form" VALUES('study-token','BOBSCDEF','2026-03-01T00:00:00+00:00','{}',
    '[[1, 1, 1, 1, 0.0], [2, 1, 2, 0, 5.0]]',0);
CREATE TABLE participant (
    study TEXT NOT NULL REFERENCES study, name TEXT NOT NULL, number INTEGER NOT NULL,
    PRIMARY KEY (study, name), UNIQUE (study, number));
INSERT INTO "participant" VALUES('study-token','ANNASCDE',0);
INSERT INTO "participant" VALUES('study-token','BOBSCDEF',1);
CREATE TABLE showing (
    study TEXT NOT NULL, participant TEXT NOT NULL, place INTEGER NOT NULL, n INTEGER NOT NULL,
    shown_at TEXT NOT NULL, PRIMARY KEY (study, participant, place),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
INSERT INTO "showing" VALUES('study-token','ANNASCDE',1,1,'2026-03-02T10:28:52+00:00');
CREATE TABLE showing_report (
    study TEXT NOT NULL, participant TEXT NOT NULL, place INTEGER NOT NULL, name TEXT NOT NULL,
    PRIMARY KEY (study, participant, place),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
INSERT INTO "showing_report" VALUES('study-token','ANNASCDE',1,'x');
CREATE TABLE study (
    token TEXT PRIMARY KEY, conductor TEXT NOT NULL UNIQUE, settings TEXT NOT NULL,
    pictures TEXT NOT NULL, folder TEXT NOT NULL, begun_at TEXT NOT NULL, ends_at TEXT NOT NULL);
INSERT INTO "study" VALUES('study-token','study-conductor','{"design": "latin", "timing":
    {"adaptation_s": [0.0, 5.0], "bright_s": 30.0, "preview_s": 2.0, "cross_s": 1.0, "show_s": 0.5,
    "answer_s": 3.0, "again_s": 0.5}, "facts": {"screen_inch": null, "distance_cm": null,
    "bright_lux": null, "dark_lux": 10}, "consent": "Yes.", "questions": ["Glasses?"],
    "n_practice": 1, "keep_days": 365}','[{"image": "a.png", "pedestrian": "p", "x": 10.0,
    "y": 5.0, "w": 6.0, "h": 12.0, "width": 40, "height": 30, "sha256": "00"}, {"image": "b.png",
    "pedestrian": "p", "x": 10.0, "y": 5.0, "w": 6.0, "h": 12.0, "width": 40, "height": 30,
    "sha256": "00"}]','local:dusk','2026-03-01T00:00:00+00:00','2027-03-01T00:00:00+00:00');
CREATE TABLE trial (
    study TEXT NOT NULL, participant TEXT NOT NULL, place INTEGER NOT NULL,
    measured_s REAL NOT NULL, shown_s REAL NOT NULL, touch_x REAL, touch_y REAL,
    response_s REAL, is_answered INTEGER NOT NULL, n_shown INTEGER NOT NULL,
    device TEXT NOT NULL, answered_at TEXT NOT NULL,
    PRIMARY KEY (study, participant, place),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
INSERT INTO "trial" VALUES('study-token','ANNASCDE',1,0.0,0.5,12.5,9.0,0.8,1,1,'touch',
    '2026-03-02T10:28:52+00:00');
"""


def test_a_study_of_an_earlier_version_goes_on(tmp_path):
    path = tmp_path / "earlier.sqlite"
    with closing(sqlite3.connect(path)) as base:
        base.executescript(EARLIER)
    store = DetectabilityStore(path, now=datetime(2026, 4, 1, tzinfo=UTC))
    study = store.study("study-token")
    assert str(store.study_of_conductor("study-conductor")) == str(study)
    assert (study.folder, study.ends_at) == ("local:dusk", datetime(2027, 3, 1, tzinfo=UTC))
    assert about(study)["facts"]["dark_lux"] == 10
    trials = to_csv_bytes(trials_table(store, study)).decode().splitlines()
    assert trials[1:] == ["ANNASCDE,1,1,1,a.png,p,0,0,12.5,9,0.8,0,touch"]
    people = to_csv_bytes(participants_table(store, study)).decode().splitlines()
    assert people == [
        "subject,joined,n_trials,n_answered,n_marked,age,vision,licence,screen_inch,distance_cm,"
        "1. Glasses?",
        "ANNASCDE,2026-03-01,2,1,0,30,,,,,no",
        "BOBSCDEF,2026-03-01,2,0,0,,,,,,",
    ]
    # codes were the names; until the conductor gives another one, they still work
    ann = store.by_code(study, "annascde")
    assert (ann.name, ann.has_practised, len(store.left(study, ann))) == ("ANNASCDE", True, 1)
    bob = store.find(study, "BOBSCDEF")
    code = store.new_code(study, bob)
    assert store.by_code(study, "BOBSCDEF") is None
    assert store.by_code(study, code) == bob
    store.answer(study, "ANNASCDE", 2, SEEN)
    assert store.left(study, ann) == []
    assert join(store, study).number == 2
    assert DetectabilityStore(path, now=study.ends_at).study("study-token") is None
