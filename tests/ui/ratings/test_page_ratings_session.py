"""Rating sessions on the Ratings page, driven without a browser."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from ratings_page import keys, metrics, only, opened, show_source, table, warnings, words
from streamlit.testing.v1 import AppTest

from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.alerts.steps import alerts_in
from nvcore.subjects.ratings.clip_task import Clip, RatingStore, RatingStudy, Shown
from nvcore.subjects.ratings.worth import read_alerts
from pages import alone, begin_with, checked, part, press, rows, write
from ui.session import state
from ui.session.store import RATING_ALERTS
from ui.subjects.people import conduct
from ui.subjects.ratings import clip_screen, source
from ui.widgets import viewer

STRANGE = "there is no rating session of the name in the address"


@pytest.fixture(autouse=True)
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RatingStore:
    """The file of the ratings; whoever rates has seen each clip to its end."""
    monkeypatch.setattr(clip_screen, "viewer", lambda **of: of["rows"][-1])
    monkeypatch.setenv("NVCORE_RATINGS", str(tmp_path / "kept" / "ratings.sqlite"))
    return RatingStore(tmp_path / "kept" / "ratings.sqlite")


def drawn(side: str) -> tuple[str, str]:
    return (
        "from ui.subjects.ratings import sessions",
        f"ui.subjects.people.{side}.draw(sessions.SESSIONS)",
    )


def joined(store: RatingStore, study: RatingStudy, name: str) -> str:
    """Let somebody take part; their code."""
    return store.join(study, {}, name=name)[1]


def conducting(**address: str) -> AppTest:
    return checked(part(*drawn("conduct"), **address).run())


def rating(study: RatingStudy, **address: str) -> AppTest:
    """What a participant sees."""
    return checked(part(*drawn("participant"), study=study.token, **address).run())


def begun(
    store: RatingStore, *recordings: str, page: AppTest | None = None, whose: str = "both"
) -> RatingStudy:
    """Begin a rating session."""
    page = page or conducting()
    page.multiselect(key="rating_recordings").set_value(list(recordings))
    page.button_group(key="rating_whose").set_value(whose)
    press(page, "rating_start")
    study = store.study_of_conductor(only(page, "conduct"))
    assert study is not None
    return study


def test_a_rating_session_has_an_address_for_each_side_and_opens_again_by_it(store: RatingStore):
    page = conducting(threshold_x="0.7")
    page.multiselect(key="rating_recordings").set_value([]).run()
    assert "needs 1 to 500 clips" in words(press(page, "rating_start"))
    study = begun(store, "odd_pose", "rural_child", page=page, whose="NIR")
    addresses = [code.value for code in page.code]
    assert addresses[0].endswith(f"?study={study.token}")
    assert addresses[1].endswith(f"?conduct={study.conductor}")
    assert study.clips == (Clip("rural_child", "NIR"), Clip("odd_pose", "NIR"))
    assert study.thresholds == {"FIR": 0.7, "NIR": 0.5}
    assert metrics(page)["ratings so far"] == "0"
    press(page, "rating_close")
    assert not page.code
    assert "conduct" not in page.query_params
    assert conducting(conduct=study.conductor).code


def test_a_participant_sees_clips_only_and_every_rating_is_kept(
    store: RatingStore, monkeypatch: pytest.MonkeyPatch
):
    shown: list[tuple[int, str]] = []
    is_seen = False

    def seen(**of):
        shown.append((of["recording"], of["only"]))
        assert of["names"] == ("", "")
        return of["n_rows"] - 1 if is_seen else 0

    monkeypatch.setattr(clip_screen, "viewer", seen)
    study = begun(store, "odd_pose", "rural_child")
    page = rating(study)
    assert "FIR" not in words(page)
    page.text_input(key="rating_name").set_value(" Ann ")
    assert "Without your agreement nothing is kept" in words(page.button[0].click().run())
    assert store.participants(study) == []
    page.checkbox(key="rating_agrees").check()
    checked(page.button[0].click().run())
    code = only(page, "participant")
    ann = store.by_code(study, code)
    assert ann is not None
    assert ann.name == "Ann"
    assert f"Your code is {code}" in words(page)
    assert not page.button  # before the end of the clip there is nothing to press
    is_seen = True
    names = [recording.name for recording in read_session(state.SAMPLE).recordings]
    for number, (_, clip) in enumerate(ann.plan):
        page = rating(study, participant=code)  # as after a crash
        assert f"Clip {number + 1} of 4" in words(page)
        recording, system, *_ = study.clips[clip]
        assert shown[-1] == (names.index(recording), "x" if system == "FIR" else "y")
        scale = [part.key for part in page.button if part.key.startswith(f"rating_{clip}_")]
        assert scale == [f"rating_{clip}_{value}" for value in range(1, 8)]
        press(page, f"rating_{clip}_{number + 2}")
        assert store.ratings_of(study, "Ann")[clip] == number + 2
    assert page.title[0].value == "Thank you"


def test_the_conductor_comes_back_to_progress_and_to_the_thresholds_of_the_clips(
    store: RatingStore,
):
    study = begun(store, "odd_pose", "rural_child", "rural_road")
    for name, shift in (("Ann", 0), ("Bob", 1)):
        joined(store, study, name)
        for clip in range(6 - shift):
            store.rate(study, name, clip, 1 + clip)
    page = conducting(conduct=study.conductor)
    assert metrics(page) == {
        "participants": "2", "have rated all clips": "1", "ratings so far": "11",
    }  # fmt: skip
    assert table(page, "n_rated")["n_rated"].tolist() == [6, 5]
    call, address = "ui.subjects.ratings.source.choose(RESULT)", {"conduct": study.conductor}
    page = show_source(checked(part(call, **address, threshold_x="0.7").run()), source.SESSION)
    assert "X FIR: clips at 0.5, now 0.7." in warnings(page)
    press(page, "ratings_thresholds")
    assert page.session_state["params"].threshold_x == 0.5
    assert "clips at" not in warnings(page)
    assert "ratings_thresholds" not in keys(page)


def test_neither_participants_nor_strangers_see_the_ratings(store: RatingStore):
    study = begun(store, "odd_pose")
    for token in (study.token, "AAAAAAAAAAAAAAAAAAAAAA"):
        page = conducting(conduct=token)
        assert STRANGE in words(page)
        assert "conduct" not in page.query_params
        assert not page.code
    stranger = rating(replace(study, token="AAAAAAAAAAAAAAAAAAAAAA"))
    assert "leads to no rating session" in words(stranger)


def test_a_participant_with_another_comparison_open_goes_on_once_the_right_one_is(
    store: RatingStore, tmp_path: Path
):
    study = begun(store, "odd_pose")

    def be_of(fingerprint: str) -> None:
        with closing(sqlite3.connect(tmp_path / "kept" / "ratings.sqlite")) as base, base:
            base.execute("UPDATE study SET fingerprint = ?", (fingerprint,))

    code = joined(store, study, "Ann")
    be_of("of another dataset")
    page = checked(alone("ratings", study=study.token, participant=code).run())
    assert "about another comparison than the one that is open" in words(page)
    assert "study" not in page.query_params  # all of the app is there, so that it can be opened
    be_of(study.fingerprint)
    press(checked(page.run()), "rating_go_on")
    assert "Clip 1 of 2" in words(page)
    assert only(page, "participant") == code


def test_an_unusable_file_of_ratings_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "no.sqlite").write_bytes(b"this is no database, whatever its name says" * 40)
    monkeypatch.setenv("NVCORE_RATINGS", str(tmp_path / "no.sqlite"))
    page = press(conducting(), "rating_start")
    assert "the file of the ratings cannot be used" in words(page)


def test_a_participant_with_one_system_open_is_told(
    store: RatingStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    begin_with(write(tmp_path, {"one": ""}, truth=rows(300)), monkeypatch)
    study = store.begin("of another dataset", [("night", "FIR")])
    page = checked(alone("ratings", study=study.token).run())
    assert "about another comparison than the one that is open" in words(page)
    assert "A comparison needs two" in words(page)


def join(page: AppTest, name: str) -> None:
    page.text_input(key="rating_name").set_value(name)
    page.checkbox(key="rating_agrees").check()
    press(page, "rating_begin")


def test_the_conductors_screen_can_be_handed_to_others_and_taken_back_with_its_settings(
    store: RatingStore,
):
    study = begun(store, "odd_pose")
    address = {"conduct": study.conductor, "midpoint": "60", "threshold_x": "0.7"}
    page = checked(alone("ratings", **address).run())
    press(page, "rating_here")
    assert page.session_state["params"].threshold_x == study.thresholds["FIR"] == 0.5
    join(page, "Anna")
    press(page, "rating_0_5")
    press(page, "rating_1_5")
    code = only(page, "participant")
    assert f"Your code is {code}" in words(page)
    press(page, "rating_next")
    assert "participant" not in page.query_params
    page.text_input(key="rating_known_code").set_value(code.lower())
    press(page, "rating_continue")
    assert page.title[0].value == "Thank you"
    assert store.progress(study)["participant"].tolist() == ["Anna"]
    press(page, "rating_back")
    assert only(page, "conduct") == study.conductor
    assert metrics(page)["have rated all clips"] == "1"
    params = page.session_state["params"]
    assert (params.midpoint, params.threshold_x) == (60, 0.7)
    stranger = rating(study, participant=code)
    assert keys(stranger) == ["rating_change", "rating_next"]


def test_nobody_goes_on_as_another_person_by_a_name(store: RatingStore):
    study = begun(store, "odd_pose")
    joined(store, study, "Anna")
    store.rate(study, "Anna", 0, 5)
    for name in ("Anna", " anna"):
        page = rating(study, participant=name)
        assert "Nobody takes part in this rating session with the code in the address" in words(
            page
        )
        assert "rating_change" not in keys(page)
        page.text_input(key="rating_known_code").set_value(name)
        assert "with that code" in words(press(page, "rating_continue"))
    assert store.ratings_of(study, "Anna") == {0: 5}


def test_without_a_text_of_consent_there_is_nothing_to_agree_to(store: RatingStore):
    begun_before = begun(store, "odd_pose")
    study = store.begin(begun_before.fingerprint, begun_before.clips)
    page = rating(study)
    assert not page.checkbox
    page.text_input(key="rating_name").set_value("Ann")
    press(page, "rating_begin")
    assert "Clip 1 of 2" in words(page)


def test_a_second_form_under_one_name_is_refused_with_all_that_was_typed(store: RatingStore):
    page = conducting()
    checked(page.checkbox(key="rating_has_form").check().run())
    study = begun(store, "odd_pose", page=page)
    store.join(study, {"age": "60"}, name="Anna")
    page = rating(study)
    page.number_input(key="rating_form_0").set_value(31)
    join(page, "anna")
    assert "somebody called anna takes part already" in words(page)
    assert page.number_input(key="rating_form_0").value == 31
    join(page, "Anna K")  # the rest is still there
    assert store.forms(study)[["participant", "age"]].to_numpy().tolist() == [
        ["Anna", "60"], ["Anna K", "31"],
    ]  # fmt: skip


def test_the_last_rating_can_be_changed_which_is_recorded_with_how_often_it_was_played(
    store: RatingStore, monkeypatch: pytest.MonkeyPatch
):
    asked = []
    monkeypatch.setattr(clip_screen, "n_plays_in", lambda key: asked.append(key) or 3)
    study = begun(store, "odd_pose")
    page = rating(study)
    join(page, "Ann")
    assert "rating_change" not in keys(page)  # nothing is rated yet
    press(page, "rating_0_5")
    assert asked == ["clip_0_of_Ann"]
    press(page, "rating_change")
    assert "You gave it 5" in words(page)
    press(page, "rating_0_2")
    assert "Clip 2 of 2" in words(page)
    press(page, "rating_1_6")
    assert page.title[0].value == "Thank you"
    press(page, "rating_change")
    press(page, "rating_keep")
    assert page.title[0].value == "Thank you"
    kept = store.ratings(study)
    assert kept["rating"].tolist() == [2, 6]
    assert kept["first_rating"].to_list()[0] == 5
    assert kept["first_rating"].isna().tolist() == [False, True]
    assert kept["n_plays"].tolist() == [6, 3]  # of both ratings of the first
    page = part(*drawn("participant"), study=study.token, participant=joined(store, study, "Bob"))
    page.session_state["rating_changing"] = True  # as Ann may leave it
    assert "Clip 1 of 2" in words(checked(page.run()))


@pytest.mark.parametrize(
    ("told", "n_plays"),
    [
        ({"settled": {"row": 9, "n_plays": 2}}, 2),
        ({"settled": {"row": 9}}, None),
        ({"settled": None}, None),
        ({"settled": {"n_plays": "many"}}, None),
        (None, None),
    ],
)
def test_plays_are_those_that_the_browser_tells(
    told: object, n_plays: int | None, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(viewer.st, "session_state", {"clip": told})
    assert viewer.n_plays_in("clip") == n_plays


def test_a_participant_gets_a_new_code_or_is_deleted_on_request(store: RatingStore):
    page = conducting()
    study = begun(store, "odd_pose", page=page)
    assert study.ends_at is not None
    assert f"All ratings are deleted on {study.ends_at:%d %B %Y}" in words(page)
    codes = {name: joined(store, study, name) for name in ("Ann", "Bob")}
    for name in codes:
        store.rate(study, name, 0, 3)
    checked(page.text_input(key="rating_code").set_value("Eve").run())
    assert "Nobody with that name or code takes part" in words(page)
    checked(page.text_input(key="rating_code").set_value("ann").run())
    press(page, "rating_new_code")
    code = page.code[-1].value.rpartition("participant=")[2]
    assert f"Ann goes on with the code {code}" in words(page)
    assert "Clip 2 of 2" in words(rating(study, participant=code))
    assert "Nobody takes part" in words(rating(study, participant=codes["Ann"]))
    press(page, "rating_delete")
    assert store.progress(study)["participant"].tolist() == ["Bob"]
    assert page.text_input(key="rating_code").value == ""


def test_clips_are_cut_played_and_counted_one_by_one(
    store: RatingStore, monkeypatch: pytest.MonkeyPatch
):
    page = conducting()
    checked(page.button_group(key="rating_what").set_value("clips").run())
    page.number_input(key="rating_length_s").set_value(4.0)
    checked(page.number_input(key="rating_lead_s").set_value(1.0).run())
    names = ("odd_pose", "rural_child")
    study = begun(store, *names, page=page)
    assert all(clip.end_s - clip.start_s < 4.01 and clip.reason for clip in study.clips)
    assert len(study.clips) > 2 * len(names)
    shown = []

    def seen(**of):
        shown.append((of["rows"], of["seek"], of["n_rows"]))
        return of["rows"][-1]

    monkeypatch.setattr(clip_screen, "viewer", seen)
    number = next(i for i, clip in enumerate(study.clips) if clip.start_s)
    monkeypatch.setattr(RatingStore, "left", lambda *_: [Shown("rating", number)])
    code = joined(store, study, "Ann")
    joined(store, study, "Bob")
    press(rating(study, participant=code), f"rating_{number}_4")
    rows_shown, seek, n_rows = shown[0]
    assert seek == (rows_shown.start, 0)
    assert 0 < rows_shown.start < rows_shown.stop <= n_rows
    for person in ("Ann", "Bob"):
        for clip in range(person == "Bob", len(study.clips)):
            store.rate(study, person, clip, 1 + clip % 7)
    page = show_source(opened(conduct=study.conductor), source.SESSION)
    assert metrics(page)["clips"] == str(len(study.clips))
    assert metrics(page)["ratings missing"] == "1"
    ranked = table(page, "mean_rank")
    assert set(ranked["clip"]) == {clip.name for clip in study.clips}
    assert "not in this comparison" not in warnings(page)


def sent_alerts(page: AppTest, *lines: str) -> AppTest:
    checked(page.button_group(key=RATING_ALERTS.key).set_value("file").run())
    content = "\n".join(["recording,system,start_s,end_s,kind", *lines]).encode()
    field = page.file_uploader(key="rating_alerts")
    return checked(field.set_value(("a.csv", content, "text/csv")).run())


def test_the_alerts_of_the_comparison_are_taken_at_a_click(store: RatingStore):
    page = conducting(alerts="policy")
    view = alerts_in(page.session_state["workspace"].result)
    checked(page.button_group(key=RATING_ALERTS.key).set_value("these").run())
    taken = read_alerts(to_csv_bytes(view.table), view.result)
    kinds = view.table["kind"].value_counts()
    assert f"{len(taken)} alerts: {kinds['false']} false, " in words(page)
    study = begun(store, "odd_pose", "rural_child", page=page, whose="NIR")
    assert study.alerts == tuple(
        of for of in taken if of.recording in ("odd_pose", "rural_child") and of.system == "NIR"
    )
    assert len(study.alerts) > 1


def test_terms_and_form_are_those_that_the_conductor_writes(
    store: RatingStore, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(conduct, "is_local", lambda _: True)
    page = conducting(threshold_y="0.83")
    checked(page.checkbox(key="rating_has_form").check().run())
    page.text_area(key="rating_questions").set_value("Shoe size\n\n")
    page.text_area(key="rating_consent").set_value("Only for us.")
    page.number_input(key="rating_keep_days").set_value(10)
    study = begun(store, "odd_pose", page=page)
    assert "ask whoever runs the app to open it to the network" in warnings(page)
    assert study.consent == "Only for us."
    person = rating(study)
    assert person.session_state["params"].threshold_y == 0.83  # that of the session
    assert "Only for us" in words(person)
    assert study.ends_at is not None
    assert f"Your ratings are kept until {study.ends_at:%d %B %Y}" in words(person)
    person.number_input(key="rating_form_0").set_value(41)
    person.selectbox(key="rating_form_3").select("every week")
    person.text_input(key="rating_form_4").set_value("39")
    join(person, "Ann")
    said = store.forms(study).iloc[0].to_dict()
    assert said == {
        "participant": "Ann", "age": "41", "sex": "", "licence": "", "night_driving": "every week",
        "1. Shoe size": "39",
    }  # fmt: skip


def test_it_is_asked_of_every_alert_whether_it_was_worth_it(store: RatingStore):
    page = conducting()
    checked(page.button_group(key=RATING_ALERTS.key).set_value("these").run())
    assert "Alerts are off" in words(page)
    assert "rating_open_alerts" in keys(page)
    sent_alerts(page, "x,FIR,1,2,false")
    assert "recording: there is no 'x'" in words(page)
    assert "rating_start" not in keys(page)
    sent_alerts(page, "odd_pose,FIR,3,4,needed", "odd_pose,y,6,7,false")
    study = begun(store, "odd_pose", page=page)
    assert [alert.kind for alert in study.alerts] == ["needed", "false"]
    assert "Were the alerts worth it?" not in words(page)
    code = joined(store, study, "Ann")
    for clip in range(2):
        store.rate(study, "Ann", clip, 3)
    person = rating(study, participant=code)
    assert "after 3.0 s, the system alerts the driver, for 1.0 s" in words(person)
    assert "needed" not in words(person)
    press(person, "worth_0_yes")
    assert "Alert 2 of 2" in words(person)
    assert "after 5.0 s" in words(person)
    press(person, "worth_1_unsure")
    assert person.title[0].value == "Thank you"
    shown = table(conducting(conduct=study.conductor), "kappa")
    assert shown[["kind", "n_answers", "n_unsure"]].to_numpy().tolist() == [
        ["all", 1, 1], ["false", 0, 1], ["needed", 1, 0],
    ]  # fmt: skip
    assert shown["share"].tolist() == ["1.00", "–", "1.00"]
