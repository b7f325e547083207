"""The Data page: a list of evaluated frames that was sent."""

from __future__ import annotations

from pathlib import Path

from data_page import answer, opened, press, send, send_drive, space_of
from streamlit.testing.v1 import AppTest

from pages import checked, texts


def sampled_page() -> AppTest:
    """One recording of which the frames 0, 3 and 9 were looked at, and boxes stand in two."""
    page = opened()
    send(page, "upload_truth", ("t.csv", b"frame,x,y,w,h\n0,9,9,40,90\n9,9,9,40,90\n"))
    send(page, "upload_system_0", ("a.csv", b"frame,x,y,w,h,score\n3,9,9,40,90,0.5\n"))
    return page


def send_list(page: AppTest, content: bytes) -> None:
    page.file_uploader(key="upload_frames").set_value(("frames.txt", content, "text/plain"))


def test_a_list_of_evaluated_frames_is_followed():
    page = sampled_page()
    send_list(page, b"0\n3\n9\n")
    checked(page.run())
    assert "Read as 3 frames, 0 to 9." in texts(page)
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert space_of(page).opened.dataset.frames["frame"].tolist() == [0, 3, 9]


def test_a_list_that_holds_no_numbers_is_told_and_stops():
    page = sampled_page()
    send_list(page, b"0\nthree\n")
    checked(page.run())
    assert "frames.txt, line 2: expected a frame number, found 'three'" in texts(page)
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert "The list of evaluated frames cannot be used" in texts(page)
    assert "Open now: Sample recordings (" in texts(page)


def test_a_list_of_frames_is_of_one_recording_only(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv")
    send_list(page, b"0\n3\n9\n")
    checked(page.run())
    (told,) = page.error
    assert "of one recording, and the ground truth has 2" in told.value


def test_a_list_of_frames_put_under_ground_truth_says_where_it_belongs():
    page = sampled_page()
    send(page, "upload_truth", ("frames.txt", b"0\n3\n9\n"))
    checked(page.run())
    (told,) = page.error
    assert "it belongs in the field “Evaluated frames”" in told.value
