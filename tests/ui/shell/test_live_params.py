"""Parameters are read before the page is drawn and outlive whatever the sidebar shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import streamlit as st
from data_page import COMPARING
from data_page import opened as data_opened
from streamlit.testing.v1 import AppTest

from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.settings.params import SETTINGS, Params
from nvcore.settings.stages import MATCH, PROXIMITY, Stage
from pages import FRAMES, begin_with, checked, opened, press, rows, shown, sidebar, texts, write
from ui.session import settings
from ui.session.sample import shown_in
from ui.session.workspace import Opened
from ui.shell import live as live_sliders
from ui.shell import pages

SCORED, CONSTANT = (
    "".join(f"night,{frame},300,200,40,120,0.{frame % n}\n" for frame in FRAMES) for n in (9, 1)
)


def show(stages: tuple[Stage, ...] | None, monkeypatch: pytest.MonkeyPatch) -> None:
    page = replace(pages.PAGE_OF["metrics"], shown=stages)
    monkeypatch.setitem(pages.PAGE_OF, "metrics", page)


@pytest.fixture
def every_setting_acts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page shows nothing of the comparison: no setting acts on it."""
    show(None, monkeypatch)


pytestmark = pytest.mark.usefixtures("every_setting_acts")


def is_changed(page: AppTest, name: str) -> bool:
    return f"reset_{name}" in [button.key for button in page.button]


def live(page: AppTest) -> Params:
    return page.session_state["params"]


def test_values_beyond_the_sliders_stay_and_can_be_moved():
    page = sidebar(midpoint="10000", threshold_x="2")
    assert live(page).midpoint == 10000
    checked(page.slider(key="midpoint").set_value(5000.0).run())
    checked(page.slider(key="threshold_x").set_value(0.5).run())
    checked(page.slider(key="alpha").set_value(0.5).run())
    assert live(page).midpoint == page.slider(key="midpoint").value == 5000
    assert live(page).threshold_x == 0.5
    checked(page.slider(key="threshold_x").set_value(page.slider(key="threshold_x").min).run())
    assert live(page).threshold_x is None  # the lowest threshold counts every detection


def test_folded_parameters_of_a_link_are_kept_through_runs_and_unfolding():
    page = sidebar(low="0.8", lag_s="1.5")
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


def test_a_slider_that_is_not_drawn_keeps_its_value():
    page = sidebar(midpoint="70")
    checked(page.selectbox(key="proximity").set_value("distance").run())
    assert page.slider(key="midpoint_m").value == 35.0
    assert live(page).proximity == "distance"
    checked(page.slider(key="alpha").set_value(0.5).run())
    checked(page.selectbox(key="proximity").set_value("height").run())
    assert page.slider(key="midpoint").value == 70


def test_the_sigmoid_is_that_of_each_recording_until_it_is_moved():
    page = sidebar()
    assert live(page).midpoint is None
    checked(page.slider(key="midpoint").set_value(60.0).run())
    assert live(page).midpoint == 60.0


def test_sliders_start_at_their_values_in_every_run():
    """A browser may miss the run that sets them, where the next one overtakes it."""
    page = checked(sidebar(alpha="0.4").run())
    for name, value in (("alpha", 0.4), ("midpoint", 48.0), ("threshold_x", 0.5)):
        assert list(page.slider(key=name).proto.default) == [value]


def test_presets_and_resets_are_in_use_in_the_same_run():
    page = sidebar(low="0.8", alpha="0.3")
    checked(shown(page, "button_group", "preset").set_value("Rural").run())
    assert live(page).edge_weight == page.slider(key="edge_weight").value == 1
    assert page.slider(key="midpoint").value == pytest.approx(28.8)
    reset = next(button for button in page.button if button.label == "Reset all parameters")
    checked(reset.click().run())
    assert live(page) == page.session_state["workspace"].opened.dataset.params_of()
    assert shown(page, "checkbox", "edge_weight_unset").value
    assert page.slider(key="midpoint").value == 48.0


def test_a_link_to_no_number_is_told_and_the_sidebar_is_whole():
    page = sidebar(threshold_x="inf", alpha="seven", recording="<script>")
    for wrong in ("threshold_x is not possible", "alpha is not possible", "no such recording"):
        assert wrong in page.session_state["bad_link"]
    assert page.slider(key="alpha").value == 0.9
    assert any(button.label == "Reset all parameters" for button in page.button)


def test_a_threshold_below_all_scores_is_no_changed_setting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = write(tmp_path, {"one": SCORED, "two": SCORED}, truth=rows(300))
    text = session.read_text()
    session.write_text(text.replace('"two.csv"', '"two.csv"\nthreshold = 0'))
    begin_with(session, monkeypatch)
    page = sidebar()
    assert live(page).threshold_y == 0
    assert not is_changed(page, "threshold_y")
    assert "Every detection of Y counts." in texts(page)
    checked(page.slider(key="threshold_y").set_value(0.6).run())
    assert is_changed(page, "threshold_y")
    press(page, "reset_threshold_y")
    assert live(page).threshold_y == 0
    assert not is_changed(page, "threshold_y")


def test_a_threshold_does_not_stick_to_a_system_without_scores_that_differ(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = write(tmp_path, {"one": SCORED, "two": CONSTANT}, truth=rows(300))
    begin_with(session, monkeypatch)
    page = data_opened(*COMPARING)
    checked(page.slider(key="threshold_x").set_value(0.5).run())
    press(page, "sidebar_swap")
    assert live(page).threshold_x is None
    assert "30 of 30" in page.table[0].value["Detections kept"].tolist()


def test_whatever_cuts_off_the_opening_of_a_session_leaves_the_app_alive(tmp_path: Path):
    """The new data are in, and the run that would have reset place and parameters never ended."""
    page = sidebar(recording="winter_frost", alpha="0.3")
    other = write(tmp_path, {"one": CONSTANT, "two": CONSTANT}, truth=rows(300))
    space = page.session_state["workspace"]
    session = read_session(other)
    shown_in(space, Opened.of(session, load(session), "Other"))
    checked(page.run())
    assert page.session_state["place"] == (0, 0)
    assert live(page).alpha == Params().alpha


def test_without_a_horizon_the_last_settings_stay_and_the_sidebar_asks_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = write(tmp_path, {"one": SCORED, "two": SCORED}, truth=rows(300))
    begin_with(session, monkeypatch)
    page = sidebar()
    checked(page.selectbox(key="proximity").set_value("horizon").run())
    assert "type it above" in page.error[0].value
    assert live(page).proximity == "height"
    checked(page.number_input(key="horizon").set_value(150.0).run())
    assert not page.error
    assert (live(page).proximity, live(page).horizon) == ("horizon", 150)


def test_a_page_that_fails_leaves_the_parameters_as_they_were(monkeypatch: pytest.MonkeyPatch):
    page = checked(opened(alpha="0.5", threshold_x="0.6"))
    before = live(page)

    def fail(*_arguments: object) -> None:
        raise IndexError("no such row")

    with monkeypatch.context() as patch:
        patch.setattr("ui.views.overview.scorecard.Scorecard", fail)
        page.run()
        assert "a fault of the program" in page.error[0].value
        assert page.slider(key="alpha").value == 0.5
    checked(page.run())
    assert live(page) == before
    assert page.slider(key="threshold_x").value == 0.6


def test_without_a_value_the_traffic_context_is_as_the_recordings_say():
    page = sidebar()
    assert live(page).edge_weight is None
    assert "edge_weight" not in [slider.key for slider in page.slider]
    checked(shown(page, "checkbox", "edge_weight_unset").uncheck().run())
    assert live(page).edge_weight == page.slider(key="edge_weight").value == 0
    checked(page.slider(key="edge_weight").set_value(0.4).run())
    checked(page.slider(key="alpha").set_value(0.5).run())
    assert (live(page).edge_weight, live(page).alpha) == (0.4, 0.5)
    checked(shown(page, "checkbox", "edge_weight_unset").check().run())
    checked(page.slider(key="alpha").set_value(0.6).run())
    assert (live(page).edge_weight, live(page).alpha) == (None, 0.6)


def test_a_link_keeps_its_traffic_context_and_the_default_clears_it():
    page = sidebar(edge_weight="0.3")
    assert live(page).edge_weight == page.slider(key="edge_weight").value == 0.3
    checked(shown(page, "button_group", "preset").set_value("Default").run())
    assert live(page).edge_weight is None


def test_a_link_can_clear_the_traffic_context_of_a_session(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = write(tmp_path, {"one": SCORED, "two": SCORED}, truth=rows(300))
    session.write_text(session.read_text() + "[parameters]\nedge_weight = 0.7\n")
    begin_with(session, monkeypatch)
    page = sidebar()
    assert live(page).edge_weight == page.slider(key="edge_weight").value == 0.7
    checked(shown(page, "checkbox", "edge_weight_unset").check().run())
    assert live(page).edge_weight is None
    assert live(sidebar(edge_weight="none")).edge_weight is None


def test_a_link_of_which_every_detection_counts_does_so_where_a_threshold_is_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = write(tmp_path, {"one": SCORED, "two": SCORED}, truth=rows(300))
    session.write_text(session.read_text() + "[parameters]\nthreshold_x = 0.5\n")
    begin_with(session, monkeypatch)
    assert live(sidebar()).threshold_x == 0.5
    assert live(sidebar(threshold_x="none")).threshold_x is None


def test_recency_shows_the_sliders_of_its_unit():
    page = sidebar(recency_unit="seconds", recency_midpoint_s="5", recency_midpoint="0.7")
    page.session_state["advanced"] = True
    checked(page.run())
    keys = {slider.key for slider in page.slider}
    assert {"recency_midpoint_s", "recency_spread_s"} < keys
    assert {"recency_midpoint", "recency_spread", "lateral_tolerance"}.isdisjoint(keys)
    assert page.slider(key="recency_midpoint_s").value == 5
    checked(page.selectbox(key="recency_unit").set_value("share").run())
    assert page.slider(key="recency_midpoint").value == 0.7
    assert live(page).recency_midpoint_s == 5


def test_settings_are_grey_where_they_act_on_nothing(monkeypatch: pytest.MonkeyPatch):
    show((MATCH, PROXIMITY), monkeypatch)
    page = sidebar()
    page.session_state["advanced"] = True
    checked(page.run())
    is_grey = {slider.key: slider.disabled for slider in page.slider}
    assert shown(page, "checkbox", "edge_weight_unset").disabled
    grey = {name for name, disabled in is_grey.items() if disabled}
    assert {"alpha", "tolerance", "recency_midpoint"} < grey
    assert {"iou", "midpoint", "spread", "threshold_x"}.isdisjoint(grey)
    assert "Grey: no effect on this page." in page.slider(key="alpha").help
    assert "Acts on: matches and false alarms, similarity" in page.slider(key="iou").help
    assert "grey have no effect" in texts(page)


def test_grey_settings_are_spoken_of_only_where_some_are_in_sight(monkeypatch: pytest.MonkeyPatch):
    main = tuple({setting.stage for setting in SETTINGS.values() if not setting.is_advanced})
    assert any(not setting.moves(main) for setting in SETTINGS.values())  # advanced ones
    show(main, monkeypatch)
    page = sidebar()
    assert "grey have no effect" not in texts(page)
    page.session_state["advanced"] = True
    assert "grey have no effect" in texts(checked(page.run()))


def test_every_page_of_a_comparison_has_settings_that_act():
    idle = [key for key, page in pages.PAGE_OF.items() if page.shown == ()]
    assert idle == ["detectors", "study"]


def test_the_costs_by_place_are_drawn_once_unfolded_and_say_what_they_follow_from():
    page = sidebar()
    assert "k × border" not in texts(page)
    page.session_state["cost_map"] = True
    checked(page.run())
    assert "Height by foot row, a line through" in texts(page)
    checked(page.selectbox(key="proximity").set_value("none").run())
    assert "Everybody weighs the same" in texts(page)


def test_a_slider_in_motion_acts_until_it_is_let_go_and_is_not_moved():
    page = sidebar(alpha="0.4")
    page.session_state["settings"] = {"alpha": 0.75}  # as `settings.drag` does
    page.session_state["settings_moving"] = ("alpha", 0.4)
    for _ in range(2):  # in whatever else causes a run, too
        checked(page.run())
        assert live(page).alpha == 0.75
        assert page.slider(key="alpha").value == 0.4  # to Streamlit
    checked(page.slider(key="alpha").set_value(0.8).run())
    assert live(page).alpha == page.slider(key="alpha").value == 0.8


def test_a_slider_that_was_let_go_has_its_own_value_though_another_was_on_its_way(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(st, "session_state", {"alpha": 0.4})
    live_sliders.note({"name": "alpha", "value": 0.7, "id": 1})
    st.session_state["alpha"] = 0.8  # both reach the server before it runs
    settings.take("alpha")
    live_sliders.note({"name": "alpha", "value": 0.75, "id": 2})
    assert settings.kept("alpha", None) == 0.8


def test_a_widget_of_what_others_changed_is_another_one(monkeypatch: pytest.MonkeyPatch):
    """The browser may still send what it had before, as if a person had chosen it."""
    monkeypatch.setattr(st, "session_state", {})
    first = settings.key_of("preset", "Default")
    st.session_state[first] = "Rural"  # a person chooses
    assert settings.key_of("preset", "Rural") == first
    second = settings.key_of("preset", None)  # a slider was moved
    assert second != first
    assert settings.key_of("preset", None) == second
    assert settings.key_of("preset", "Rural") not in (first, second)


def test_what_a_browser_still_sends_of_a_replaced_widget_is_no_choice(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(st, "session_state", {})
    first = settings.key_of("preset", "Default")
    st.session_state[first] = "Rural"
    assert settings.is_chosen("preset", first)
    second = settings.key_of("preset", None)  # a slider was moved
    assert not settings.is_chosen("preset", first)  # which "Rural" would take back
    st.session_state |= {first: "Default", second: "Default"}
    assert settings.is_chosen("preset", second)
    assert settings.is_chosen("preset", first)  # pressed before the browser drew the other one


@pytest.mark.parametrize(
    "sent",
    [
        None,
        "alpha",
        {"name": "alpha", "value": 7.0, "id": 1},
        {"name": "alpha", "value": float("nan"), "id": 1},
        {"name": "alpha", "value": True, "id": 1},
        {"name": "alpha", "value": "0.5", "id": 1},
        {"name": "workspace", "value": 0.5, "id": 1},
        {"name": ["alpha"], "value": 0.5, "id": 1},
    ],
)
def test_what_a_browser_sends_of_a_slider_is_checked(sent, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(st, "session_state", {})
    live_sliders.note(sent)
    assert settings.kept("alpha", None) is None
