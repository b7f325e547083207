"""The Study page, driven without a browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import streamlit as st
import study_pictures
from streamlit.testing.v1 import AppTest

import pages
from nvcore.subjects.driver.study.touch_task import Answer, DetectabilityStore, DetectabilityStudy
from pages import checked, part, press, texts
from ui.subjects.driver.study import files, touch_studies
from ui.subjects.people.studies import ON_SCREEN

SEEN = Answer(measured_s=1, shown_s=0.5, touch_x=30, touch_y=80, response_s=1)
Run = Callable[[], None]


@pytest.fixture(autouse=True)
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> DetectabilityStore:
    """A folder with six pictures, and the file of answers; the sample's pictures are not there."""
    monkeypatch.setattr(files, "sample_folder", lambda: tmp_path / "sample" / "study")
    study_pictures.write(tmp_path / "root" / "dusk", 6)
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path / "root"))
    monkeypatch.setenv("NVCORE_STUDIES", str(tmp_path / "kept" / "studies.sqlite"))
    return DetectabilityStore(tmp_path / "kept" / "studies.sqlite")


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[dict]:
    """The runs that the browser is given; a button in place of each tells that it has ended."""
    drawn: list[dict] = []

    def draw_run(screen, run, title, trials, *, on_end=lambda _: None):
        drawn.append({"run": run, "title": title, "trials": [of._asdict() for of in trials]})
        st.button("End the run", key="study_screen", on_click=on_end, args=(run,))
        st.button("End another", key="study_other", on_click=on_end, args=("3 of it",))

    monkeypatch.setattr(touch_studies, "draw_run", draw_run)
    return drawn


def opened(**address: str) -> AppTest:
    """What participants see, by their address, else what the conductor sees."""
    side = "participant" if "study" in address else "conduct"
    call = f"ui.subjects.people.{side}.draw(touch_studies.TOUCH)"
    return checked(
        part("from ui.subjects.driver.study import touch_studies", call, **address).run()
    )


def begun(store: DetectabilityStore, page: AppTest | None = None) -> DetectabilityStudy:
    page = press(page or opened(), "study_start")
    study = store.study_of_conductor("".join(page.query_params["conduct"]))
    assert study is not None
    return study


def metrics(page: AppTest) -> dict[str, str]:
    return {metric.label: metric.value for metric in page.metric}


def keys(page: AppTest) -> list[str | None]:
    return [button.key for button in page.button]


def joined(study: DetectabilityStudy, page: AppTest | None = None) -> AppTest:
    page = page or opened(study=study.token)
    page.checkbox(key="study_agrees").check()
    return checked(page.button[0].click().run())


def test_how_long_it_takes_and_what_a_screen_cannot_be_is_told_before_it_begins():
    page = opened()
    assert "each participant sees 6 pictures in 3 runs, **about 2 minutes**" in texts(page)
    assert "take a multiple of 6" in texts(page)
    for limit in ("candela", "pupil", "field of view", "on this screen"):  # of a screen
        assert limit in texts(page)
    assert page.text_input(key="study_adaptation_s").proto.max_chars == 200
    checked(page.button_group(key="study_design").set_value("all").run())
    assert "sees 36 pictures in 18 runs, **about 14 minutes**" in texts(page)
    assert "learns where its pedestrian is" in texts(page)


def test_a_study_has_what_was_set(store: DetectabilityStore):
    page = opened()
    page.number_input(key="study_bright_s").set_value(2.5)
    page.number_input(key="study_dark_lux").set_value(10.0)
    page.number_input(key="study_screen_inch").set_value(24.0)
    page.number_input(key="study_keep_days").set_value(30)
    page.number_input(key="study_n_practice").set_value(2)
    page.text_area(key="study_consent").set_value("We keep *all* of it.")
    checked(page.text_area(key="study_questions").set_value("Glasses?\n\n Tired? \n").run())
    study = begun(store, page)
    settings = study.settings
    assert settings.timing.bright_s == 2.5
    assert settings.facts.dark_lux == 10
    assert settings.questions == ("Glasses?", "Tired?")
    assert (settings.n_practice, settings.consent) == (2, "We keep *all* of it.")
    assert (study.ends_at - study.begun_at).days == 30
    assert study.folder == "local:dusk"
    form = opened(study=study.token).number_input
    assert (form(key="study_form_3").value, form(key="study_form_4").value) == (24, None)


def test_what_cannot_be_is_told_and_not_begun_and_leaves_all_else_that_was_entered():
    page = opened()
    page.text_area(key="study_questions").set_value("Glasses?")
    checked(page.number_input(key="study_dark_lux").set_value(10.0).run())
    times = {"0, soon": "expected seconds, separated by commas", "0, 2": "needs 4 s", "0; 5": ""}
    for entered, words in times.items():
        checked(page.text_input(key="study_adaptation_s").set_value(entered).run())
        assert words in texts(page)
        assert ("study_start" in keys(page)) == (not words)
    assert page.text_area(key="study_questions").value == "Glasses?"
    assert page.number_input(key="study_dark_lux").value == 10
    checked(page.text_area(key="study_consent").set_value(" ").run())
    assert "1 to 20,000 characters" in texts(page)
    assert "study_start" not in keys(page)


def test_without_a_folder_of_ones_own_there_are_the_samples_pictures_if_any(
    store: DetectabilityStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.delenv("NVCORE_LOCAL_ROOT")
    page = opened()
    assert "nvcore app --local-root DIR" in texts(page)
    assert "study_start" not in keys(page)
    study_pictures.write(tmp_path / "sample" / "study", 3)
    study = begun(store)
    assert (study.folder, len(study.pictures)) == ("sample", 3)
    assert files.folder_of(study.folder) == tmp_path / "sample" / "study"


def test_a_table_with_a_wrong_line_is_told_without_paths(tmp_path: Path):
    with (tmp_path / "root" / "dusk" / "boxes.csv").open("a") as file:
        file.write("../../secret.png,p,0,0,4,8\n")
    shown = texts(opened())
    assert "boxes.csv, line 8" in shown
    assert str(tmp_path) not in shown


def test_folders_below_the_root_are_offered_and_none_outside(tmp_path: Path):
    root = tmp_path / "root"
    study_pictures.write(root / "a" / "b", 1)
    study_pictures.write(tmp_path / "outside", 1)
    (root / "way_out").symlink_to(tmp_path / "outside")
    assert list(files.folders()) == ["local:dusk", "local:a/b"]
    for path in ("local:../outside", "local:way_out", "/etc", "local:gone"):
        with pytest.raises(Exception, match=r"no such file|started with"):
            files.folder_of(path)


def test_who_agrees_gets_a_code_and_the_form_says_nothing_where_it_is_empty(
    store: DetectabilityStore, runs: list[dict]
):
    page = opened()
    page.text_area(key="study_consent").set_value("# Hi\n\n[x](http://evil) <b>")
    checked(page.text_area(key="study_questions").set_value("Glasses?").run())
    study = begun(store, page)
    page = opened(study=study.token)
    shown = [item.value for item in page.markdown]
    assert not any("](http" in text for text in shown)  # the text of consent is text
    assert "# Hi" not in shown
    assert "candela" in texts(page)
    assert f"{study.ends_at:%d %B %Y}" in texts(page)
    checked(page.button[0].click().run())
    assert "Without your agreement" in texts(page)
    assert store.participants(study) == []
    page.number_input(key="study_form_0").set_value(31)
    page.selectbox(key="study_form_2").select("yes")
    page.text_input(key="study_form_5").set_value("no")
    page.checkbox(key="study_agrees").check()
    checked(page.button[0].click().run())
    (person,) = store.participants(study)
    assert person.form == {"age": "31", "licence": "yes", "1. Glasses?": "no"}
    code = "".join(page.query_params["participant"])
    assert store.by_code(study, code) == person
    assert f"**{code}**" in texts(page)


def test_practice_comes_once_then_run_after_run_until_all_are_answered(
    store: DetectabilityStore, runs: list[dict]
):
    study = begun(store)
    page = joined(study)
    (person,) = store.participants(study)
    code = "".join(page.query_params["participant"])
    note = page.session_state["workspace"].notes[ON_SCREEN]
    assert (note.name, note.folder.name) == (person.name, "dusk")
    practice = runs[-1]
    assert [trial["place"] for trial in practice["trials"]] == [0, 0]
    press(page, "study_screen")
    assert store.find(study, person.name).has_practised
    for run in range(1, 4):
        page = opened(study=study.token, participant=code)  # as after a reload
        assert runs[-1]["title"] == f"Begin run {run} of 3"
        assert ("Look at the **bright screen**" in texts(page)) == (run == 1)
        trials = [trial for trial in person.plan if trial.run == run]
        assert [trial["place"] for trial in runs[-1]["trials"]] == [t.order for t in trials]
        assert [trial["picture"] for trial in runs[-1]["trials"]] == [
            str(t.picture) for t in trials
        ]
        store.answer(study, person.name, trials[0].order, SEEN)
        checked(page.run())
        assert [trial["place"] for trial in runs[-1]["trials"]] == [trials[1].order]
        store.answer(study, person.name, trials[1].order, SEEN)
    checked(page.run())
    assert page.title[0].value == "Thank you"
    assert f"**{code}**" in texts(page)
    assert ON_SCREEN not in page.session_state["workspace"].notes


def test_every_practice_run_has_to_be_seen_to_its_end(store: DetectabilityStore, runs: list[dict]):
    page = opened()
    checked(page.number_input(key="study_n_practice").set_value(2).run())
    study = begun(store, page)
    page = joined(study)
    (person,) = store.participants(study)
    press(page, "study_screen")
    assert page.title[0].value == "Practice 2 of 2"
    press(page, "study_other")
    checked(page.run())  # as after a run that was stopped
    assert page.title[0].value == "Practice 2 of 2"
    assert not store.find(study, person.name).has_practised
    press(page, "study_screen")
    assert store.find(study, person.name).has_practised
    assert runs[-1]["title"] == "Begin run 1 of 3"


@pytest.mark.parametrize("way", ["next", "conductor", "other page", "ratings"])
def test_who_has_left_the_screen_can_no_longer_be_answered_for(
    store: DetectabilityStore, runs: list[dict], way: str
):
    study = begun(store)
    page = joined(study, checked(pages.opened("study", study=study.token)))
    assert not page.sidebar.slider
    notes = page.session_state["workspace"].notes
    assert ON_SCREEN in notes
    if way in ("next", "conductor"):
        page.query_params.clear()
        page.query_params.update(
            {"study": study.token} if way == "next" else {"conduct": study.conductor}
        )
        checked(page.run())
        assert bool(page.code) == (way == "conductor")  # the addresses of the study
    else:
        page.query_params.clear()
        if way == "ratings":
            page.query_params["study"] = "guess"
        checked(pages.to_page(page, "ratings"))
    assert ON_SCREEN not in notes


def test_the_conductor_sees_progress_and_marks(store: DetectabilityStore):
    study = begun(store)
    for n in (6, 2):
        person, _ = store.join(study, {})
        for trial in person.plan[:n]:
            measured = trial.adaptation_s + (0.2 if trial.order == 1 else 0.01)
            store.note_showing(study, person.name, trial.order)
            store.answer(study, person.name, trial.order, Answer(measured_s=measured, shown_s=0.5))
    page = opened(conduct=study.conductor)
    assert metrics(page) == {
        "participants": "2", "have seen all pictures": "1", "trials so far": "8", "marked": "2",
    }  # fmt: skip


def test_pictures_that_are_gone_are_told(
    store: DetectabilityStore, runs: list[dict], monkeypatch: pytest.MonkeyPatch
):
    study = begun(store)
    _, code = store.join(study, {})
    monkeypatch.delenv("NVCORE_LOCAL_ROOT")
    page = opened(study=study.token, participant=code)
    assert "now it was started without" in texts(page)
    assert runs == []
