"""The Ratings page, driven without a browser."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import pandas as pd
import pytest
from ratings_page import SIMULATED, from_file, metrics, opened, table, words

from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.subjects.ratings.agreement import rank_ratings
from nvcore.subjects.ratings.drivers import DRIVERS, RatingDrivers
from nvcore.subjects.ratings.reading import read_ratings
from pages import checked, press
from ui.subjects.ratings import drivers, results

CONTRARY = "P12"


def test_the_samples_simulated_ratings_are_shown_as_such_and_without_who_is_left_out():
    page = opened()
    assert "simulated: nobody was asked" in words(page)
    assert metrics(page) == {
        "Kendall's W": "0.57",
        "participants": "16",
        "clips": "20",
        "ratings missing": "4",
    }
    assert "The participants agree moderately" in words(page)
    assert f"{CONTRARY}: ranks the clips differently" in words(page)
    correlations = table(page, "Coefficient")
    assert correlations["Value"].tolist() == ["0.86", "0.84", "0.66"]
    assert correlations["95 % interval"][0] == "0.59 to 0.95"
    assert len(table(page, "mean_rank")) == 20
    assert "cannot be told from these ratings: anything from 0.17 to 1.00 fits" in words(page)
    assert table(page, "value")["driver"].tolist() == [*DRIVERS.values()]
    checked(page.multiselect(key="ratings_left_out").set_value([CONTRARY]).run())
    assert "1 participant left out by hand: P12. All numbers are without them." in words(page)
    assert metrics(page)["participants"] == "15"
    assert float(metrics(page)["Kendall's W"]) > 0.6
    assert table(page, "mean_rank")["n_ratings"].max() == 15


def test_the_alpha_of_people_is_set_against_the_one_in_use():
    found = RatingDrivers(pd.DataFrame(), 0.7, 0.61, 0.8, "", 40, 20, 12)
    weighed = (
        "People weigh misses and false alarms by a mean alpha of **0.70** (95 %: 0.61 to 0.80)"
    )
    assert weighed in drivers.alpha_text(found, 0.9)
    assert "The 0.9 in use is outside of it." in drivers.alpha_text(found, 0.9)
    assert "The 0.65 in use agrees with that." in drivers.alpha_text(found, 0.65)
    assert drivers.intervals_text(found).startswith("of the mean of people, ")


@pytest.mark.parametrize(
    ("n", "who", "weighs"),
    [
        (1, "this participant", "This participant weighs misses and false alarms by an alpha of"),
        (7, "these 7 participants", "These 7 participants weigh misses and false alarms by a mean"),
    ],
)
def test_few_participants_do_not_speak_of_people(n: int, who: str, weighs: str) -> None:
    found = RatingDrivers(pd.DataFrame(), 0.7, 0.61, 0.8, "", 40, 20, n)
    assert drivers.alpha_text(found, 0.9).startswith(weighs)
    assert drivers.intervals_text(found) == f"of {who} only, from resampling the recordings"
    unknown = replace(found, reason="too few")
    assert f"Which alpha {who} weigh" in drivers.alpha_text(unknown, 0.9)


def test_a_file_without_systems_asks_whose_boxes_were_shown():
    ratings = pd.read_csv(SIMULATED).query("system == 'NIR'").drop(columns="system")
    page = from_file(ratings.to_csv(index=False).encode())
    assert page.radio(key="ratings_system").value == "FIR"
    checked(page.radio(key="ratings_system").set_value("NIR").run())
    assert set(table(page, "mean_rank")["system"]) == {"NIR"}
    assert len(table(page, "mean_rank")) == 10
    assert "simulated" not in words(page)


def test_a_file_that_cannot_be_used_says_why():
    page = opened()
    for content, why in (
        (b"\x89PNG\r\n\x1a\n\x00\xff", "this is no CSV table of ratings"),
        (b"participant,clip\nP1,a\n", "rating is missing"),
        (b"participant,clip,rating\nP1,a,3\nP1,b,often\n", "line 3"),
        (b"participant,clip,rating\nP1,a,3\n", "none of the rated clips"),
        (b"participant,clip,rating\n", "There is no rating yet"),
        (b"," * ((5 << 20) + 1), "larger than 5 MB"),
    ):
        assert why in words(from_file(content, page=page))


def test_names_of_a_file_are_shown_as_text():
    ratings = pd.read_csv(SIMULATED)
    ratings["participant"] = ratings["participant"].replace(CONTRARY, "<b>![x](//evil)")
    page = from_file(ratings.to_csv(index=False).encode())
    assert "\\<b\\>\\!\\[x\\]" in " ".join(text.value for text in page.caption)


def test_too_few_clips_give_no_figure_but_the_reason():
    page = from_file(
        b"participant,clip,system,rating\nA,odd_pose,FIR,1\nA,rural_child,FIR,2\n"
        b"B,odd_pose,FIR,2\nB,rural_child,FIR,5\n"
    )
    shown = table(page, "Coefficient")
    assert set(shown["Value"]) == {"–"}
    assert "a correlation needs 5" in shown["Why there is none"][0]
    assert metrics(page)["Kendall's W"] == "–"
    assert "two participants and three clips at least" in words(page)
    assert "needs 5 rated recordings; there are 2" in words(press(page, "rating_fit"))


def test_ranks_are_one_row_for_each_participant_and_clip():
    ranks = results._long(rank_ratings(read_ratings(SIMULATED)))
    ranks = pd.read_csv(BytesIO(to_csv_bytes(ranks)))
    assert list(ranks) == ["participant", "clip", "system", "rank"]
    assert len(ranks) == 16 * 20
    assert ranks["rank"].isna().sum() == 4
