"""The Ratings page, driven without a browser."""

from __future__ import annotations

import sqlite3
import threading
from contextlib import closing
from io import BytesIO
from pathlib import Path

import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

from nvcore.ratings.store import RatingStore, Study
from nvcore.session_file import read_session
from ui import ratings_fit, ratings_participant, ratings_source, state
from ui.background_job import JobState

ROOT = Path(__file__).resolve().parents[2]
SIMULATED = ROOT / "sample_data" / "ratings_simulated.csv"
CONTRARY = "P12"


@pytest.fixture(autouse=True)
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RatingStore:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))
    monkeypatch.setenv("NVCORE_RATINGS", str(tmp_path / "kept" / "ratings.sqlite"))
    return RatingStore(tmp_path / "kept" / "ratings.sqlite")


def opened(**address: str) -> AppTest:
    app = AppTest.from_file(str(ROOT / "ui" / "main.py"), default_timeout=60)
    app.run()
    app.switch_page(str(ROOT / "pages" / "ratings.py"))
    for name, value in address.items():
        app.query_params[name] = value
    return checked(app.run())


def checked(page: AppTest) -> AppTest:
    assert not page.exception
    return page


def words(page: AppTest) -> str:
    shown = (*page.markdown, *page.caption, *page.info, *page.warning, *page.error, *page.success)
    return " ".join(one.value for one in shown).replace("\\", "")


def metrics(page: AppTest) -> dict[str, str]:
    return {one.label: one.value for one in page.metric}


def from_file(content: bytes, name: str = "ratings.csv") -> AppTest:
    page = opened()
    checked(page.button_group(key="ratings_source_4").set_value(ratings_source.FILE).run())
    return checked(
        page.file_uploader(key="ratings_file").set_value((name, content, "text/csv")).run()
    )


def table(page: AppTest, column: str) -> pd.DataFrame:
    return next(one.value for one in page.dataframe if column in one.value)


def test_the_sample_shows_its_simulated_ratings_as_such():
    page = opened()
    assert "simulated: nobody was asked" in words(page)
    assert metrics(page) == {
        "Kendall's W": "0.56", "participants": "16", "clips": "20", "ratings missing": "4",
    }  # fmt: skip
    assert "The participants agree moderately" in words(page)
    assert f"{CONTRARY}: ranks the clips another way" in words(page)


def test_saliency_is_set_against_the_mean_rank_with_intervals():
    shown = table(opened(), "coefficient")
    assert shown["coefficient"].tolist() == ["Pearson's r", "Spearman's rho", "Kendall's tau"]
    assert shown["value"].tolist() == ["0.86", "0.81", "0.65"]
    assert shown["95 % interval"][0] == "0.55 to 0.95"
    assert len(table(opened(), "mean_rank")) == 20


def test_who_is_left_out_is_told_and_in_no_figure():
    page = opened()
    checked(page.multiselect(key="ratings_left_out").set_value([CONTRARY]).run())
    assert "1 participant left out by hand: P12. All figures are without them." in words(page)
    assert metrics(page)["participants"] == "15"
    assert float(metrics(page)["Kendall's W"]) > 0.6
    assert table(page, "mean_rank")["n_ratings"].max() == 15


def test_the_fit_is_told_honestly_and_can_be_taken():
    page = opened()
    checked(page.button(key="rating_fit").click().run())
    assert metrics(page)["settings in use"] == "83%"
    assert metrics(page)["fit, on recordings left out"] == "86%"
    assert metrics(page)["fit, on what it has seen"] == "91%"
    assert "The second figure is the result" in words(page)
    assert "Least miss for saliency: 0.05 → 0.1" in words(page).replace("**", "")
    checked(page.button(key="rating_fit_take").click().run())
    assert page.session_state["params"].tolerance == 0.1
    assert page.session_state["params"].midpoint == pytest.approx(36)
    assert page.slider(key="midpoint").value == pytest.approx(36)
    assert "The fitted settings are in use" in words(page)


def test_a_fit_to_many_frames_is_made_in_the_background(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(ratings_fit, "AT_ONCE", 0)
    page = opened()
    checked(page.button(key="rating_fit").click().run())
    page.session_state[ratings_fit.JOB].join()
    assert metrics(checked(page.run()))["fit, on recordings left out"] == "86%"


def test_a_file_without_systems_asks_whose_boxes_were_shown():
    ratings = pd.read_csv(SIMULATED).query("system == 'NIR'").drop(columns="system")
    page = from_file(ratings.to_csv(index=False).encode())
    assert page.radio(key="ratings_system").value == "FIR"
    checked(page.radio(key="ratings_system").set_value("NIR").run())
    assert set(table(page, "mean_rank")["system"]) == {"NIR"}
    assert len(table(page, "mean_rank")) == 10
    assert "simulated" not in words(page)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"\x89PNG\r\n\x1a\n\x00\xff", "this is no CSV table of ratings"),
        (b"participant,clip\nP1,a\n", "rating is missing"),
        (b"participant,clip,rating\nP1,a,3\nP1,b,often\n", "line 3"),
        (b"participant,clip,rating\nP1,a,3\n", "none of the rated clips"),
        (b"participant,clip,rating\n", "There is no rating yet"),
    ],
)
def test_a_file_that_cannot_be_used_says_why(content: bytes, told: str):
    assert told in words(from_file(content))


def test_names_of_a_file_are_shown_as_text():
    ratings = pd.read_csv(SIMULATED)
    ratings["participant"] = ratings["participant"].replace(CONTRARY, "<b>![x](//evil)")
    page = from_file(ratings.to_csv(index=False).encode())
    told = " ".join(one.value for one in page.caption)
    assert "\\<b\\>\\!\\[x\\]" in told


def test_too_few_clips_give_no_figure_but_the_reason():
    page = from_file(
        b"participant,clip,system,rating\nA,odd_pose,FIR,1\nA,rural_child,FIR,2\n"
        b"B,odd_pose,FIR,2\nB,rural_child,FIR,5\n"
    )
    shown = table(page, "coefficient")
    assert set(shown["value"]) == {"–"}
    assert "a correlation needs 5" in shown["why there is none"][0]
    assert metrics(page)["Kendall's W"] == "–"
    assert "two participants and three clips at least" in words(page)
    checked(page.button(key="rating_fit").click().run())
    assert "needs 5 rated recordings; there are 2" in words(page)


def begun(page: AppTest, store: RatingStore, *recordings: str, whose: str = "both") -> Study:
    """Begin a rating session."""
    checked(page.button_group(key="ratings_part").set_value("Rating session").run())
    page.multiselect(key="rating_recordings").set_value(list(recordings))
    page.button_group(key="rating_whose").set_value(whose)
    checked(page.button(key="rating_start").click().run())
    study = store.conducted(only(page, "conduct"))
    assert study is not None
    return study


def only(page: AppTest, name: str) -> str:
    return "".join(page.query_params[name])


def test_a_rating_session_has_an_address_for_each_side(store: RatingStore):
    page = opened()
    checked(page.slider(key="threshold_x").set_value(0.7).run())
    study = begun(page, store, "odd_pose", "rural_child", whose="NIR")
    links = [one.value for one in page.code]
    assert links[0].endswith(f"?study={study.token}")
    assert links[1].endswith(f"?conduct={study.conductor}")
    assert study.clips == (("rural_child", "NIR"), ("odd_pose", "NIR"))
    assert study.thresholds == {"FIR": 0.7, "NIR": 0.5}
    assert metrics(page)["ratings so far"] == "0"


def test_no_recording_begins_no_session():
    page = opened()
    page.button_group(key="ratings_part").set_value("Rating session").run()
    page.multiselect(key="rating_recordings").set_value([]).run()
    checked(page.button(key="rating_start").click().run())
    assert "needs 1 to 500 clips" in words(page)


def test_a_participant_sees_clips_only_and_every_rating_is_kept(
    store: RatingStore, monkeypatch: pytest.MonkeyPatch
):
    shown: list[tuple[int, str]] = []
    is_seen = False

    def seen(**of):
        shown.append((of["recording"], of["only"]))
        assert of["names"] == ("", "")
        return of["n_rows"] - 1 if is_seen else 0

    monkeypatch.setattr(ratings_participant, "viewer", seen)
    study = begun(opened(), store, "odd_pose", "rural_child")
    page = opened(study=study.token)
    assert not page.sidebar.slider
    assert "FIR" not in words(page)
    page.text_input(key="rating_name").set_value(" Ann ")
    checked(page.button[0].click().run())
    assert only(page, "participant") == "Ann"
    assert not page.button  # before the end of the clip there is nothing to press
    is_seen = True
    order = store.order(study, "Ann")
    for number, clip in enumerate(order):
        assert f"Clip {number + 1} of 4" in words(page.run())
        page = checked(opened(study=study.token, participant="Ann"))  # as after a crash
        recording, system = study.clips[clip]
        names = [one.name for one in read_session(state.SAMPLE).recordings]
        assert shown[-1] == (names.index(recording), "x" if system == "FIR" else "y")
        checked(page.button(key=f"rating_{clip}_{number + 2}").click().run())
        assert store.rated(study, "Ann")[clip] == number + 2
    assert page.title[0].value == "Thank you"


def test_a_participants_boxes_have_the_thresholds_of_the_session(
    store: RatingStore, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(ratings_participant, "viewer", lambda **_: 0)
    page = opened()
    checked(page.slider(key="threshold_y").set_value(0.83).run())
    study = begun(page, store, "odd_pose")
    person = opened(study=study.token, participant="Ann")
    assert person.session_state["params"].threshold_y == 0.83


def test_the_conductor_comes_back_to_progress_and_results(store: RatingStore):
    study = begun(opened(), store, "odd_pose", "rural_child", "rural_road")
    for name, shift in (("Ann", 0), ("Bob", 1)):
        store.order(study, name)
        for clip in range(6 - shift):
            store.rate(study, name, clip, 1 + clip)
    page = opened(conduct=study.conductor)
    assert metrics(page) == {
        "participants": "2", "have rated all clips": "1", "ratings so far": "11",
    }  # fmt: skip
    assert table(page, "n_rated")["n_rated"].tolist() == [6, 5]
    checked(page.button_group(key="ratings_part").set_value("Results").run())
    checked(page.button_group(key="ratings_source_4").set_value(ratings_source.SESSION).run())
    assert metrics(page)["ratings missing"] == "1"
    assert metrics(page)["clips"] == "6"


def test_a_participant_does_not_see_the_ratings(store: RatingStore):
    study = begun(opened(), store, "odd_pose")
    page = opened(conduct=study.token)
    assert "there is no rating session of the name in the address" in words(page)
    assert not page.code


def test_strangers_see_no_session():
    page = opened(conduct="AAAAAAAAAAAAAAAAAAAAAA")
    assert "there is no rating session of the name in the address" in words(page)
    assert not page.code
    assert "leads to no rating session" in words(opened(study="AAAAAAAAAAAAAAAAAAAAAA"))


def test_a_participant_with_another_comparison_open_is_told(store: RatingStore):
    study = store.begin("of another dataset", [("night", "FIR")])
    page = opened(study=study.token)
    assert "about another comparison than the one that is open" in words(page)
    assert page.sidebar.slider  # so that it can be opened
    assert "study" not in page.query_params


def test_the_rating_session_goes_on_once_its_comparison_is_open(
    store: RatingStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(ratings_participant, "viewer", lambda **_: 0)
    study = begun(opened(), store, "odd_pose")
    change = "UPDATE study SET fingerprint = ?"
    with closing(sqlite3.connect(tmp_path / "kept" / "ratings.sqlite")) as base, base:
        base.execute(change, ("of another dataset",))
    page = opened(study=study.token, participant="Ann")
    with closing(sqlite3.connect(tmp_path / "kept" / "ratings.sqlite")) as base, base:
        base.execute(change, (study.fingerprint,))
    checked(page.run())
    checked(page.button(key="rating_go_on").click().run())
    assert "Clip 1 of 2" in words(page)
    assert only(page, "participant") == "Ann"


def test_the_conductors_screen_can_be_handed_over_and_taken_back(
    store: RatingStore, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(ratings_participant, "viewer", lambda **of: of["n_rows"] - 1)
    page = opened()
    checked(page.slider(key="alpha").set_value(0.4).run())
    study = begun(page, store, "odd_pose", whose="FIR")
    checked(page.button(key="rating_here").click().run())
    page.text_input(key="rating_name").set_value("Ann")
    checked(page.button[0].click().run())
    checked(page.button(key="rating_0_3").click().run())
    checked(page.button(key="rating_next").click().run())
    assert "participant" not in page.query_params
    checked(page.button(key="rating_back").click().run())
    assert only(page, "conduct") == study.conductor
    assert metrics(page)["have rated all clips"] == "1"
    assert page.slider(key="alpha").value == 0.4
    stranger = opened(study=study.token, participant="Ann")
    assert [one.key for one in stranger.button] == ["rating_next"]


def test_a_session_that_is_closed_opens_again_by_its_link(store: RatingStore):
    page = opened()
    study = begun(page, store, "odd_pose")
    checked(page.button(key="rating_close").click().run())
    assert not page.code
    assert "conduct" not in page.query_params
    assert opened(conduct=study.conductor).code


def test_a_fit_in_the_background_can_be_cancelled(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(ratings_fit, "AT_ONCE", 0)
    is_started, may_go_on = threading.Event(), threading.Event()
    real = ratings_fit.fit_saliency

    def waits(*of, **more):
        is_started.set()
        assert may_go_on.wait(20)
        return real(*of, **more)

    monkeypatch.setattr(ratings_fit, "fit_saliency", waits)
    page = opened()
    checked(page.button(key="rating_fit").click().run())
    assert is_started.wait(20)
    checked(page.button(key="rating_fit_cancel").click().run())
    may_go_on.set()
    job = page.session_state[ratings_fit.JOB]
    job.join()
    assert job.state is JobState.CANCELLED
    assert page.run().button(key="rating_fit")


def test_ratings_typed_in_are_checked(monkeypatch: pytest.MonkeyPatch):
    typed = pd.DataFrame(
        {
            "participant": ["A", "A", None], "clip": ["odd_pose", "odd_pose", None],
            "system": ["FIR", "FIR", None], "rating": [1.0, 2.0, None],
        }
    )  # fmt: skip
    monkeypatch.setattr(ratings_source.st, "data_editor", lambda *_, **__: typed)
    page = opened()
    checked(page.button_group(key="ratings_source_4").set_value(ratings_source.TYPED).run())
    assert "A rates the clip odd_pose with the boxes of FIR a second time" in words(page)
    typed.loc[1, "clip"] = "rural_road"
    assert metrics(checked(page.run()))["clips"] == "2"


def test_an_unusable_file_of_ratings_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "no.sqlite").write_bytes(b"this is no database, whatever its name says" * 40)
    monkeypatch.setenv("NVCORE_RATINGS", str(tmp_path / "no.sqlite"))
    page = opened()
    page.button_group(key="ratings_part").set_value("Rating session").run()
    checked(page.button(key="rating_start").click().run())
    assert "the file of the ratings cannot be used" in words(page)


def test_ranks_are_one_row_for_each_participant_and_clip():
    from nvcore.csvtext import to_csv_bytes
    from nvcore.ratings.agreement import rank_ratings
    from nvcore.ratings.reading import read_ratings
    from ui.ratings_results import _long

    ranks = pd.read_csv(BytesIO(to_csv_bytes(_long(rank_ratings(read_ratings(SIMULATED))))))
    assert list(ranks) == ["participant", "clip", "system", "rank"]
    assert len(ranks) == 16 * 20
    assert ranks["rank"].isna().sum() == 4


def test_a_participant_with_one_system_open_is_told(
    store: RatingStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    rows = "".join(f"night,{frame},300,200,40,120,1\n" for frame in range(9))
    for name, last in (("truth", "track"), ("one", "score")):
        (tmp_path / f"{name}.csv").write_text(f"recording,frame,x,y,w,h,{last}\n{rows}")
    (tmp_path / "session.toml").write_text(
        '[defaults]\nsize = "640x480"\nfps = 10\nframes = "0:8"\n[truth]\npath = "truth.csv"\n'
        '[[system]]\nname = "one"\npath = "one.csv"\n'
    )
    monkeypatch.setattr(state, "SAMPLE", tmp_path / "session.toml")
    study = store.begin("of another dataset", [("night", "FIR")])
    told = words(opened(study=study.token))
    assert "about another comparison than the one that is open" in told
    assert "A comparison needs two" in told
