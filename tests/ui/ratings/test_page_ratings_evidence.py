"""What the Ratings page says of figures that are no evidence, or little."""

from __future__ import annotations

import pandas as pd
import pytest
from ratings_page import (
    SIMULATED,
    from_file,
    keys,
    metrics,
    opened,
    table,
    warnings,
    words,
)
from streamlit.testing.v1 import AppTest

from pages import checked

TRAINING = "These settings were fitted to these ratings: plot and correlations are training"
OF_SIMULATED = "The settings in use were fitted to simulated ratings."


def csv(ratings: pd.DataFrame) -> bytes:
    return ratings.to_csv(index=False).encode()


@pytest.fixture
def ratings() -> pd.DataFrame:
    return pd.read_csv(SIMULATED)


def taken() -> AppTest:
    page = opened()
    checked(page.button(key="rating_fit").click().run())
    return checked(page.button(key="rating_fit_take").click().run())


def test_fitted_settings_are_marked_where_their_own_ratings_are_shown():
    page = taken()
    assert TRAINING in warnings(page)
    assert "settings in use" not in metrics(page)
    assert metrics(page)["settings before"] == "83%"  # not those of the fitted settings
    assert metrics(page)["fit, on recordings left out"] == "86%"
    assert "Least miss for saliency: 0.05 → 0.1" in words(page).replace("**", "")
    assert "rating_fit_take" not in keys(page)
    checked(page.slider(key="alpha").set_value(0.4).run())
    assert TRAINING in warnings(page)
    checked(page.slider(key="alpha").set_value(0.9).run())
    checked(page.button(key="rating_fit_back").click().run())
    assert TRAINING not in warnings(page)
    params = page.session_state["params"]
    assert (params.tolerance, params.midpoint, params.spread) == (0.05, None, None)
    assert metrics(page)["settings in use"] == "83%"


def test_a_further_fit_is_against_the_settings_before():
    page = taken()
    checked(page.slider(key="alpha").set_value(0.4).run())
    assert "settings before" not in metrics(page)  # this fit is not made yet
    checked(page.button(key="rating_fit").click().run())
    assert metrics(page)["settings before"] == "83%"
    assert metrics(page)["fit, on recordings left out"] == "86%"


def test_fitted_values_that_were_moved_are_no_longer_marked():
    page = taken()
    checked(page.slider(key="midpoint").set_value(60.0).run())
    assert TRAINING not in warnings(page)


def test_other_ratings_are_evidence_for_fitted_settings(ratings: pd.DataFrame):
    page = taken()
    others = ratings.assign(participant="Q" + ratings["participant"], rating=8 - ratings["rating"])
    from_file(csv(others), page=page)
    assert TRAINING not in warnings(page)
    assert OF_SIMULATED in warnings(page)
    assert metrics(page) == {
        "Kendall's W": "0.56", "participants": "16", "clips": "20", "ratings missing": "4",
    }  # fmt: skip
    assert "rating_fit_back" not in keys(page)


def test_ratings_that_the_fit_has_partly_seen_are_no_evidence(ratings: pd.DataFrame):
    page = taken()
    more = ratings[ratings["participant"] == "P01"].assign(participant="P99")
    from_file(csv(pd.concat([ratings, more])), page=page)
    assert metrics(page)["participants"] == "17"
    assert "has seen 94 % of these ratings" in warnings(page)
    assert TRAINING not in warnings(page)
    checked(page.multiselect(key="ratings_left_out").set_value(["P99", "P01"]).run())
    assert TRAINING in warnings(page)


def test_a_small_overlap_with_what_the_fit_has_seen_is_told(ratings: pd.DataFrame):
    page = taken()
    others = ratings.assign(participant="Q" + ratings["participant"])
    from_file(csv(pd.concat([others, ratings.head(1)])), page=page)
    assert "has seen 1 % of these ratings" in warnings(page)
    assert OF_SIMULATED in warnings(page)
    assert "rating_fit_back" in keys(page)


def test_a_rating_counts_as_seen_whatever_its_value(ratings: pd.DataFrame):
    page = taken()
    again = ratings.assign(
        participant=ratings["participant"].str.lower(), rating=8 - ratings["rating"]
    )
    from_file(csv(again), page=page)
    assert TRAINING in warnings(page)


def test_the_fit_has_not_seen_who_was_left_out():
    page = opened()
    checked(page.multiselect(key="ratings_left_out").set_value(["P01"]).run())
    checked(page.button(key="rating_fit").click().run())
    checked(page.button(key="rating_fit_take").click().run())
    assert TRAINING in warnings(page)
    checked(page.multiselect(key="ratings_left_out").set_value([]).run())
    assert "has seen 94 % of these ratings" in warnings(page)


def test_a_fit_to_simulated_ratings_is_marked_at_its_button(ratings: pd.DataFrame):
    mark = "Fitted to simulated ratings: nobody was asked"
    page = opened()
    checked(page.button(key="rating_fit").click().run())
    assert mark in words(page).replace("**", "")
    checked(page.button(key="rating_fit_take").click().run())
    assert mark in words(page).replace("**", "")
    real = from_file(csv(ratings))
    checked(real.button(key="rating_fit").click().run())
    assert mark not in words(real).replace("**", "")


def test_the_result_of_a_fit_has_an_interval_and_so_has_its_gain():
    page = opened()
    checked(page.button(key="rating_fit").click().run())
    assert "95 %: 74% to 95%" in words(page)
    gain = "gains 3 points (95 %: −6 to +11, from resampling the 10 recordings): that may be"
    assert gain in words(page).replace("**", "")


def test_a_fit_to_few_recordings_says_why_there_is_no_interval(ratings: pd.DataFrame):
    page = from_file(csv(ratings[ratings["clip"].isin(ratings["clip"].unique()[:6])]))
    checked(page.button(key="rating_fit").click().run())
    assert "No interval: an interval needs 8 recordings; there are 6." in words(page)


def test_two_who_agree_by_chance_are_not_said_to_agree(ratings: pd.DataFrame):
    page = from_file(csv(ratings[ratings["participant"].isin(["P12", "P15"])]))
    assert "The participants do not agree more than by chance (p = " in warnings(page)
    assert "a W of 0.50 on average with 2 participants" in warnings(page)
    assert "another way" not in words(page)


def test_one_participant_is_not_people(ratings: pd.DataFrame):
    page = from_file(csv(ratings[ratings["participant"] == "P01"]))
    assert "These are the ratings of one participant" in warnings(page)
    assert "intervals and p say nothing about people" in warnings(page)
    assert "one participant" not in warnings(opened())


def test_clips_of_other_comparisons_are_named_and_in_no_figure(ratings: pd.DataFrame):
    ghosts = pd.DataFrame(
        {"participant": ["P01", "P99"], "clip": ["ghost", "*ghost*"], "system": "FIR",
         "rating": [3, 5]}
    )  # fmt: skip
    page = from_file(csv(pd.concat([ratings, ghosts])))
    told = " ".join(one.value for one in page.warning).replace("\\", "")
    assert "2 rated clips not in this comparison, left out of all figures with 2 ratings" in told
    assert "ghost (FIR), *ghost* (FIR). Nothing is left of P99." in told
    assert metrics(page) == {
        "Kendall's W": "0.56", "participants": "16", "clips": "20", "ratings missing": "4",
    }  # fmt: skip
    assert len(table(page, "mean_rank")) == 20


def test_a_file_with_semicolons_is_read_and_a_short_line_refused(ratings: pd.DataFrame):
    page = from_file(ratings.to_csv(index=False, sep=";").encode())
    assert metrics(page)["participants"] == "16"
    page = from_file(csv(ratings) + b"P20,odd_pose,3\n")
    assert "line 322: expected 4 fields, as in the first line; found 3" in words(page)
    assert not page.radio
