"""Parameters are read before the page is drawn and outlive whatever the sidebar shows."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from nvcore.params import Params
from pages import FRAMES, begin_with, checked, opened, rows, to_page, write
from ui.session import state
from ui.session.workspace import Opened


def app(**query: str) -> AppTest:
    return checked(opened(**query))


def live(page: AppTest) -> Params:
    return page.session_state["params"]


def test_a_value_beyond_the_slider_stays_as_it_was_moved_to():
    page = app(midpoint="10000")
    assert live(page).midpoint == 10000
    checked(page.slider(key="midpoint").set_value(5000.0).run())
    checked(page.slider(key="alpha").set_value(0.5).run())
    assert live(page).midpoint == 5000
    assert page.slider(key="midpoint").value == 5000


def test_a_threshold_above_all_scores_can_be_moved_back_to_them():
    page = app(threshold_x="2")
    checked(page.slider(key="threshold_x").set_value(0.5).run())
    checked(page.slider(key="alpha").set_value(0.5).run())
    assert live(page).threshold_x == 0.5


def test_folded_parameters_of_a_link_are_kept_through_runs_and_unfolding():
    page = app(low="0.8", lag_s="1.5")
    checked(page.slider(key="alpha").set_value(0.5).run())
    assert (live(page).low, live(page).lag_s) == (0.8, 1.5)
    page.session_state["advanced"] = True
    checked(page.run())
    assert page.slider(key="low").value == 0.8
    checked(page.slider(key="low").set_value(0.7).run())
    page.session_state["advanced"] = False
    checked(page.run())
    checked(page.slider(key="alpha").set_value(0.4).run())
    assert (live(page).low, live(page).lag_s, live(page).alpha) == (0.7, 1.5, 0.4)


def test_reset_takes_folded_parameters_back_as_well():
    page = app(low="0.8", alpha="0.3")
    reset = next(one for one in page.button if one.label == "Reset all parameters")
    checked(reset.click().run())
    assert (live(page).low, live(page).alpha) == (Params().low, Params().alpha)


def test_a_slider_that_is_not_drawn_keeps_its_value():
    page = app(midpoint="70")
    checked(page.selectbox(key="proximity").set_value("distance").run())
    checked(page.slider(key="alpha").set_value(0.5).run())
    checked(page.selectbox(key="proximity").set_value("height").run())
    assert page.slider(key="midpoint").value == 70


def test_a_preset_is_in_use_in_the_same_run():
    page = app()
    checked(page.button(key="preset_Rural").click().run())
    assert live(page).edge_weight == page.slider(key="edge_weight").value > 0


@pytest.mark.parametrize("value", ["inf", "-inf", "nan"])
def test_a_link_to_no_number_is_told_and_the_sidebar_is_whole(value: str):
    page = app(threshold_x=value)
    assert "threshold_x is not possible" in page.warning[0].value
    assert any(one.label == "Reset all parameters" for one in page.button)


def test_a_threshold_does_not_stick_to_a_system_without_scores_that_differ(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    scored = "".join(f"night,{frame},300,200,40,120,0.{frame % 9}\n" for frame in FRAMES)
    constant = "".join(f"night,{frame},300,200,40,120,0.3\n" for frame in FRAMES)
    session = write(tmp_path, {"one": scored, "two": constant}, truth=rows(300))
    begin_with(session, monkeypatch)
    page = app()
    checked(page.slider(key="threshold_x").set_value(0.5).run())
    checked(to_page(page, "data"))
    swap = next(one for one in page.button if "Swap" in one.label)
    checked(swap.click().run())
    assert live(page).threshold_x is None

    assert "30 of 30" in [one.value for one in page.metric]


def test_whatever_cuts_off_the_opening_of_a_session_leaves_the_app_alive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """The new data are in, and the run that would have reset place and parameters never ended."""
    page = app(recording="winter_frost", alpha="0.3")
    boxes = "".join(f"night,{frame},300,200,40,120,0.5\n" for frame in FRAMES)
    other = write(tmp_path, {"one": boxes, "two": boxes}, truth=rows(300))
    space = page.session_state["workspace"]
    session = read_session(other)
    state._open(space, Opened(session, load(session), "Other"))
    checked(page.run())
    assert page.session_state["place"] == (0, 0)
    assert live(page).alpha == Params().alpha


def test_without_a_horizon_the_last_settings_stay_and_the_sidebar_asks_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    boxes = "".join(f"night,{frame},300,200,40,120,0.{frame % 9}\n" for frame in FRAMES)
    session = write(tmp_path, {"one": boxes, "two": boxes}, truth=rows(300))
    begin_with(session, monkeypatch)
    page = app()
    checked(page.selectbox(key="proximity").set_value("horizon").run())
    assert "type it above" in page.error[0].value
    assert live(page).proximity == "height"
    checked(page.number_input(key="horizon").set_value(150.0).run())
    assert not page.error
    assert (live(page).proximity, live(page).horizon) == ("horizon", 150)


def test_a_page_that_fails_leaves_the_parameters_as_they_were(monkeypatch: pytest.MonkeyPatch):
    page = app()
    checked(page.slider(key="alpha").set_value(0.5).run())
    checked(page.slider(key="threshold_x").set_value(0.6).run())
    before = live(page)

    def fail(*_arguments: object) -> None:
        raise IndexError("no such row")

    with monkeypatch.context() as patch:
        patch.setattr("ui.overview.scorecard.scorecard", fail)
        page.run()
        assert "a fault of the program" in page.error[0].value
        assert page.slider(key="alpha").value == 0.5
    checked(page.run())
    assert live(page) == before
    assert page.slider(key="threshold_x").value == 0.6
