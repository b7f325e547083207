"""The sidebar: X and Y on every page, operating points, presets, and what was changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from inputs import drive, session_of
from streamlit.testing.v1 import AppTest
from streamlit.testing.v1.element_tree import NumberInput

from nvcore.metrics.detection.operating_point import threshold_with_alarms
from pages import FRAMES, begin_with, checked, press, rows, shown, sidebar, texts, write
from ui.shell import pages
from ui.shell.operating_point import RATE, points


@pytest.fixture
def every_setting_acts(monkeypatch: pytest.MonkeyPatch) -> None:
    page = replace(pages.PAGE_OF["metrics"], shown=None)
    monkeypatch.setitem(pages.PAGE_OF, "metrics", page)


def legend(page: AppTest) -> str:
    return " ".join(item.proto.body for item in page.get("html"))


def keys(page: AppTest) -> set[str | None]:
    return {widget.key for kind in ("slider", "button", "selectbox") for widget in page.get(kind)}


def rates(page: AppTest) -> str:
    return next(text.value for text in page.caption if "False boxes per frame" in text.value)


def test_where_no_setting_acts_they_are_folded_away_and_x_and_y_stay():
    page = sidebar(is_folded=True, alpha="0.4", low="0.8")
    assert "FIR" in legend(page)
    assert "NIR" in legend(page)
    assert "alpha" not in keys(page)
    assert "threshold_x" not in keys(page)
    toggle = page.toggle(key="show_settings")
    assert toggle.label == "Settings (2 changed)"
    assert page.session_state["params"].alpha == 0.4
    checked(toggle.set_value(True).run())
    assert page.slider(key="alpha").value == 0.4
    checked(page.toggle(key="show_settings").set_value(False).run())
    assert (page.session_state["params"].alpha, page.session_state["params"].low) == (0.4, 0.8)


def test_the_settings_are_folded_where_they_move_little_or_nothing():
    folded = {key for key, page in pages.PAGE_OF.items() if page.is_folded or page.shown == ()}
    assert folded == {"detectors", "study", "ratings", "export", "metrics"}


def test_x_and_y_are_swapped_beside_their_names():
    page = press(sidebar(is_folded=True, threshold_x="0.7"), "sidebar_swap")
    assert legend(page).index("NIR") < legend(page).index("FIR")
    assert page.session_state["params"].threshold_y == 0.7
    assert ("".join(page.query_params["x"]) if "x" in page.query_params else "NIR") == "NIR"


@pytest.mark.usefixtures("every_setting_acts")
@pytest.mark.parametrize(("letter", "other"), [("x", "y"), ("y", "x")])
def test_a_threshold_moves_to_the_false_alarms_of_the_other_and_back(letter: str, other: str):
    page = sidebar(threshold_x="0.7", threshold_y="0.3")
    before = page.session_state["params"]
    press(page, f"point_{letter}")
    space, after = page.session_state["workspace"], page.session_state["params"]
    dataset = space.opened.dataset
    fixed = space.result.system(other)
    n_target = int(fixed.matches.is_false_alarm.sum())
    name = space.result.system(letter).name
    assert getattr(after, f"threshold_{letter}") == pytest.approx(
        threshold_with_alarms(dataset, name, before, n_target)
    )
    assert getattr(after, f"threshold_{other}") == getattr(before, f"threshold_{other}")
    old, new = getattr(before, f"threshold_{letter}"), getattr(after, f"threshold_{letter}")
    assert f"{letter.upper()}: threshold {old:.4g} → {new:.4g}" in texts(page)
    press(page, "point_undo_sidebar")
    assert page.session_state["params"] == before
    assert "→" not in texts(page)


@pytest.mark.usefixtures("every_setting_acts")
def test_where_no_threshold_comes_nearer_it_says_so():
    page = press(sidebar(), "point_x")
    assert "X stays at the threshold 0.5" in texts(page)


def rate_field(page: AppTest) -> NumberInput:
    """The field for the false alarms an hour of both."""
    return next(field for field in page.number_input if field.key.startswith(RATE))


@pytest.mark.usefixtures("every_setting_acts")
def test_both_get_as_many_false_alarms_as_are_asked_for_until_a_threshold_moves_again():
    page = sidebar()
    rate_field(page).set_value(0.2)
    press(page, "point_set")
    result = page.session_state["workspace"].result
    n_frames = len(result.dataset.frames)
    for system in (result.x, result.y):
        assert system.matches.is_false_alarm.sum() == pytest.approx(0.2 * n_frames, abs=2)
    assert "X: threshold 0.5 →" in texts(page)
    assert "Y: threshold 0.5 →" in texts(page)
    checked(page.slider(key="threshold_x").set_value(0.9).run())
    assert "→" not in texts(page)  # it no longer says what is in use


@pytest.mark.usefixtures("every_setting_acts")
def test_the_rate_for_both_begins_with_the_lower_one_of_each_comparison():
    page = sidebar()
    starts = {rate_field(page).value}
    rate_field(page).set_value(0.2)
    checked(page.slider(key="threshold_x").set_value(0.9).run())
    result = page.session_state["workspace"].result
    lower = min(point.false_alarms_per_frame for point in points(result))
    assert rate_field(page).value == round(lower, 3)
    assert rate_field(page).value not in starts | {0.2}


@pytest.mark.usefixtures("every_setting_acts")
def test_without_scores_the_buttons_are_disabled_and_say_why(tmp_path: Path, monkeypatch):
    scored, constant = (
        "".join(f"night,{frame},300,200,40,120,0.{frame % n}\n" for frame in FRAMES) for n in (9, 1)
    )
    begin_with(write(tmp_path, {"one": scored, "two": constant}, truth=rows(300)), monkeypatch)
    page = sidebar()
    assert not page.button(key="point_x").disabled
    assert page.button(key="point_y").disabled
    assert "Y has no scores that differ" in page.button(key="point_y").help
    assert "point_set" not in keys(page)
    assert "False boxes per frame: X" in rates(page)


@pytest.mark.usefixtures("every_setting_acts")
def test_the_preset_in_use_is_marked_and_what_was_moved_away_can_be_taken_back():
    page = sidebar()
    preset = shown(page, "button_group", "preset")
    assert preset.value == "Default"
    assert "●" not in page.slider(key="alpha").label
    checked(page.slider(key="alpha").set_value(0.5).run())
    preset = shown(page, "button_group", "preset")
    assert (preset.value, preset.label) == (None, "Preset: custom")
    assert "●" in page.slider(key="alpha").label
    assert page.button(key="reset_alpha").label.endswith("0.5, back to 0.9")
    press(page, "reset_alpha")
    assert shown(page, "button_group", "preset").value == "Default"
    assert "reset_alpha" not in keys(page)


@pytest.mark.usefixtures("every_setting_acts")
def test_what_was_moved_is_told_against_the_preset_that_was_chosen_last():
    page = sidebar()
    checked(shown(page, "button_group", "preset").set_value("Rural").run())
    assert shown(page, "button_group", "preset").value == "Rural"
    assert {key for key in keys(page) if str(key).startswith("reset_")} == set()
    checked(page.slider(key="midpoint").set_value(60.0).run())
    assert "●" in page.slider(key="midpoint").label
    press(page, "reset_midpoint")
    assert page.slider(key="midpoint").value == pytest.approx(28.8)
    assert shown(page, "button_group", "preset").value == "Rural"


@pytest.mark.usefixtures("every_setting_acts")
@pytest.mark.parametrize("is_known", [True, False])
def test_settings_of_the_driver_are_there_where_detectability_is_known(
    is_known: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    truth = drive(tmp_path) / "truth.csv"
    lines = truth.read_text(encoding="utf-8").splitlines()
    stated = [lines[0] + ",detectability", *(f"{line},0.5" for line in lines[1:])]
    if is_known:
        truth.write_text("\n".join(stated), encoding="utf-8")
    begin_with(session_of(tmp_path), monkeypatch)
    page = sidebar()
    page.session_state["advanced"] = True
    page = checked(page.run())
    assert ("**The driver**" in [text.value for text in page.markdown]) is is_known
    assert ("driver_threshold" in keys(page)) is is_known
    assert ("driver_weighting" in keys(page)) is is_known


@pytest.mark.usefixtures("every_setting_acts")
@pytest.mark.parametrize(
    ("alpha", "words"), [(0.9, "No setting changed"), (0.4, "Settings of the session")]
)
def test_settings_that_the_session_gives_are_named(
    alpha: float, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = session_of(drive(tmp_path))
    params = replace(session.params, alpha=alpha)
    begin_with(replace(session, params=params), monkeypatch)
    assert words in [popover.proto.popover.label for popover in sidebar().get("popover")]
