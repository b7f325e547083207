"""What the Ratings page says of figures that are no evidence, or little."""

from __future__ import annotations

import pandas as pd
import pytest
from ratings_page import SIMULATED, from_file, keys, metrics, opened, table, warnings, words
from streamlit.testing.v1 import AppTest

from pages import checked, press

TRAINING = "These settings were fitted to these ratings: plot and correlations are training"
OF_SIMULATED = "The settings in use were fitted to simulated ratings."
SIMULATED_FIT = "Fitted to simulated ratings: nobody was asked"


def csv(ratings: pd.DataFrame) -> bytes:
    return ratings.to_csv(index=False).encode()


@pytest.fixture
def ratings() -> pd.DataFrame:
    return pd.read_csv(SIMULATED)


def taken() -> AppTest:
    return press(press(opened(), "rating_fit"), "rating_fit_take")


def test_a_fit_is_told_honestly_and_marked_as_long_as_it_is_in_use():
    page = press(opened(), "rating_fit")
    fit = {"fit, on recordings left out": "88 %", "fit, on what it has seen": "92 %"}
    assert fit.items() <= metrics(page).items()
    assert "The second number is the result" in words(page)
    assert "95 %: 78 % to 96 %" in words(page)
    assert "gains 5 points (95 %: −1 to +12" in words(page)
    assert "not shown to be more than chance" in words(page)
    assert "Least miss for saliency: 0.05 → 0.1" in words(page)
    assert SIMULATED_FIT in words(page)
    assert metrics(page)["settings in use"] == "83 %"
    press(page, "rating_fit_take")
    params = page.session_state["params"]
    assert (params.tolerance, params.midpoint) == (0.1, pytest.approx(36))
    assert TRAINING in warnings(page)
    assert SIMULATED_FIT in words(page)
    assert "settings in use" not in metrics(page)
    assert metrics(page)["settings before"] == "83 %"  # not those of the fitted settings
    assert fit.items() <= metrics(page).items()
    assert "Least miss for saliency: 0.05 → 0.1" in words(page)
    assert "rating_fit_take" not in keys(page)
    press(page, "rating_fit_back")
    assert TRAINING not in warnings(page)
    params = page.session_state["params"]
    assert (params.tolerance, params.midpoint, params.spread) == (0.05, None, None)
    assert metrics(page)["settings in use"] == "83 %"


@pytest.mark.usefixtures("few_settings")
def test_other_settings_beside_a_fit_leave_it_in_use_and_moved_ones_do_not():
    page = taken()
    page.session_state["new_params"] = {"edge_weight": 0.0}
    checked(page.run())
    assert TRAINING in warnings(page)
    assert "settings before" not in metrics(page)  # a further fit is not made yet
    press(page, "rating_fit")
    assert metrics(page)["settings before"] == "84 %"
    page.session_state["new_params"] = {"midpoint": 60.0}
    checked(page.run())
    assert TRAINING not in warnings(page)


@pytest.mark.usefixtures("few_settings")
def test_ratings_that_the_fit_has_seen_are_no_evidence_and_others_are(ratings: pd.DataFrame):
    page = taken()
    others = ratings.assign(participant="Q" + ratings["participant"], rating=8 - ratings["rating"])
    from_file(csv(others), page=page)
    assert TRAINING not in warnings(page)
    assert OF_SIMULATED in warnings(page)
    assert metrics(page).keys() == {"Kendall's W", "participants", "clips", "ratings missing"}
    assert "rating_fit_back" not in keys(page)
    from_file(csv(pd.concat([others, ratings.head(1)])), page=page)
    assert "has seen 1 % of these ratings" in warnings(page)
    assert OF_SIMULATED in warnings(page)
    assert "rating_fit_back" in keys(page)
    again = ratings.assign(
        participant=ratings["participant"].str.lower(), rating=8 - ratings["rating"]
    )
    from_file(csv(again), page=page)  # whatever their values
    assert TRAINING in warnings(page)
    more = ratings[ratings["participant"] == "P01"].assign(participant="P99")
    from_file(csv(pd.concat([ratings, more])), page=page)
    assert metrics(page)["participants"] == "17"
    assert "has seen 94 % of these ratings" in warnings(page)
    assert TRAINING not in warnings(page)
    checked(page.multiselect(key="ratings_left_out").set_value(["P99", "P01"]).run())
    assert TRAINING in warnings(page)


@pytest.mark.usefixtures("few_settings")
def test_the_fit_has_not_seen_who_was_left_out():
    page = opened()
    checked(page.multiselect(key="ratings_left_out").set_value(["P01"]).run())
    press(press(page, "rating_fit"), "rating_fit_take")
    assert TRAINING in warnings(page)
    checked(page.multiselect(key="ratings_left_out").set_value([]).run())
    assert "has seen 94 % of these ratings" in warnings(page)


@pytest.mark.usefixtures("few_settings")
def test_a_fit_to_few_real_ratings_says_why_there_is_no_interval(ratings: pd.DataFrame):
    page = from_file(csv(ratings[ratings["clip"].isin(ratings["clip"].unique()[:6])]))
    press(page, "rating_fit")
    assert "No interval: an interval needs 8 recordings; there are 6." in words(page)
    assert SIMULATED_FIT not in words(page)


def test_few_participants_are_told_what_their_ratings_say_of_people(ratings: pd.DataFrame):
    page = from_file(csv(ratings[ratings["participant"].isin(["P12", "P15"])]))
    assert "The participants do not agree more than by chance (p = " in warnings(page)
    assert "a W of 0.50 on average with 2 participants" in warnings(page)
    assert "differently" not in words(page)
    assert "one participant" not in warnings(page)
    from_file(csv(ratings[ratings["participant"] == "P01"]), page=page)
    assert "These are the ratings of one participant" in warnings(page)
    assert "intervals and p say nothing about people" in warnings(page)


def test_clips_of_other_comparisons_are_named_and_in_no_figure(ratings: pd.DataFrame):
    columns = ["participant", "clip", "system", "rating"]
    ghosts = [("P01", "ghost", "FIR", 3), ("P99", "*ghost*", "FIR", 5)]
    page = from_file(csv(pd.concat([ratings, pd.DataFrame(ghosts, columns=columns)])))
    warning = " ".join(text.value for text in page.warning).replace("\\", "")
    assert "2 rated clips not in this comparison, left out of all numbers with 2 ratings" in warning
    assert "ghost (FIR), *ghost* (FIR). Nothing is left of P99." in warning
    assert list(metrics(page).values()) == ["0.57", "16", "20", "4"]
    assert len(table(page, "mean_rank")) == 20


def test_a_file_with_semicolons_is_read_and_a_short_line_refused(ratings: pd.DataFrame):
    page = from_file(ratings.to_csv(index=False, sep=";").encode())
    assert metrics(page)["participants"] == "16"
    from_file(csv(ratings) + b"P20,odd_pose,3\n", page=page)
    assert "line 322: expected 4 fields, as in the first line; found 3" in words(page)
    assert not page.radio
