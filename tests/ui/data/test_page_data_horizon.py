"""The Data page: the horizon, estimated from the boxes and taken over."""

from __future__ import annotations

from pathlib import Path

from data_page import open_files, opened_drive, press, recordings_of, sent, space_of
from streamlit.testing.v1 import AppTest

from pages import checked, texts


def seen_from_far_and_near() -> bytes:
    """Four people of one stature who come nearer below a horizon in row 200."""
    lines = ["frame,x,y,w,h,track"]
    for track in range(4):
        for frame in range(20):
            depth = 20 + 4 * frame + track
            x, y, h = 50 + 100 * track, 200 - 0.25 * depth, 1.25 * depth
            lines.append(f"{frame},{x},{y},20,{h},{track}")
    return "\n".join(lines).encode()


def unfolded(page: AppTest) -> AppTest:
    page.session_state["horizons"] = True
    return checked(page.run())


def test_an_estimated_horizon_is_shown_with_its_error_and_taken_over() -> None:
    truth = seen_from_far_and_near()
    detections = b"frame,x,y,w,h,score\n0,50,195,20,25,0.9\n"
    page = open_files(sent(truth, ("a.csv", detections)))
    page = unfolded(page)
    assert "row 200 (95 %: 200 to 200; 80 boxes of 4 pedestrians)" in texts(page)
    press(page, "use_horizons")
    assert space_of(page).opened.dataset.recordings["horizon"].tolist() == [200.0]
    assert recordings_of(page)["horizon"].tolist() == [200.0]
    assert not [button for button in page.button if button.key == "use_horizons"]


def test_boxes_that_do_not_tell_are_said_to(tmp_path: Path) -> None:
    page = unfolded(opened_drive(tmp_path, "fir.csv", "nir.csv"))
    assert "The boxes do not tell" in texts(page)
