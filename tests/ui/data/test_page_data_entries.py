"""The Data page: all that a finding concerns, each entry one click from its frame."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from builders import Box, make_dataset
from data_page import open_files, sent
from picture_files import numbered, write_picture
from streamlit.testing.v1 import AppTest

from nvcore.common.findings import Cases, Finding, Severity
from nvcore.pictures import open_pictures
from nvcore.pictures.recordings import RecordingPictures
from pages import checked, press, tables, texts
from ui.views.data.audit import entries

TRUTH = b"frame,x,y,w,h\n0,9,9,40,90\n1,9,9,40,90\n2,9,9,40,90\n"
BOTH = b"frame,x,y,w,h,score\n0,9,9,40,90,0.9\n1,300,100,40,90,0.5\n2,300,100,40,90,0.5\n"
THIRD = b"2,10,9,40,90,0.9\n"
CODE = "agreed-by-both-not-in-truth"


@pytest.fixture
def page() -> AppTest:
    page = open_files(sent(TRUTH, ("a.csv", BOTH), ("b.csv", BOTH + THIRD)))
    (button,) = [button for button in page.button if button.label == "Show all 2 boxes"]
    return press(page, button.key)


def listed(page: AppTest):
    (table,) = [table for table in tables(page) if "seen" in table]
    return table


def test_a_finding_opens_the_list_of_all_boxes_that_it_counts(page: AppTest):
    table = listed(page)
    assert table["frame"].tolist() == [1, 2]
    assert table["x"].tolist() == [300, 300]
    assert (table["seen"] == "").all()
    (button,) = [button for button in page.button if button.label == "Hide the list"]
    press(page, button.key)
    assert not any("seen" in table for table in tables(page))


def test_an_entry_leads_to_its_frame_and_is_then_seen(monkeypatch: pytest.MonkeyPatch):
    wishes: list[str] = []
    monkeypatch.setattr(entries, "ask_for_page", wishes.append)
    draw = entries.draw

    def draw_and_click(finding, number):
        draw(finding, number)
        if finding.code == CODE and not wishes:
            entries._go(finding, 1, "frame")

    monkeypatch.setattr(entries, "draw", draw_and_click)
    page = open_files(sent(TRUTH, ("a.csv", BOTH), ("b.csv", BOTH + THIRD)))
    assert wishes == ["timeline"]
    assert page.session_state["place"] == (0, 2)
    assert page.session_state["review"].at == 1
    (button,) = [button for button in page.button if button.label == "Show all 2 boxes"]
    assert listed(press(page, button.key))["seen"].fillna("").tolist() == ["", "✓"]


def test_other_thresholds_list_other_boxes():
    """Both boxes of A count without a threshold, at 0.4 the first alone."""
    a = BOTH.replace(b"2,300,100,40,90,0.5", b"2,300,100,40,90,0.3")
    page = open_files(sent(TRUTH, ("a.csv", a), ("b.csv", BOTH + THIRD)))
    (button,) = [button for button in page.button if button.label == "Show all 2 boxes"]
    page = press(page, button.key)
    assert listed(page)["frame"].tolist() == [1, 2]
    page.session_state["settings"] = {"threshold_x": 0.4}
    assert listed(checked(page.run()))["frame"].tolist() == [1]


def test_the_list_is_offered_as_csv_and_for_annotators(page: AppTest):
    labels = [button.label for button in page.get("download_button")]
    assert {"List (CSV)", "For annotators (CVAT)"} <= {*labels}


def test_pictures_of_a_folder_have_their_files_names_for_annotators(tmp_path: Path):
    for number in range(3):
        write_picture(tmp_path / f"I{number:02d}.png", numbered(number))
    made = make_dataset([Box(frame, 5, 5, 5, 9, 1) for frame in range(3)])
    cases = Cases("boxes", np.array([2]))
    finding = Finding(Severity.NOTE, "odd", "truth", 1, "m", "a", cases=cases)
    space = SimpleNamespace(
        pictures=RecordingPictures({0: open_pictures(tmp_path)}, {0: np.arange(3)})
    )
    assert b'name="I02.png"' in entries._cvat(space, made, finding, cases)
    assert b'name="r0/000002.png"' in entries._cvat(
        SimpleNamespace(pictures=RecordingPictures()), made, finding, cases
    )


def test_rows_without_a_frame_say_so():
    lost = BOTH + b"77,10,9,40,90,0.9\n"
    page = open_files(sent(TRUTH, ("a.csv", lost), ("b.csv", BOTH + THIRD)))
    (button,) = [button for button in page.button if button.label == "Show the row"]
    page = press(page, button.key)
    assert listed(page)["frame"].tolist() == [77]
    page.session_state["entries_no_frame"] = True
    assert "not evaluated" in texts(page.run())
