"""The Data page: a list of evaluated frames that was sent."""

from __future__ import annotations

from pathlib import Path

from data_page import ON_SAMPLE, open_files, send, sent, sent_drive, space_of
from streamlit.testing.v1 import AppTest

from pages import checked, texts


def sampled_page(frames: bytes) -> AppTest:
    """One recording of which the frames 0, 3 and 9 were looked at, and boxes stand in two."""
    truth = b"frame,x,y,w,h\n0,9,9,40,90\n9,9,9,40,90\n"
    page = sent(truth, ("a.csv", b"frame,x,y,w,h,score\n3,9,9,40,90,0.5\n"))
    return send_list(page, frames)


def send_list(page: AppTest, content: bytes) -> AppTest:
    page.file_uploader(key="upload_frames").set_value(("frames.txt", content, "text/plain"))
    return checked(page.run())


def test_a_list_of_evaluated_frames_is_followed():
    page = sampled_page(b"0\n3\n9\n")
    assert "Read as 3 frames, 0 to 9." in texts(page)
    open_files(page)
    assert space_of(page).opened.dataset.frames["frame"].tolist() == [0, 3, 9]


def test_a_list_that_holds_no_numbers_is_told_and_stops():
    page = sampled_page(b"0\nthree\n")
    assert "frames.txt, line 2: expected a frame number, found 'three'" in texts(page)
    open_files(page)
    assert "The list of evaluated frames cannot be used" in texts(page)
    assert ON_SAMPLE in texts(page)


def test_a_list_of_frames_is_of_one_recording_and_no_ground_truth(tmp_path: Path):
    page = send_list(sent_drive(tmp_path, "fir.csv"), b"0\n3\n9\n")
    (error,) = page.error
    assert "of one recording, and the ground truth has 2" in error.value
    send(page, "upload_truth", ("frames.txt", b"0\n3\n9\n"))
    checked(page.run())
    assert "it belongs in the field “Evaluated frames”" in texts(page)
