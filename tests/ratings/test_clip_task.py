"""Rating sessions: what is kept of clips, alerts and forms, and files of earlier versions."""

import sqlite3
from contextlib import closing
from datetime import UTC, datetime

import pytest

from nvcore.common.errors import InputError
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.subjects.ratings.clip_task import FORM, Clip, RatingStore, Shown
from nvcore.subjects.ratings.reading import read_ratings
from nvcore.subjects.ratings.worth import Alert

CLIPS = (("A", "FIR"), ("B", "FIR"), ("A", "NIR"), ("B", "NIR"))
ALERT = Alert("A", "FIR", 7.5, 8.0, "needed")


@pytest.fixture
def store(tmp_path):
    return RatingStore(tmp_path / "ratings.sqlite")


@pytest.fixture
def study(store):
    return store.begin("print", CLIPS, thresholds={"FIR": 0.4, "NIR": None})


def join(store, study, *names):
    return [store.join(study, {}, name=name)[0] for name in names]


def test_each_participant_sees_the_clips_in_an_order_of_their_own_then_the_alerts(store):
    study = store.begin("print", CLIPS, alerts=[ALERT, ALERT._replace(end_s=9.0)])
    people = join(store, study, "P1", "P2", "P3", "P4")
    clips = [[shown.place for shown in of.plan if shown.table == "rating"] for of in people]
    assert sorted(clips[0]) == [0, 1, 2, 3]
    assert len({tuple(order) for order in clips}) == 4
    assert people[1].plan[4:] == (Shown("worth", 1), Shown("worth", 0))
    for clip in range(4):
        store.rate(study, "P2", clip, 3)
    assert store.left(study, people[1]) == [*people[1].plan[4:]]
    store.judge(study, "P2", 1, "no")
    assert store.left(study, people[1]) == [Shown("worth", 0)]


def test_the_table_is_what_a_file_of_it_gives(store, study, tmp_path):
    empty = store.ratings(study)
    for name in ("P2", "P1"):
        join(store, study, name)
        for clip in (2, 0):
            store.rate(study, name, clip, 1 + clip)
    store.rate(study, "P1", 0, 7)  # thought again
    table = store.ratings(study)
    assert table.dtypes.to_dict() == empty.dtypes.to_dict()
    shown = table[["participant", "clip", "system", "rating"]]
    assert shown.to_numpy().tolist() == [
        ["P2", "A", "FIR", 1.0], ["P2", "A", "NIR", 3.0],
        ["P1", "A", "FIR", 7.0], ["P1", "A", "NIR", 3.0],
    ]  # fmt: skip
    path = tmp_path / "ratings.csv"
    path.write_bytes(to_csv_bytes(table))
    assert read_ratings(path).equals(shown)
    assert store.ratings(store.begin("print", CLIPS)).empty
    assert store.record(study, store.find(study, "P1"))["consent"] == []  # there is no text


def test_what_is_not_on_the_scale_is_refused(store):
    study = store.begin("print", CLIPS, alerts=[ALERT])
    join(store, study, "P1")
    for clip, rating, words in (
        (4, 3, "clip 5"),
        (-1, 3, "clip 0"),
        (0, 8, "1 to 7"),
        (0, 0, "given 0"),
    ):
        with pytest.raises(InputError, match=words):
            store.rate(study, "P1", clip, rating)
    for alert, answer, words in ((1, "no", "no alert 2"), (0, "maybe", "an answer is")):
        with pytest.raises(InputError, match=words):
            store.judge(study, "P1", alert, answer)
    assert store.ratings_of(study, "P1") == {}
    assert store.worth(study).empty


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"clips": []}, "1 to 500 clips, each once"),
        ({"clips": [("A", "FIR")] * 2}, "1 to 500 clips, each once"),
        ({"low": 7}, "must rise"),
        ({"alerts": [ALERT] * 501}, "500 alerts at most; got 501"),
        ({"consent": " "}, "the text of consent has 1 to"),
        ({"keep_days": 0}, "kept 1 to 3650 days"),
        ({"questions": ["a", "a"]}, "the same"),
    ],
)
def test_sessions_that_cannot_be_are_refused(store, wrong, words):
    with pytest.raises(InputError, match=words):
        store.begin("print", **{"clips": CLIPS, **wrong})


def test_a_changed_rating_tells_the_first_one_and_plays_add_up(store, study):
    join(store, study, "P1")
    for rating, n_plays in ((5, 2), (5, None), (3, 1), (4, 0)):
        store.rate(study, "P1", 0, rating, n_plays=n_plays)
    store.rate(study, "P1", 1, 6)
    ratings = store.ratings(study)
    assert ratings["rating"].tolist() == [4, 6]
    assert ratings["first_rating"].to_list()[0] == 5
    assert ratings["n_plays"].to_list()[0] == 3
    assert ratings[["n_plays", "first_rating"]].isna().to_numpy()[1].all()


def test_stretches_alerts_and_form_are_kept_and_deleted_with_their_participant(store):
    stretch = Clip("A", "FIR", 5.0, 20.0, "encounter 3")
    study = store.begin("print", [stretch, ("B", "FIR")], alerts=[ALERT], questions=["Shoe size"])
    assert store.study(study.token) == study
    assert [*study.form] == [*FORM, "1. Shoe size"]
    ann, _ = store.join(study, {"age": "41", "1. Shoe size": "39"}, name="Ann")
    join(store, study, "Zoe", "Bob")
    for name in ("Ann", "Bob"):
        store.rate(study, name, 0, 3)
        store.judge(study, name, 0, "no")
    store.judge(study, "Ann", 0, "yes")
    assert store.progress(study).to_numpy().tolist() == [
        ["Ann", 1, 1], ["Zoe", 0, 0], ["Bob", 1, 1],
    ]  # fmt: skip
    ratings = store.ratings(study)
    assert ratings["clip"].tolist() == ["A [5-20 s]"] * 2
    assert ratings.loc[0, ["recording", "start_s", "end_s", "reason"]].tolist() == [
        "A", 5.0, 20.0, "encounter 3",
    ]  # fmt: skip
    assert store.forms(study).iloc[:, [0, 1, 5]].to_numpy().tolist() == [
        ["Ann", "41", "39"], ["Zoe", "", ""], ["Bob", "", ""],
    ]  # fmt: skip
    worth = store.worth(study).set_index("participant")
    assert worth["answer"].to_dict() == {"Ann": "yes", "Bob": "no"}
    assert tuple(worth.loc["Ann", [*Alert._fields]]) == ALERT
    record = store.record(study, ann)
    assert record["rating"][0]["clip"]["reason"] == "encounter 3"
    assert record["worth"][0]["alert"]["kind"] == "needed"
    assert {row["field"]: row["answer"] for row in record["form"]}["age"] == "41"
    store.delete(study, ann)
    assert store.worth(study)["participant"].tolist() == ["Bob"]
    assert store.forms(study)["participant"].tolist() == ["Zoe", "Bob"]


# Written by the version before personal codes (SQL of its file).
EARLIER = """
CREATE TABLE consent (
    study TEXT NOT NULL, participant TEXT NOT NULL, consented_at TEXT NOT NULL,
    PRIMARY KEY (study, participant),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
INSERT INTO "consent" VALUES('rating-token','Anna','2026-03-01T00:00:00+00:00');
INSERT INTO "consent" VALUES('rating-token','Bob','2026-03-01T00:00:00+00:00');
CREATE TABLE form (
    study TEXT NOT NULL, participant TEXT NOT NULL, field TEXT NOT NULL, answer TEXT NOT NULL,
    PRIMARY KEY (study, participant, field),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
INSERT INTO "form" VALUES('rating-token','Anna','age','41');
INSERT INTO "form" VALUES('rating-token','Anna','1. Shoe size','39');
CREATE TABLE participant (
    study TEXT NOT NULL REFERENCES study, name TEXT NOT NULL, number INTEGER NOT NULL,
    PRIMARY KEY (study, name), UNIQUE (study, number));
INSERT INTO "participant" VALUES('rating-token','Anna',0);
INSERT INTO "participant" VALUES('rating-token','Bob',1);
INSERT INTO "participant" VALUES('rating-token','CEM',2);
CREATE TABLE rating (
    study TEXT NOT NULL, participant TEXT NOT NULL, clip INTEGER NOT NULL, rating INTEGER NOT NULL,
    rated_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP, n_plays INTEGER, first_rating INTEGER,
    PRIMARY KEY (study, participant, clip),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
INSERT INTO "rating" VALUES('rating-token','Anna',0,5,'2026-03-02 10:28:51',3,3);
INSERT INTO "rating" VALUES('rating-token','Anna',1,2,'2026-03-02 10:28:51',NULL,NULL);
INSERT INTO "rating" VALUES('rating-token','Bob',1,6,'2026-03-02 10:28:51',NULL,NULL);
CREATE TABLE study (
    token TEXT PRIMARY KEY, conductor TEXT NOT NULL UNIQUE, fingerprint TEXT NOT NULL,
    clips TEXT NOT NULL, low INTEGER NOT NULL, high INTEGER NOT NULL,
    thresholds TEXT NOT NULL, consent TEXT NOT NULL DEFAULT '', ends_at TEXT,
    alerts TEXT NOT NULL DEFAULT '[]', form TEXT NOT NULL DEFAULT '{}');
INSERT INTO "study" VALUES('rating-token','rating-conductor','print',
    '[["A", "FIR", 5.0, 20.0, "encounter 3"], ["B", "NIR", null, null, ""]]',1,7,
    '{"FIR": 0.4, "NIR": null}','Yes.','2027-03-01T00:00:00+00:00',
    '[["A", "FIR", 7.5, 8.0, "needed"]]',
    '{"age": "Age in years", "sex": "Sex", "licence": "Driving licence", '
    || '"night_driving": "Driving at night", "1. Shoe size": "Shoe size"}');
CREATE TABLE worth (
    study TEXT NOT NULL, participant TEXT NOT NULL, alert INTEGER NOT NULL, answer TEXT NOT NULL,
    answered_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP,
    PRIMARY KEY (study, participant, alert),
    FOREIGN KEY (study, participant) REFERENCES participant (study, name));
INSERT INTO "worth" VALUES('rating-token','Anna',0,'yes','2026-03-02 10:28:51');
"""


@pytest.fixture
def earlier(tmp_path):
    """A file of an earlier version: Anna has done all, Bob half, Cem has not agreed."""
    path = tmp_path / "earlier.sqlite"
    with closing(sqlite3.connect(path)) as base:
        base.executescript(EARLIER)
    return path


def test_a_session_of_an_earlier_version_opens_with_all_that_it_has(earlier):
    store = RatingStore(earlier, now=datetime(2026, 4, 1, tzinfo=UTC))
    study = store.study("rating-token")
    assert store.study_of_conductor("rating-conductor") == study
    assert study.clips == (Clip("A", "FIR", 5.0, 20.0, "encounter 3"), Clip("B", "NIR"))
    assert (study.thresholds, study.alerts) == ({"FIR": 0.4, "NIR": None}, (ALERT,))
    assert study.ends_at == datetime(2027, 3, 1, tzinfo=UTC)
    assert to_csv_bytes(store.ratings(study)).decode().splitlines() == [
        "participant,clip,system,rating,n_plays,first_rating,recording,start_s,end_s,reason",
        "Anna,A [5-20 s],FIR,5,3,3,A,5,20,encounter 3",
        "Anna,B,NIR,2,,,B,,,",
        "Bob,B,NIR,6,,,B,,,",
    ]
    assert to_csv_bytes(store.forms(study)).decode().splitlines()[1:] == [
        "Anna,41,,,,39", "Bob,,,,,", "CEM,,,,,",
    ]  # fmt: skip
    assert store.worth(study)["answer"].tolist() == ["yes"]
    anna = store.find(study, "anna")
    assert store.record(study, anna)["consent"] == [{"consented_at": "2026-03-01T00:00:00+00:00"}]
    assert RatingStore(earlier, now=datetime(2027, 3, 1, tzinfo=UTC)).study("rating-token") is None


def test_participants_of_an_earlier_version_go_on_by_a_code_of_the_conductor_alone(earlier):
    store = RatingStore(earlier, now=datetime(2026, 4, 1, tzinfo=UTC))
    study = store.study("rating-token")
    assert store.by_code(study, "Bob") is store.by_code(study, "CEM") is None  # no name does
    bob = store.by_code(study, store.new_code(study, store.find(study, "bob")))
    assert store.left(study, bob) == [Shown("rating", 0), Shown("worth", 0)]
    store.rate(study, bob.name, 0, 3)
    with pytest.raises(InputError, match="takes part already"):
        store.join(study, {}, name="BOB")
    with pytest.raises(InputError, match="CEM has not agreed"):
        store.new_code(study, store.find(study, "Cem"))
    store.delete(study, store.find(study, "Cem"))
    cem, code = store.join(study, {}, name="Cem")
    assert (cem.number, store.by_code(study, code)) == (2, cem)
    again = RatingStore(earlier, now=datetime(2026, 4, 2, tzinfo=UTC))
    assert again.by_code(study, code) == cem


def test_the_first_files_of_all_are_gone_on_with(earlier):
    with closing(sqlite3.connect(earlier)) as base, base:
        for column in ("n_plays", "first_rating"):
            base.execute(f"ALTER TABLE rating DROP COLUMN {column}")
        for column in ("consent", "ends_at", "alerts", "form"):
            base.execute(f"ALTER TABLE study DROP COLUMN {column}")
        for table in ("consent", "form", "worth"):
            base.execute(f"DROP TABLE {table}")
        for table in ("participant", "rating"):  # two spellings, which were two people then
            column = "name" if table == "participant" else "participant"
            base.execute(f"UPDATE {table} SET {column} = 'anna' WHERE {column} = 'Bob'")
    store = RatingStore(earlier)
    study = store.study("rating-token")
    assert (study.consent, study.ends_at) == ("", None)  # nobody was asked, and it does not end
    anna = store.by_code(study, store.new_code(study, store.find(study, "anna")))
    assert anna.number == 1
    store.rate(study, anna.name, 1, 4, n_plays=1)
    ratings = RatingStore(earlier).ratings(study)
    assert ratings["participant"].tolist() == ["Anna", "Anna", "anna"]
    assert ratings["rating"].tolist() == [5, 2, 4]
    assert ratings["n_plays"].isna().tolist() == [True, True, False]
    assert ratings["first_rating"].to_list()[2] == 6
