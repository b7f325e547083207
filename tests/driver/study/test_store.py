"""Studies on disk: every answer outlives everything, and leaves when its participant does."""

import json
import math
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta

import pytest

from nvcore.driver.study.pictures import StudyPicture
from nvcore.driver.study.records import Answer
from nvcore.driver.study.settings import Facts, StudySettings
from nvcore.driver.study.store import DetectabilityStore
from nvcore.driver.study.tables import (
    TRIAL_COLUMNS,
    Advance,
    about,
    advance_of,
    boxes_table,
    participants_table,
    trials_table,
)
from nvcore.errors import InputError
from nvcore.output.csv_text import to_csv_bytes

BOX = (10.0, 5.0, 6.0, 12.0, 40, 30, "0" * 64)
PICTURES = tuple(StudyPicture(f"{name}.png", "p", *BOX) for name in "abcdef")
SEEN = Answer(
    measured_s=1.0, shown_s=0.5, touch_x=12.5, touch_y=9.0, response_s=0.8, device="touch"
)


@pytest.fixture
def store(tmp_path):
    return DetectabilityStore(tmp_path / "new" / "studies.sqlite")


@pytest.fixture
def study(store):
    return store.begin(StudySettings(questions=("Glasses?",)), PICTURES, folder="sample")


def test_a_study_is_the_same_when_it_is_opened_again(store, study, tmp_path):
    again = DetectabilityStore(tmp_path / "new" / "studies.sqlite")
    for known in (again.study(study.token), again.study_of_conductor(study.conductor)):
        assert str(known) == str(study)
    assert again.study(study.conductor) is None
    assert again.study_of_conductor(study.token) is None
    assert (tmp_path / "new").stat().st_mode & 0o077 == 0


def test_participants_get_codes_and_the_rows_of_the_design(store, study):
    people = [store.join(study, {"age": "30", "1. Glasses?": "no"}) for _ in range(6)]
    assert [person.number for person in people] == list(range(6))
    assert len({person.code for person in people}) == 6
    shown = {(t.picture, t.adaptation_s) for person in people for t in person.plan}
    assert len(shown) == 36
    assert store.participant(study, f" {people[2].code.lower()} ") == people[2]
    assert store.participant(study, "nobody") is None
    assert store.participants(study) == people


def test_answers_are_kept_once_and_the_next_trial_follows(store, study):
    person = store.join(study, {})
    assert store.left(study, person) == list(person.plan)
    store.answer(study, person.code, 1, SEEN)
    store.answer(study, person.code, 1, Answer(measured_s=9, shown_s=9))  # changes nothing
    assert store.left(study, person) == list(person.plan[1:])
    assert store.answers(study)[person.code] == {1: (SEEN, 0)}  # never reported as shown


def test_an_answer_is_there_after_the_program_is_killed(tmp_path):
    path = tmp_path / "studies.sqlite"
    code = f"""
import os, signal
from pathlib import Path
from nvcore.driver.study.pictures import StudyPicture
from nvcore.driver.study.records import Answer
from nvcore.driver.study.settings import StudySettings
from nvcore.driver.study.store import DetectabilityStore
store = DetectabilityStore(Path({str(path)!r}))
study = store.begin(StudySettings(), {PICTURES!r}, folder="sample")
person = store.join(study, {{}})
store.answer(study, person.code, 1, Answer(measured_s=1, shown_s=0.5))
print(study.token, person.code, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert ended.returncode == -signal.SIGKILL, ended.stderr
    token, subject = ended.stdout.split()
    store = DetectabilityStore(path)
    assert list(store.answers(store.study(token))[subject]) == [1]


def test_the_trials_are_a_table_with_the_columns_of_the_driver(store, study):
    person = store.join(study, {})
    first, second, third, *_ = person.plan
    store.note_showing(study, person.code, 1)
    store.note_showing(study, person.code, 2)
    store.answer(
        study, person.code, 1, Answer(**{**vars(SEEN), "measured_s": first.adaptation_s + 0.016})
    )
    store.answer(
        study,
        person.code,
        2,
        Answer(measured_s=second.adaptation_s + 0.12, shown_s=0.6, device="mouse", response_s=1.5),
    )
    store.note_showing(study, person.code, 3)
    store.note_showing(study, person.code, 3)
    store.answer(
        study,
        person.code,
        3,
        Answer(measured_s=third.adaptation_s, shown_s=0.5, is_answered=False),
    )
    table = trials_table(store, study)
    assert tuple(table) == TRIAL_COLUMNS
    assert table["order"].tolist() == [1, 2, 3]
    assert table["position"].tolist() == [1, 2, 1]
    assert table["not_seen"].tolist() == [False, True, True]
    assert table["image"].tolist() == [PICTURES[t.picture].image for t in person.plan[:3]]
    assert table["device"].tolist() == [
        "touch",
        "mouse; marked: 0.12 s late, shown for 0.60 s",
        "marked: shown 2 times, no answer",
    ]
    lines = to_csv_bytes(table).decode().splitlines()
    assert lines[0] == (
        "subject,run,position,order,image,pedestrian,adaptation_asked_s,adaptation_measured_s,"
        "touch_x,touch_y,response_s,not_seen,device"
    )
    assert lines[1].startswith(f"{person.code},1,1,1,{PICTURES[first.picture].image},p,")
    assert lines[1].endswith(",12.5,9,0.8,0,touch")
    people = participants_table(store, study)
    assert people[["n_trials", "n_answered", "n_marked"]].to_numpy().tolist() == [[6, 3, 2]]


def test_a_participants_record_is_exported_and_deleted_and_nobody_elses(store, study, tmp_path):
    ann, bob = (store.join(study, {"vision": f"the eyes of {name}"}) for name in ("Ann", "Bob"))
    for person in (ann, bob):
        store.note_showing(study, person.code, 1)
        store.answer(study, person.code, 1, SEEN)
    record = json.loads(json.dumps(store.record(study, ann.code.lower()), allow_nan=False))
    assert record["code"] == ann.code
    assert record["form"][0]["answers"] == {"vision": "the eyes of Ann"}
    assert [trial["touch_x"] for trial in record["trial"]] == [12.5]
    assert [showing["n"] for showing in record["showing"]] == [1]
    assert "Bob" not in str(record)
    assert store.delete(study, ann.code.lower())
    assert not store.delete(study, ann.code)
    assert store.record(study, ann.code) is None
    assert trials_table(store, study)["subject"].tolist() == [bob.code]
    content = (tmp_path / "new" / "studies.sqlite").read_bytes()
    assert b"eyes of Ann" not in content
    assert ann.code.encode() not in content
    assert store.join(study, {}).number == ann.number  # the design stays balanced


def test_a_study_ends_with_all_answers_when_its_time_is_over(tmp_path):
    path, begin = tmp_path / "studies.sqlite", datetime(2026, 1, 1, tzinfo=UTC)
    store = DetectabilityStore(path, now=begin)
    short, long = (
        store.begin(StudySettings(keep_days=days), PICTURES, folder="sample", now=begin)
        for days in (10, 11)
    )
    for study in (short, long):
        store.answer(study, store.join(study, {}).code, 1, SEEN)
    assert short.ends_at == begin + timedelta(days=10)
    almost = DetectabilityStore(path, now=begin + timedelta(days=9.9))
    assert almost.study(short.token) is not None
    after = DetectabilityStore(path, now=begin + timedelta(days=10))
    assert after.study(short.token) is None
    assert after.participants(short) == []
    assert after.answers(short) == {}
    assert len(after.answers(long)) == 1


def test_practice_is_remembered(store, study):
    person = store.join(study, {})
    store.end_practice(study, person.code)
    again = store.participant(study, person.code)
    assert (person.has_practised, again.has_practised) == (False, True)


def test_strangers_and_what_was_not_asked_are_refused(store, study):
    person = store.join(study, {})
    with pytest.raises(InputError, match="nobody takes part"):
        store.answer(study, "nobody", 1, SEEN)
    for place in (0, 7):
        with pytest.raises(InputError, match=f"no trial {place}"):
            store.note_showing(study, person.code, place)
    with pytest.raises(InputError, match="no field height"):
        store.join(study, {"height": "2 m"})
    with pytest.raises(InputError, match="2,000 characters"):
        store.join(study, {"age": "9" * 2001})
    assert len(store.participants(study)) == 1
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
    person = store.join(study, {})
    beside = Answer(**{**vars(SEEN), "touch_x": place[0], "touch_y": place[1]})
    with pytest.raises(InputError, match=r"outside the picture \(40 x 30 px\)"):
        store.answer(study, person.code, 1, beside)
    assert store.answers(study) == {}
    corner = Answer(**{**vars(SEEN), "touch_x": 39.9, "touch_y": 0})
    store.answer(study, person.code, 1, corner)
    assert store.answers(study)[person.code][1][0] == corner


def test_an_answer_to_a_picture_that_was_never_reported_as_shown_is_marked(store, study):
    person = store.join(study, {})
    time_s = person.plan[0].adaptation_s
    store.answer(study, person.code, 1, Answer(**{**vars(SEEN), "measured_s": time_s}))
    assert trials_table(store, study)["device"].tolist() == [
        "touch; marked: never reported as shown"
    ]
    assert participants_table(store, study)["n_marked"].tolist() == [1]


def test_many_join_at_once_and_all_rows_of_the_design_are_taken(store, study):
    with ThreadPoolExecutor(8) as pool:
        people = list(pool.map(lambda _: store.join(study, {}), range(12)))
    assert sorted(person.number for person in people) == list(range(12))


def test_there_is_room_for_so_many_and_no_more(store, study, monkeypatch):
    monkeypatch.setattr("nvcore.driver.study.store.MOST_PARTICIPANTS", 2)
    monkeypatch.setattr("nvcore.driver.study.store.MOST_STUDIES", 2)
    for _ in range(2):
        store.join(study, {})
    with pytest.raises(InputError, match="2 participants already"):
        store.join(study, {})
    assert len(store.participants(study)) == 2
    store.begin(StudySettings(), PICTURES, folder="sample")
    with pytest.raises(InputError, match="2 studies already"):
        store.begin(StudySettings(), PICTURES, folder="sample")


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


def test_the_progress_of_a_study_counts_who_has_seen_all_and_the_trials(store, study):
    assert advance_of(participants_table(store, study)) == Advance(0, 0, 0, 0)
    for n in (6, 2, 0):
        person = store.join(study, {})
        for trial in person.plan[:n]:
            store.note_showing(study, person.code, trial.order)
            measured_s = trial.adaptation_s + (0.2 if trial.order == 1 else 0.01)
            answer = Answer(measured_s=measured_s, shown_s=0.5)
            store.answer(study, person.code, trial.order, answer)
    assert advance_of(participants_table(store, study)) == Advance(
        n_participants=3, n_finished=1, n_trials=8, n_marked=2
    )


def test_tables_without_anybody_have_their_columns(store, study):
    assert tuple(trials_table(store, study)) == TRIAL_COLUMNS
    assert participants_table(store, study).columns[-1] == "1. Glasses?"
