"""The Alerts page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

import pytest
from places import SAMPLE
from streamlit.testing.v1 import AppTest

from nvcore.subjects.alerts.episodes import UNWANTED
from nvcore.subjects.alerts.policy import POLICIES, POLICY_SETTINGS, named_policy
from nvcore.subjects.alerts.steps import alerts_in
from pages import (
    alone,
    begin_with,
    checked,
    figures,
    measures,
    opened,
    press,
    rows,
    tables,
    texts,
    write,
)


@pytest.fixture(scope="module")
def page() -> AppTest:
    """The page on the sample with the balanced policy, to look at."""
    return checked(alone("alerts", alerts="policy").run())


def titles(page: AppTest) -> list[str]:
    return [figure["layout"]["meta"][0] for figure in figures(page)]


def kinds_of(page: AppTest) -> set[str | None]:
    return {widget.key for widget in page.segmented_control}


def marked(page: AppTest) -> list[str]:
    """The named policies that are marked as in use."""
    return [
        name
        for name in POLICIES
        if page.button(key=f"alerts_policy_{name}").proto.type == "primary"
    ]


def test_it_opens_with_the_balanced_policy_on_this_page_alone() -> None:
    page = checked(opened("alerts", is_folded=True))
    assert marked(page) == ["balanced"]
    assert "Shown on this page alone." in texts(page)
    assert "alerts_kind" in kinds_of(page)
    assert measures(page, "alerts")
    assert page.session_state["workspace"].result.params.alerts == "off"
    assert "alerts" not in page.query_params
    assert "alerts_policy_off" not in {button.key for button in page.button}
    press(page, "alerts_ask")
    assert page.session_state["workspace"].result.params.alerts == "policy"


def test_before_a_policy_is_chosen_its_sliders_act_on_the_page() -> None:
    page = checked(opened("alerts"))
    before = tables(page)[-1]
    checked(page.slider(key="alert_k").set_value(0.9).run())
    assert len(tables(page)[-1]) < len(before)
    assert marked(page) == []
    assert page.session_state["workspace"].result.params.alerts == "off"


def is_grey(page: AppTest, *names: str) -> set[bool]:
    """Whether the widgets of these settings are grey; the set has one entry where all agree."""
    kinds = ("slider", "checkbox", "selectbox")
    widgets = {widget.key: widget for kind in kinds for widget in page.get(kind)}
    found = [widgets.get(name) or widgets[f"{name}_unset"] for name in names]
    return {widget.disabled for widget in found}


def test_settings_without_effect_are_grey_and_the_page_has_buttons_for_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    page = checked(opened("alerts"))
    assert is_grey(page, *POLICY_SETTINGS, "foot_s", "own_reaction_s") == {False}
    assert is_grey(page, "alert_oracle", "own_reaction_sd_s", "limit_unit") == {True}
    assert "alerts" not in {widget.key for widget in page.selectbox}
    begin_with(SAMPLE.parent / "speed_signs" / "session.toml", monkeypatch)
    page = checked(opened("alerts"))
    assert is_grey(page, *POLICY_SETTINGS, "foot_s") == {True}
    assert is_grey(page, "limit_unit", "speeding_after_s") == {False}
    press(page, "alerts_policy_balanced")
    assert is_grey(page, *POLICY_SETTINGS) == {False}
    assert is_grey(page, "foot_s") == {True}  # a sign is never urgent


def test_a_named_policy_is_taken_for_all_pages_and_off_leaves_it_to_this_one() -> None:
    page = opened("alerts", is_folded=True, alert_score="0.9")
    assert marked(page) == []
    press(page, "alerts_policy_eager")
    params = page.session_state["workspace"].result.params
    assert "Shown on this page alone." not in texts(page)
    assert params.alerts == "policy"
    for name, value in named_policy("eager").items():
        assert getattr(params, name) == value
    assert page.button(key="alerts_policy_eager").proto.type == "primary"
    press(page, "alerts_policy_off")
    assert page.session_state["workspace"].result.params.alerts == "off"
    assert marked(page) == ["eager"]
    assert "Shown on this page alone." in texts(page)


def test_the_policy_in_use_is_marked_and_no_other(page: AppTest) -> None:
    assert marked(page) == ["balanced"]


def own_policy(folder: Path, monkeypatch: pytest.MonkeyPatch, *letters: str) -> AppTest:
    """The page while the systems of these letters have a policy of their own."""
    (folder / "fir.toml").write_text("alert_on_s = 100\n", encoding="utf-8")
    truth = rows(300)
    boxes = truth.replace(",1,0.9", ",0.9")
    session = write(folder, {"x": boxes, "y": boxes}, truth=truth)
    text = session.read_text(encoding="utf-8")
    for letter in letters:
        text = text.replace(f'name = "{letter}"', f'name = "{letter}"\nalert_policy = "fir.toml"')
    session.write_text(text, encoding="utf-8")
    begin_with(session, monkeypatch)
    return checked(alone("alerts", alerts="policy").run())


def test_a_system_with_a_policy_of_its_own_is_said_to_follow_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = own_policy(tmp_path, monkeypatch, "x")
    assert "X follows its own policy file fir.toml." in texts(page)
    assert "Each part of the policy of Y can be moved" in texts(page)
    press(page, "alerts_policy_eager")
    assert "X follows its own policy file" in texts(page)
    view = alerts_in(page.session_state["workspace"].result)
    assert len(view.of(view.result.x)) == 0
    assert len(view.of(view.result.y)) > 0


def test_where_both_have_a_policy_of_their_own_no_other_is_offered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = own_policy(tmp_path, monkeypatch, "x", "y")
    chosen = {button.key for button in page.button if str(button.key).startswith("alerts_policy")}
    assert chosen == {"alerts_policy_own", "alerts_policy_off"}
    assert "can be moved in the sidebar" not in texts(page)
    assert "There is no such alert: nothing would have reached the driver." in texts(page)


def test_it_lists_every_alert_and_those_of_a_kind(page: AppTest) -> None:
    result = page.session_state["workspace"].result
    view = alerts_in(result)
    assert len(tables(page)[-1]) == len(view.table)
    one = checked(alone("alerts", alerts="policy").run())
    kind = one.segmented_control(key="alerts_kind")
    n_false = int((view.table["kind"] == "false").sum())
    assert f"false ({n_false})" in kind.options
    kind.set_value("false").run()
    assert tables(checked(one))[-1]["kind"].tolist() == ["false"] * n_false


def test_the_list_begins_with_unwanted_alerts(page: AppTest) -> None:
    kinds = tables(page)[-1]["kind"].tolist()
    is_unwanted = [kind in UNWANTED for kind in kinds]
    assert is_unwanted[0]
    assert is_unwanted == sorted(is_unwanted, reverse=True)
    systems = tables(page)[-1]["system"].tolist()[: sum(is_unwanted)]
    assert systems == sorted(systems)  # else in the order in which they were


def test_an_alert_of_the_list_is_gone_to(page: AppTest) -> None:
    one = checked(alone("alerts", alerts="policy").run())
    view = alerts_in(one.session_state["workspace"].result)
    rows = [row for _, system in view.result.sides for row in view.rows_of_kind(system, *UNWANTED)]
    press(one, "alerts_next")
    press(one, "alerts_next")
    frames = view.result.dataset.frame_columns
    recording = int(frames.recording[rows[1]])
    assert one.session_state["place"] == (recording, rows[1] - int(frames.first[recording]))
    assert "**2** of" in texts(one)


def test_of_100_encounters_each_kind_of_alert_has_its_table(page: AppTest) -> None:
    assert titles(page)[1:] == ["Brakes in time, by kind of alert"]
    said = texts(page)
    assert (
        "Drivers brake in time in this share of 20 urgent encounters, with X and with Y: visual"
        in said
    )
    assert "With visual alerts, X" in said
    checked(page.segmented_control(key="alerts_reaction").set_value("haptic").run())
    assert "With haptic alerts, X" in texts(page)


def test_whom_the_driver_sees_is_undefined_where_it_is_not_known(page: AppTest) -> None:
    rows = measures(page, "alerts-hundred")
    assert rows["sees the pedestrian in time without an alert"] == ("–",) * 5
    assert rows["does not"] == ("–",) * 5
    assert rows["all"][0] == "100"
    assert "not known" not in rows


def test_where_nobody_is_urgent_no_share_is_invented() -> None:
    page = checked(alone("alerts", alerts="policy", speed_kmh="1", reaction_s="0").run())
    assert "Nobody is urgent at this speed" in texts(page)


def test_speed_signs_have_their_alerts_without_a_policy(monkeypatch: pytest.MonkeyPatch) -> None:
    begin_with(SAMPLE.parent / "speed_signs" / "session.toml", monkeypatch)
    page = checked(alone("alerts").run())
    assert page.header[0].value == "Above the limit"
    (episodes,) = tables(page)
    speeding = alerts_in(page.session_state["workspace"].result).speeding
    assert len(episodes) == len(speeding.episodes)
    assert {"called for", "right", "missed: not read"} <= {*episodes["state"]}
    press(page, "speeding_next")
    assert page.session_state["place"] == (0, 161)
