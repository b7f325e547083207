"""The Data page: who is X and Y, at which thresholds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from data_page import open_files, opened, opened_drive, press, sent, space_of
from inputs import drive

from nvcore.comparison import compare
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence.operating_points import equal_setting, find_equal_alarms
from nvcore.report.words import sampling_note
from pages import checked, texts, to_page
from pages import opened as opened_app
from ui.data.compare import EXACT_OPEN


def n_kept(page) -> int:
    return int(page.table[0].value["Detections kept"][0].split(" of ")[0].replace(",", ""))


def thresholds(page) -> list[str]:
    return page.table[0].value["Score threshold"].tolist()


def with_fields(page):
    """The page with its fields for exact thresholds unfolded."""
    page.session_state[EXACT_OPEN] = True
    return checked(page.run())


def test_thresholds_change_what_is_kept_and_go_with_their_systems():
    page = with_fields(opened())
    before, (_, of_y) = n_kept(page), thresholds(page)
    checked(page.number_input(key="data_threshold_x").set_value(0.705).run())
    assert n_kept(page) < before
    assert thresholds(page) == ["0.705", of_y]
    press(page, "swap_systems")
    assert thresholds(page) == [of_y, "0.705"]
    assert page.number_input(key="data_threshold_y").value == 0.705
    # choosing X as Y swaps them as well
    checked(page.selectbox(key="choice_y").set_value("NIR").run())
    chosen = page.selectbox(key="choice_x").value, page.selectbox(key="choice_y").value
    assert chosen == ("FIR", "NIR")


def test_the_same_operating_point_may_lie_above_the_highest_score(tmp_path: Path):
    truth, fir, nir = drive_files(tmp_path)
    nir += b"rural,5,500,200,40,100,0.95\n"  # the best score is a false alarm
    page = open_files(sent(truth, ("fir.csv", fir), ("nir.csv", nir)))
    checked(page.slider(key="threshold_x").set_value(0.75).run())
    press(page, "same_point")
    assert page.session_state["params"].threshold_y > 0.95
    assert "Y: threshold" in texts(page)
    assert page.table[0].value["per minute"].tolist() == ["0.0", "0.0"]


def drive_files(folder: Path) -> tuple[bytes, bytes, bytes]:
    drive(folder)
    truth, fir, nir = ((folder / f"{name}.csv").read_bytes() for name in ("truth", "fir", "nir"))
    return truth, fir, nir


def without_scores(content: bytes) -> bytes:
    return b"\n".join(row.rpartition(b",")[0] for row in content.splitlines())


def test_where_y_has_no_scores_x_is_moved_to_its_operating_point(tmp_path: Path):
    truth, fir, nir = drive_files(tmp_path)
    alarms = "".join(f"urban,{frame},500,200,40,100,0.{frame}\n" for frame in range(10, 20))
    x = fir + alarms.encode()
    page = open_files(sent(truth, ("x.csv", x), ("y.csv", without_scores(nir))))
    assert "Y has no scores that differ: only X can be moved." in texts(page)
    press(page, "same_point")
    assert page.session_state["params"].threshold_x == pytest.approx(0.19)
    assert page.session_state["params"].threshold_y is None
    assert "X: threshold none → 0.19" in texts(page)
    press(page, "point_undo_data")
    assert page.session_state["params"].threshold_x is None
    assert "→" not in texts(page)


def test_where_x_has_no_scores_y_is_moved_and_where_neither_has_nothing_is(tmp_path: Path):
    truth, fir, nir = drive_files(tmp_path)
    bare = ("x.csv", without_scores(fir))
    page = open_files(sent(truth, bare, ("y.csv", nir)))
    assert "Y: threshold" in texts(press(page, "same_point"))
    page = open_files(sent(truth, bare, ("y.csv", without_scores(nir))))
    assert page.button(key="same_point").disabled
    assert "Neither system has scores that differ" in texts(page)


def test_the_same_operating_point_is_that_of_the_verdict(tmp_path: Path):
    """Every detection of both counts; the one with more false alarms moves, here X."""
    truth, fir, nir = drive_files(tmp_path)
    alarms = "".join(f"urban,{frame},500,200,40,100,0.{frame}\n" for frame in range(10, 20))
    page = open_files(sent(truth, ("x.csv", fir + alarms.encode()), ("y.csv", nir)))
    result = compare(space_of(page).opened.dataset)
    equal = find_equal_alarms(result)
    assert equal_setting(equal).moved == "x"
    press(page, "same_point")
    params = page.session_state["params"]
    assert params.threshold_x == pytest.approx(equal.x.threshold)
    assert params.threshold_y is None


def test_a_threshold_at_the_lowest_score_says_that_every_detection_counts(tmp_path: Path):
    page = with_fields(opened_drive(tmp_path, "fir.csv", "nir.csv"))
    checked(page.number_input(key="data_threshold_x").set_value(0.8).run())
    said = "of X has a score below"
    assert said not in texts(page)
    dataset = space_of(page).opened.dataset
    lowest = float(dataset.system(dataset.systems[0]).score.min())
    checked(page.number_input(key="data_threshold_x").set_value(lowest).run())
    assert page.number_input(key="data_threshold_x").value is None
    assert f"{said} {lowest:g}: every detection counts" in texts(page)
    assert said not in texts(checked(page.run()))


def test_after_opening_the_next_step_stands_first_and_thresholds_are_asked_for(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv", "nir.csv")
    banner, button = (page.main.children[1].children[at] for at in range(2))
    assert (banner.type, button.type) == ("success", "button")
    assert banner.value.startswith("**Opened: Uploaded files.**")
    assert button.label == "Next: see the comparison"
    assert "until thresholds are set in the sidebar" in texts(page)
    assert thresholds(page) == ["every detection counts"] * 2
    assert not page.button(key="same_point").disabled
    checked(page.slider(key="threshold_x").set_value(0.8).run())
    assert "Opened: Uploaded files" in texts(page)  # it stays while one works on the page
    press(page, "see_opened")
    assert page.session_state["wanted_page"] == "overview"


def test_the_next_step_is_gone_when_one_comes_back_to_the_page():
    page = press(checked(opened_app("data")), "open_sample")
    assert "Opened: Sample recordings" in texts(page)
    assert "until thresholds are set" not in texts(page)  # the sample's session has them
    checked(to_page(page, "metrics"))
    checked(to_page(page, "data"))
    assert "Open now: Sample recordings" in texts(page)
    assert "Opened: Sample recordings" not in texts(page)


def test_rates_of_sampled_frames_say_what_they_count():
    frames = range(9, 209, 20)
    truth = "frame,x,y,w,h\n" + "".join(f"{frame},100,100,40,90\n" for frame in frames)
    found = "frame,x,y,w,h,score\n" + "".join(f"{frame},9,9,40,90,0.5\n" for frame in frames)
    page = open_files(sent(truth.encode(), ("a.csv", found.encode())))
    assert sampling_note(space_of(page).opened.dataset.frame_columns) in texts(page)


@pytest.mark.parametrize(
    ("steps", "note"),
    [
        ([1, 1], ""),
        ([], ""),
        ([20], "Only every 20th frame is evaluated: per minute and per hour count those frames"),
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
    told = sampling_note(dataset.frame_columns)
    assert told.startswith(note)
    assert bool(told) == bool(note)


def test_the_primary_measure_is_chosen_before_the_verdict_or_said_to_be_changed():
    page = opened_app("data")
    checked(page.selectbox(key="choice_primary").set_value("mean_similarity").run())
    overview = to_page(page, "overview")
    assert "Mean similarity is the primary measure, chosen on 20" in texts(overview)
    page = to_page(overview, "data")
    assert page.selectbox(key="choice_primary").value == "mean_similarity"
    assert "after a verdict" not in texts(page)
    checked(page.selectbox(key="choice_primary").set_value("saliency").run())
    assert "Changed on 20" in texts(page)
    assert " was made the primary measure on 20" in texts(to_page(page, "overview"))
