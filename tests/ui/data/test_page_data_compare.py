"""The Data page: who is X and Y, at which thresholds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from data_page import COMPARING, READING, open_files, opened, press, sent, space_of
from inputs import drive, session_of

from nvcore.dataset.tables import dataset_from_tables
from nvcore.report.words import sampling_note
from pages import begin_with, checked, texts, to_page
from pages import opened as opened_app
from ui.views.data.compare import EXACT_OPEN


def n_kept(page) -> int:
    return int(page.table[0].value["Detections kept"][0].split(" of ")[0].replace(",", ""))


def thresholds(page) -> list[str]:
    return page.table[0].value["Score threshold"].tolist()


def with_fields(page):
    """The page with its fields for exact thresholds unfolded."""
    page.session_state[EXACT_OPEN] = True
    return checked(page.run())


def test_thresholds_change_what_is_kept_and_go_with_their_systems():
    page = with_fields(opened(*COMPARING))
    before, (_, of_y) = n_kept(page), thresholds(page)
    checked(page.number_input(key="data_threshold_x").set_value(0.705).run())
    assert n_kept(page) < before
    assert thresholds(page) == ["0.705", of_y]
    press(page, "sidebar_swap")
    assert thresholds(page) == [of_y, "0.705"]
    assert page.number_input(key="data_threshold_y").value == 0.705
    # choosing X as Y swaps them as well
    checked(page.selectbox(key="choice_y").set_value("NIR").run())
    chosen = page.selectbox(key="choice_x").value, page.selectbox(key="choice_y").value
    assert chosen == ("FIR", "NIR")


def test_a_threshold_at_the_lowest_score_says_that_every_detection_counts(
    tmp_path: Path, monkeypatch
):
    begin_with(session_of(drive(tmp_path)), monkeypatch)
    page = with_fields(opened(*COMPARING))
    checked(page.number_input(key="data_threshold_x").set_value(0.8).run())
    note = "of X has a score below"
    assert note not in texts(page)
    dataset = space_of(page).opened.dataset
    lowest = float(dataset.system(dataset.systems[0]).score.min())
    checked(page.number_input(key="data_threshold_x").set_value(lowest).run())
    assert page.number_input(key="data_threshold_x").value is None
    assert f"{note} {lowest:g}: every detection counts" in texts(page)
    assert note not in texts(checked(page.run()))


def test_after_opening_the_next_step_stands_first_and_thresholds_are_asked_for(tmp_path: Path):
    drive(tmp_path)
    truth, *systems = (
        (name, (tmp_path / name).read_bytes()) for name in ("truth.csv", "fir.csv", "nir.csv")
    )
    page = open_files(sent(truth[1], *systems, calls=(*READING, *COMPARING)))
    banner, button = (page.main.children[at] for at in range(2))
    assert (banner.type, button.type) == ("success", "button")
    assert banner.value.startswith("**Opened: Uploaded files.**")
    assert button.label == "Next: see the comparison"
    assert "Every detection of fir and nir counts, however low its score" in texts(page)
    of_systems = next(table.value for table in page.table if "Score threshold" in table.value)
    assert of_systems["Score threshold"].tolist() == ["every detection counts"] * 2
    checked(page.slider(key="threshold_x").set_value(0.8).run())
    assert "Opened: Uploaded files" in texts(page)  # it stays while one works on the page
    press(page, "see_opened")
    assert page.session_state["wanted_page"] == "overview"


def test_the_next_step_is_gone_when_one_comes_back_to_the_page():
    page = press(checked(opened_app("data")), "open_sample")
    assert "Opened: Sample recordings" in texts(page)
    assert "until a threshold is set" not in texts(page)  # the sample's session has them
    checked(to_page(page, "metrics"))
    checked(to_page(page, "data"))
    assert "Open now: Sample recordings" in texts(page)
    assert "Opened: Sample recordings" not in texts(page)


def test_rates_of_sampled_frames_say_what_they_count():
    frames = range(9, 209, 20)
    truth = "frame,x,y,w,h\n" + "".join(f"{frame},100,100,40,90\n" for frame in frames)
    boxes = "frame,x,y,w,h,score\n" + "".join(f"{frame},9,9,40,90,0.5\n" for frame in frames)
    calls = (*READING, "ui.views.data.compare.draw()")
    page = open_files(sent(truth.encode(), ("a.csv", boxes.encode()), calls=calls))
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
    assert "The question was changed on 20" in texts(to_page(page, "overview"))


def test_delivered_products_are_compared_as_they_are_set():
    page = opened_app("data", threshold_x="0.3", threshold_y="0.6")
    checked(page.checkbox(key="choice_delivered").check().run())
    overview = to_page(page, "overview")
    assert "With the delivered thresholds" in texts(overview)
    assert "At equal false alarms" not in texts(overview)
    page = to_page(overview, "data")
    assert page.checkbox(key="choice_delivered").value
    checked(page.checkbox(key="choice_delivered").uncheck().run())
    assert "Changed on 20" in texts(page)  # after a verdict was shown
