"""The Data page: who is X and Y, at which thresholds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from data_page import answer, opened, opened_drive, press, send
from inputs import drive
from streamlit.testing.v1 import AppTest

from nvcore.dataset import dataset_from_tables
from pages import checked, texts
from ui.shell.messages import sampling_note


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
    checked(page.number_input(key="data_threshold_x").set_value(0.75).run())
    press(page, "same_point")
    assert page.session_state["params"].threshold_y > 0.95
    assert "Y was moved." in texts(page)
    assert "0 false alarms per frame, X has 0." in texts(page)
    assert [one.value for one in page.metric if "False alarms" in one.label] == ["0.0", "0.0"]


def test_rates_per_frame_stand_beside_those_per_minute_and_episodes_are_set_apart():
    told = texts(opened())
    assert "per frame; 57 in all" in told
    assert "false-alert episodes, false alarms linked over frames" in told


def without_scores(file: Path) -> bytes:
    rows = file.read_text().splitlines()
    return "\n".join(row.rpartition(",")[0] for row in rows).encode()


def page_of(folder: Path, *systems: bytes) -> AppTest:
    """The drive's ground truth with these systems, opened."""
    page = opened()
    send(page, "upload_truth", ("truth.csv", (folder / "truth.csv").read_bytes()))
    for number, content in enumerate(systems):
        send(page, f"upload_system_{number}", (f"{number}.csv", content))
    checked(page.run())
    answer(page, width=640, height=480, fps=20.0)
    return press(page, "open_upload")


def test_where_y_has_no_scores_x_is_moved_to_its_operating_point(tmp_path: Path):
    drive(tmp_path)
    y = without_scores(tmp_path / "nir.csv")
    alarms = "".join(f"urban,{frame},500,200,40,100,0.{frame}\n" for frame in range(10, 20))
    page = page_of(tmp_path, (tmp_path / "fir.csv").read_bytes() + alarms.encode(), y)
    assert "X is moved to Y's false alarms instead" in texts(page)
    press(page, "same_point")
    assert page.session_state["params"].threshold_x == pytest.approx(0.19)
    assert page.session_state["params"].threshold_y is None
    assert "X was moved. Now X has the threshold 0.19: 0.025 false alarms per frame" in texts(page)


def test_where_neither_has_scores_nothing_is_moved(tmp_path: Path):
    drive(tmp_path)
    page = page_of(tmp_path, *(without_scores(tmp_path / name) for name in ("fir.csv", "nir.csv")))
    assert page.button(key="same_point").disabled
    assert "Neither system has scores that differ" in texts(page)


def test_where_x_has_no_scores_y_is_moved_to_it_as_it_is(tmp_path: Path):
    drive(tmp_path)
    x = without_scores(tmp_path / "fir.csv")
    page = page_of(tmp_path, x, (tmp_path / "nir.csv").read_bytes())
    press(page, "same_point")
    assert "Y was moved." in texts(page)


def test_the_same_operating_point_waits_for_a_threshold_of_x(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv", "nir.csv")
    assert page.button(key="same_point").disabled
    assert "First set a score threshold of X" in texts(page)
    checked(page.number_input(key="data_threshold_x").set_value(0.8).run())
    assert not page.button(key="same_point").disabled
    assert "First set a score threshold of X" not in texts(page)


def test_rates_of_sampled_frames_say_what_they_count():
    page = opened()
    assert "frame is evaluated" not in texts(page)
    frames = range(9, 209, 20)
    truth = "frame,x,y,w,h\n" + "".join(f"{frame},100,100,40,90\n" for frame in frames)
    found = "frame,x,y,w,h,score\n" + "".join(f"{frame},9,9,40,90,0.5\n" for frame in frames)
    send(page, "upload_truth", ("t.csv", truth.encode()))
    send(page, "upload_system_0", ("a.csv", found.encode()))
    checked(page.run())
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    told = "Only every 20th frame is evaluated: per minute and per hour count those frames alone."
    assert told in texts(page)


@pytest.mark.parametrize(
    ("steps", "note"),
    [
        ([1, 1], ""),
        ([], ""),
        ([5, 1], "Only every 5th frame of 1 of 2 recordings is evaluated"),
        ([2, 20], "Only every 2nd to 20th frame is evaluated"),
    ],
)
def test_recordings_sampled_differently_are_told_apart(steps: list[int], note: str):
    numbers = [np.arange(0, 10 * step, step) for step in steps]
    table = pd.DataFrame({"name": [str(at) for at in range(len(steps))]})
    table = table.assign(width=640.0, height=480.0, fps=20.0)
    boxes = pd.DataFrame({name: [] for name in ("source", "frame_index", "x", "y", "w", "h")})
    dataset = dataset_from_tables(table, numbers, boxes, ["a"])
    found = sampling_note(dataset.frame_columns)
    assert found.startswith(note)
    assert bool(found) == bool(note)


def test_after_opening_it_is_said_that_thresholds_are_still_to_be_chosen(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv", "nir.csv")
    assert "until thresholds are set under “Compare”" in texts(page)


def test_thresholds_of_the_session_need_no_reminder():
    page = press(opened(), "open_sample")
    assert "Opened: Sample recordings" in texts(page)
    assert "until thresholds are set" not in texts(page)
