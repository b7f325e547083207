"""Rating sessions: orders that are balanced, ratings that outlive everything."""

import signal
import sqlite3
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from datetime import UTC, datetime, timedelta

import pytest

from nvcore.errors import InputError
from nvcore.output.csv_text import to_csv_bytes
from nvcore.ratings.reading import read_ratings
from nvcore.ratings.store import FORM, Clip, RatingStore
from nvcore.ratings.worth import Alert

CLIPS = (("A", "FIR"), ("B", "FIR"), ("A", "NIR"), ("B", "NIR"))


@pytest.fixture
def store(tmp_path):
    return RatingStore(tmp_path / "new" / "ratings.sqlite")


def test_each_participant_keeps_their_own_order(store):
    study = store.begin("print", CLIPS)
    orders = [store.order(study, name) for name in ("P1", "P2", "P3", "P4")]
    assert sorted(orders[0]) == [0, 1, 2, 3]
    assert len({tuple(order) for order in orders}) == 4
    assert store.order(study, " P2 ") == orders[1]


def test_a_rating_is_there_after_the_program_is_killed(tmp_path):
    path = tmp_path / "ratings.sqlite"
    code = f"""
import os, signal
from pathlib import Path
from nvcore.ratings.store import RatingStore
store = RatingStore(Path({str(path)!r}))
study = store.begin("print", {CLIPS!r})
clip = store.order(study, "P1")[0]
store.rate(study, "P1", clip, 6)
print(study.token, clip, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert ended.returncode == -signal.SIGKILL, ended.stderr
    token, clip = ended.stdout.split()
    store = RatingStore(path)
    study = store.study(token)
    assert study is not None
    assert study.clips == tuple(Clip(*clip) for clip in CLIPS)
    assert store.ratings_of(study, "P1") == {int(clip): 6}


def test_the_table_is_what_a_file_of_it_gives(store, tmp_path):
    study = store.begin("print", CLIPS)
    for name in ("P2", "P1"):
        store.order(study, name)
        for clip in (2, 0):
            store.rate(study, name, clip, 1 + clip)
    store.rate(study, "P1", 0, 7)  # thought again
    table = store.ratings(study)
    shown = table[["participant", "clip", "system", "rating"]]
    assert shown.to_numpy().tolist() == [
        ["P2", "A", "FIR", 1.0], ["P2", "A", "NIR", 3.0],
        ["P1", "A", "FIR", 7.0], ["P1", "A", "NIR", 3.0],
    ]  # fmt: skip
    path = tmp_path / "ratings.csv"
    path.write_bytes(to_csv_bytes(table))
    assert read_ratings(path).equals(shown)


def test_studies_do_not_see_each_other(store):
    first, second = store.begin("print", CLIPS), store.begin("print", CLIPS)
    store.order(first, "P1")
    store.rate(first, "P1", 0, 3)
    assert len(store.ratings(first)) == 1
    assert len(store.ratings(second)) == 0
    assert store.study("x' OR '1'='1") is None


def test_many_join_and_rate_at_once(store):
    study = store.begin("print", CLIPS)

    def rate_all(number):
        for clip in store.order(study, f"P{number}"):
            store.rate(study, f"P{number}", clip, 1 + clip)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(rate_all, range(8)))
        orders = list(pool.map(lambda name: store.order(study, name), ["Anna", "anna", "ANNA"]))
    assert len(store.ratings(study)) == 32
    assert orders == [orders[0]] * 3
    assert len(store.participants(study)) == 9


@pytest.mark.parametrize(
    ("clip", "rating", "words"), [(4, 3, "clip 5"), (0, 8, "1 to 7"), (0, 0, "given 0")]
)
def test_what_is_not_on_the_scale_is_refused(store, clip, rating, words):
    study = store.begin("print", CLIPS)
    store.order(study, "P1")
    with pytest.raises(InputError, match=words):
        store.rate(study, "P1", clip, rating)
    assert store.ratings_of(study, "P1") == {}


def test_strangers_empty_names_and_empty_studies_are_refused(store):
    study = store.begin("print", CLIPS)
    with pytest.raises(InputError, match="has not joined"):
        store.rate(study, "nobody", 0, 3)
    with pytest.raises(InputError, match="1 to 64"):
        store.order(study, "  ")
    with pytest.raises(InputError, match="each once"):
        store.begin("print", [])
    with pytest.raises(InputError, match="must rise"):
        store.begin("print", CLIPS, low=7, high=7)


def test_the_file_is_nobody_elses(store, tmp_path):
    assert (tmp_path / "new").stat().st_mode & 0o077 == 0


def test_the_conductors_name_is_not_the_participants(store):
    study = store.begin("print", CLIPS, thresholds={"FIR": 0.4, "NIR": None})
    assert store.study(study.token) == store.study_of_conductor(study.conductor) == study
    assert store.study_of_conductor(study.token) is None
    assert store.study(study.conductor) is None


def test_progress_counts_who_has_rated_nothing_too(store):
    study, other = store.begin("print", CLIPS), store.begin("print", CLIPS)
    for name in ("Zoe", "Ann"):
        store.order(study, name)
    store.order(other, "Bob")
    store.rate(study, "Ann", 2, 3)
    assert store.participants(study).to_numpy().tolist() == [["Zoe", 0], ["Ann", 1]]


def test_a_file_that_is_no_database_is_told(tmp_path):
    path = tmp_path / "ratings.sqlite"
    path.write_bytes(b"something else entirely " * 100)
    with pytest.raises(InputError, match="file of the ratings cannot be used"):
        RatingStore(path)
    assert path.read_bytes().startswith(b"something else")
    with pytest.raises(InputError, match="folder of the ratings cannot be made"):
        RatingStore(path / "below" / "ratings.sqlite")


def test_an_empty_table_has_the_columns_and_kinds_of_a_full_one(store):
    empty = store.ratings(study := store.begin("print", CLIPS))
    store.order(study, "P1")
    store.rate(study, "P1", 0, 3)
    assert len(empty) == 0
    assert empty.dtypes.to_dict() == store.ratings(study).dtypes.to_dict()


def test_a_changed_rating_tells_the_first_one_and_plays_add_up(store):
    study = store.begin("print", CLIPS)
    store.order(study, "P1")
    for rating, n_plays in ((5, 2), (5, None), (3, 1), (4, 0)):
        store.rate(study, "P1", 0, rating, n_plays=n_plays)
    store.rate(study, "P1", 1, 6)
    ratings = store.ratings(study)
    assert ratings["rating"].tolist() == [4, 6]
    assert ratings["first_rating"].to_list()[0] == 5
    assert ratings["n_plays"].to_list()[0] == 3
    assert ratings[["n_plays", "first_rating"]].isna().to_numpy()[1].all()


def test_names_in_other_capitals_are_one_participant(store):
    study = store.begin("print", CLIPS)
    order = store.order(study, "Anna")
    assert store.order(study, "Bob") != order
    assert store.order(study, " ANNA ") == order
    store.rate(study, "anna", 2, 4)
    assert store.ratings_of(study, "aNNa") == {2: 4}
    assert store.participants(study).to_numpy().tolist() == [["Anna", 1], ["Bob", 0]]


def test_a_file_of_an_earlier_version_is_gone_on_with(store, tmp_path):
    study = store.begin("print", CLIPS)
    for name in ("Anna", "Bob"):
        store.order(study, name)
        store.rate(study, name, 0, 3)
    path = tmp_path / "new" / "ratings.sqlite"
    with closing(sqlite3.connect(path)) as base, base:
        for column in ("n_plays", "first_rating"):
            base.execute(f"ALTER TABLE rating DROP COLUMN {column}")
        for column in ("consent", "ends_at"):
            base.execute(f"ALTER TABLE study DROP COLUMN {column}")
        base.execute("DROP TABLE consent")
        for table in ("participant", "rating"):  # two spellings, which were two people then
            column = "name" if table == "participant" else "participant"
            base.execute(f"UPDATE {table} SET {column} = 'anna' WHERE {column} = 'Bob'")
    again = RatingStore(path)
    known = again.study(study.token)
    assert known is not None
    assert (known.consent, known.ends_at) == ("", None)  # nobody was asked, and it does not end
    assert again.may_rate(known, "anna")
    again.rate(study, "anna", 0, 5, n_plays=1)
    ratings = again.ratings(study)
    assert ratings["participant"].tolist() == ["Anna", "anna"]
    assert ratings["rating"].tolist() == [3, 5]
    assert ratings["n_plays"].isna().tolist() == [True, False]
    assert RatingStore(path).ratings(study).equals(ratings)


NOW = datetime(2026, 3, 1, tzinfo=UTC)


def test_who_has_not_agreed_to_the_text_may_not_rate_yet(store):
    study = store.begin("print", CLIPS, consent="We keep your ratings.")
    assert store.study(study.token) == study
    store.order(study, "Ann")
    assert not store.may_rate(study, "Ann")
    store.agree(study, "Ann", now=NOW)
    store.agree(study, " ann ")  # a second time changes nothing
    assert store.may_rate(study, "ANN")
    assert store.record(study, "Ann")["consent"] == [{"consented_at": NOW.isoformat()}]
    assert store.may_rate(store.begin("print", CLIPS), "Eve")  # no text, nothing to agree to


def test_a_participant_s_data_are_given_out_and_deleted(store):
    study = store.begin("print", CLIPS, consent="We keep your ratings.")
    for name in ("Ann", "Bob"):
        store.agree(study, name)
        store.rate(study, name, 2, 4, n_plays=1)
    record = store.record(study, "ann")
    assert record["participant"] == "Ann"
    assert len(record["rating"]) == 1
    rating = record["rating"][0]
    assert rating["clip"] == {"recording": "A", "system": "NIR"}
    assert (rating["rating"], rating["n_plays"]) == (4, 1)
    assert store.delete(study, "ANN")
    assert store.record(study, "Ann") is None
    assert not store.delete(study, "Ann")
    assert store.participants(study)["participant"].tolist() == ["Bob"]
    assert len(store.ratings(study)) == 1
    assert not store.may_rate(study, "Ann")


def test_a_session_is_deleted_with_all_ratings_when_its_days_are_over(tmp_path):
    path = tmp_path / "ratings.sqlite"
    store = RatingStore(path, now=NOW)
    study = store.begin("print", CLIPS, consent="Yes.", keep_days=10, now=NOW)
    other = store.begin("print", CLIPS, keep_days=11, now=NOW)
    assert study.ends_at == NOW + timedelta(days=10)
    store.agree(study, "Ann")
    store.rate(study, "Ann", 0, 3)
    assert RatingStore(path, now=NOW + timedelta(days=9)).study(study.token) == study
    after = RatingStore(path, now=NOW + timedelta(days=10))
    assert after.study(study.token) is None
    assert after.study(other.token) == other
    assert after.ratings(study).empty


@pytest.mark.parametrize(
    ("terms", "words"),
    [({"consent": " "}, "the text of consent has 1 to"), ({"keep_days": 0}, "kept 1 to 3650 days")],
)
def test_terms_that_cannot_be_are_refused(store, terms, words):
    with pytest.raises(InputError, match=words):
        store.begin("print", CLIPS, **terms)


def test_stretches_alerts_and_form_are_kept_and_deleted_with_their_participant(store):
    stretch = Clip("A", "FIR", 5.0, 20.0, "encounter 3")
    alert = Alert("A", "FIR", 7.5, 8.0, "needed")
    study = store.begin("print", [stretch, ("B", "FIR")], alerts=[alert], questions=["Shoe size"])
    assert store.study(study.token) == study
    assert [*study.form] == [*FORM, "1. Shoe size"]
    for name in ("Ann", "Bob"):
        store.order(study, name)
        store.rate(study, name, 0, 3)
        store.judge(study, name, 0, "no")
    store.fill_in(study, "ann", {"age": "41", "1. Shoe size": "39"})
    store.fill_in(study, "ann", {"age": "14"})  # what was said first stays
    store.judge(study, "ann", 0, "yes")
    ratings = store.ratings(study)
    assert ratings["clip"].tolist() == ["A [5-20 s]"] * 2
    assert ratings.loc[0, ["recording", "start_s", "end_s", "reason"]].tolist() == [
        "A", 5.0, 20.0, "encounter 3",
    ]  # fmt: skip
    assert store.forms(study).iloc[:, [0, 1, 5]].to_numpy().tolist() == [
        ["Ann", "41", "39"], ["Bob", "", ""],
    ]  # fmt: skip
    worth = store.worth(study).set_index("participant")
    assert worth["answer"].to_dict() == {"Ann": "yes", "Bob": "no"}
    assert tuple(worth.loc["Ann", [*Alert._fields]]) == alert
    record = store.record(study, "Ann")
    assert record["rating"][0]["clip"]["reason"] == "encounter 3"
    assert record["worth"][0]["alert"]["kind"] == "needed"
    assert {row["field"]: row["answer"] for row in record["form"]}["age"] == "41"
    store.delete(study, "Ann")
    assert store.worth(study)["participant"].tolist() == ["Bob"]
    assert store.forms(study)["participant"].tolist() == ["Bob"]
    for wrong in ({"answer": "maybe"}, {"alert": 1}, {"participant": "Eve"}):
        with pytest.raises(InputError, match=r"an answer is|there is no alert|has not joined"):
            store.judge(study, **{"participant": "Bob", "alert": 0, "answer": "no"} | wrong)
    with pytest.raises(InputError, match="the form has no field"):
        store.fill_in(study, "Bob", {"name": "Robert"})
