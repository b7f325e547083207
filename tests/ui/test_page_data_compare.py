"""The Data page: who is X and Y, at which thresholds."""

from __future__ import annotations

from pathlib import Path

import pytest
from data_page import (
    answer,
    checked,
    opened,
    opened_drive,
    press,
    send,
    texts,
)
from inputs import drive


@pytest.fixture(autouse=True)
def surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))
    monkeypatch.delenv("NVCORE_LOCAL_ROOT", raising=False)


def test_choosing_x_as_y_swaps_them():
    page = opened()
    checked(page.selectbox(key="choice_y").set_value("FIR").run())
    assert (page.selectbox(key="choice_x").value, page.selectbox(key="choice_y").value) == (
        "NIR", "FIR",
    )  # fmt: skip


def test_swapping_takes_the_thresholds_along():
    page = opened()
    checked(page.number_input(key="data_threshold_x").set_value(0.7).run())
    before = page.number_input(key="data_threshold_y").value
    press(page, "swap_systems")
    assert page.number_input(key="data_threshold_y").value == 0.7
    assert page.number_input(key="data_threshold_x").value == before


def test_a_threshold_changes_what_is_kept():
    page = opened()
    before = page.metric[0].value
    checked(page.number_input(key="data_threshold_x").set_value(0.99).run())
    kept = int(page.metric[0].value.split(" of ")[0].replace(",", ""))
    assert kept < int(before.split(" of ")[0].replace(",", ""))


def test_the_same_operating_point_sets_the_threshold_of_y():
    page = opened()
    checked(page.number_input(key="data_threshold_x").set_value(0.9).run())
    press(page, "same_point")
    assert "false alarms per frame, X has" in texts(page)
    assert page.number_input(key="data_threshold_y").value > 0.5


def test_the_same_operating_point_may_lie_above_the_highest_score(tmp_path: Path):
    drive(tmp_path)
    with (tmp_path / "nir.csv").open("a") as stream:  # the best score is a false alarm
        stream.write("rural,5,500,200,40,100,0.95\n")
    page = opened()
    for key, name in (("truth", "truth"), ("system_0", "fir"), ("system_1", "nir")):
        send(page, f"upload_{key}", (f"{name}.csv", (tmp_path / f"{name}.csv").read_bytes()))
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    press(page, "same_point")
    assert page.session_state["params"].threshold_y > 0.95
    assert "0 false alarms per frame, X has 0." in texts(page)
    assert [one.value for one in page.metric if "False alarms" in one.label] == ["0.0", "0.0"]


def test_rates_per_frame_stand_beside_those_per_minute_and_episodes_are_set_apart():
    told = texts(opened())
    assert "per frame; 57 in all" in told
    assert "false-alert episodes, false alarms linked over frames" in told


def test_a_system_without_scores_takes_no_operating_point(tmp_path: Path):
    drive(tmp_path)
    rows = (tmp_path / "nir.csv").read_text().splitlines()
    bare = "\n".join(row.rpartition(",")[0] for row in rows).encode()
    page = opened()
    for key, content in (
        ("truth", (tmp_path / "truth.csv").read_bytes()),
        ("system_0", (tmp_path / "fir.csv").read_bytes()),
        ("system_1", bare),
    ):
        send(page, f"upload_{key}", (f"{key}.csv", content))
    checked(page.run())
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert page.button(key="same_point").disabled
    assert "swap the two to move the other one" in texts(page)


def test_after_opening_it_is_said_that_thresholds_are_still_to_be_chosen(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv", "nir.csv")
    assert "until thresholds are set under Compare" in texts(page)


def test_thresholds_of_the_session_need_no_reminder():
    page = press(opened(), "open_sample")
    assert "Opened: Sample recordings" in texts(page)
    assert "until thresholds are set" not in texts(page)
