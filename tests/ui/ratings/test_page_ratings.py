"""The Ratings page, driven without a browser."""

from __future__ import annotations

import threading
from io import BytesIO

import pandas as pd
import pytest
from ratings_page import SIMULATED, from_file, metrics, opened, table, words

from pages import TIMEOUT_S, checked
from ui.jobs.background import JobState
from ui.ratings import fit

CONTRARY = "P12"


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


def test_a_fit_to_many_frames_is_made_in_the_background(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(fit, "AT_ONCE", 0)
    page = opened()
    checked(page.button(key="rating_fit").click().run())
    page.session_state["workspace"].job(fit.JOB).join()
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


def test_a_fit_in_the_background_can_be_cancelled(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(fit, "AT_ONCE", 0)
    is_started, may_go_on = threading.Event(), threading.Event()
    real = fit.fit_saliency

    def waits(*of, **more):
        is_started.set()
        assert may_go_on.wait(TIMEOUT_S)
        return real(*of, **more)

    monkeypatch.setattr(fit, "fit_saliency", waits)
    page = opened()
    checked(page.button(key="rating_fit").click().run())
    assert is_started.wait(TIMEOUT_S)
    checked(page.button(key="rating_fit_cancel").click().run())
    may_go_on.set()
    job = page.session_state["workspace"].job(fit.JOB)
    job.join()
    assert job.state is JobState.CANCELLED
    assert page.run().button(key="rating_fit")
    assert "Cancelled. No fit was made." in [one.value for one in page.info]


def test_ranks_are_one_row_for_each_participant_and_clip():
    from nvcore.csv_text import to_csv_bytes
    from nvcore.studies.ratings.agreement import rank_ratings
    from nvcore.studies.ratings.reading import read_ratings
    from ui.ratings.results import _long

    ranks = pd.read_csv(BytesIO(to_csv_bytes(_long(rank_ratings(read_ratings(SIMULATED))))))
    assert list(ranks) == ["participant", "clip", "system", "rank"]
    assert len(ranks) == 16 * 20
    assert ranks["rank"].isna().sum() == 4
