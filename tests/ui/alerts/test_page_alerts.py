"""The Alerts page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

import pytest
from places import SAMPLE
from streamlit.testing.v1 import AppTest

from nvcore.alerts.policy import POLICIES, named_policy
from nvcore.alerts.steps import alerts_in
from pages import alone, begin_with, checked, figures, opened, press, rows, tables, texts, write


@pytest.fixture(scope="module")
def page() -> AppTest:
    """The page on the sample with the balanced policy, to look at."""
    return checked(alone("alerts", alerts="policy").run())


def titles(page: AppTest) -> list[str]:
    return [figure["layout"]["meta"][0] for figure in figures(page)]


def test_without_a_policy_it_asks_for_one_and_a_named_one_is_taken() -> None:
    page = opened("alerts", is_folded=True, alert_score="0.9")
    assert "Alerts are off. Choose a policy to judge them." in texts(page)
    assert "alerts_kind" not in {widget.key for widget in page.segmented_control}
    press(page, "alerts_policy_eager")
    params = page.session_state["workspace"].result.params
    assert params.alerts == "policy"
    for name, value in named_policy("eager").items():
        assert getattr(params, name) == value
    assert page.button(key="alerts_policy_eager").proto.type == "primary"
    press(page, "alerts_policy_off")
    assert page.session_state["workspace"].result.params.alerts == "off"


def test_the_policy_in_use_is_marked_and_no_other(page: AppTest) -> None:
    marked = [
        name
        for name in POLICIES
        if page.button(key=f"alerts_policy_{name}").proto.type == "primary"
    ]
    assert marked == ["balanced"]


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


def test_an_alert_of_the_list_is_gone_to(page: AppTest) -> None:
    one = checked(alone("alerts", alerts="policy").run())
    view = alerts_in(one.session_state["workspace"].result)
    rows = view.of(view.result.x)["first_row"].tolist()
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
