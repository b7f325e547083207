"""The Data page: boxes written in another way, what is left out, and errors that are meant."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
from data_page import open_files, press, sent, space_of
from field_files import session_of
from field_scene import truth
from streamlit.testing.v1 import AppTest

from pages import texts


def of_scene(folder: Path, **layouts: str) -> AppTest:
    """The form with the files of the scene, not opened yet."""
    session_of(folder, **layouts)
    files = [(f"{name}.csv", (folder / f"{name}.csv").read_bytes()) for name in ("x", "y")]
    return sent((folder / "truth.csv").read_bytes(), *files)


def button_labelled(page: AppTest, label: str) -> str:
    (key, *_) = [button.key for button in page.button if button.label == label]
    return key


def test_corners_taken_for_sizes_are_put_right_with_one_click(tmp_path):
    page = open_files(of_scene(tmp_path, x="corners"))
    assert "The boxes seem to be left, top, right, bottom" in texts(page)
    press(page, button_labelled(page, "Read boxes as corners"))
    assert space_of(page).opened.session.systems[0].boxes == "corners"
    assert "The boxes seem to be" not in texts(page)


def test_how_boxes_are_written_is_chosen_at_the_field(tmp_path):
    page = of_scene(tmp_path, x="corners")
    boxes = page.selectbox(key="boxes_upload_system_0")
    boxes.set_value(next(option for option in boxes.options if option.startswith("corners: ")))
    open_files(page)
    assert [s.boxes for s in space_of(page).opened.session.systems] == ["corners", None]
    assert "The boxes seem to be" not in texts(page)


def test_an_error_that_is_meant_becomes_a_warning_with_one_click(tmp_path):
    page = of_scene(tmp_path)
    for number, name in enumerate("xy"):
        table = pd.read_csv(tmp_path / f"{name}.csv").assign(y=1, h=30)
        field = page.file_uploader(key=f"upload_system_{number}")
        field.set_value((f"{name}.csv", table.to_csv(index=False).encode(), "text/csv"))
    open_files(page.run())
    assert "Neither system matches a single pedestrian" in texts(page)
    press(page, button_labelled(page, "This is meant"))
    assert space_of(page).opened.session.accept == ("no-match",)
    assert "errors that make" not in texts(page)
    assert "This is meant, as given." in texts(page)


def test_what_is_left_out_stands_at_the_field_and_with_what_was_read(tmp_path):
    page = of_scene(tmp_path)
    table = truth().rename(columns={"name": "class"}).to_csv(index=False).encode()
    page.file_uploader(key="upload_truth").set_value(("truth.csv", table, "text/csv"))
    page.run()
    assert "Left out: car (80), bicycle (40)." in texts(page)
    open_files(page)
    left_out = [text.replace("\\", "") for text in page.table[-1].value["Left out"]]
    assert left_out == ["car (80), bicycle (40)", "–", "–"]
