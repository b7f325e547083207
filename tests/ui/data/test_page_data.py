"""The Data page: what is open, its findings and its pictures."""

from __future__ import annotations

import json
from pathlib import Path

from data_page import (
    ON_SAMPLE,
    Edit,
    asked,
    late_drive,
    late_page,
    open_files,
    opened,
    press,
    recordings_of,
    send_video,
    sent,
    sizes_of,
    space_of,
)
from streamlit.testing.v1 import AppTest

from pages import alone, checked, texts


def test_the_page_opens_on_the_sample():
    page = checked(alone("data").run())
    assert ON_SAMPLE in texts(page)
    inputs, recordings = page.table[-1].value, recordings_of(page)
    assert inputs["Source"].tolist() == ["Truth", "X: FIR", "Y: NIR", "NIR 2"]
    names = [name.replace("\\", "") for name in inputs["Files"]]
    assert names == [
        "truth.csv",
        "fir.csv",
        "nir.csv",
        "nir2.csv",
    ]  # without folders of the machine
    assert inputs["Read as"].str.contains("pixels").all()
    assert len(recordings) == 10
    assert recordings["pictures"].str.contains("mp4", regex=False).all()
    assert recordings["note"].str.contains("shows frame").all()
    assert (recordings["frames"] > 0).all()
    assert page.table[0].value["False alarms"].tolist() == ["57", "58"]
    assert "frame is evaluated" not in texts(page)
    # the files of the machine are out of reach unless asked for
    assert [tab.label for tab in page.tabs] == ["Upload", "Session file", "Sample"]


def test_a_time_offset_found_is_applied_with_one_click(tmp_path: Path):
    truth, late = late_drive(tmp_path)
    good = truth.replace(b"track", b"score")
    page = open_files(sent(truth, ("good.csv", good), ("late.csv", late)))
    assert "3 frames too late" in texts(page)
    keys = [button.key for button in page.button if (button.key or "").startswith("apply_")]
    press(page, keys[0])
    assert space_of(page).opened.session.systems[1].offset_frames == -3
    assert "frames too late" not in texts(page)


def test_findings_stand_worst_first_with_what_they_mean_for_the_figures(tmp_path: Path):
    truth, _ = late_drive(tmp_path)
    twice = truth + b"5,40,100,20,60,0\n"
    page = open_files(sent(twice, ("good.csv", truth.replace(b"track", b"score"))))
    badges = [text.value for text in page.markdown if "-badge[" in text.value]
    order = [("Error" in badge, "Warning" in badge) for badge in badges]
    assert order == sorted(order, reverse=True)
    assert "Error" in badges[0]
    assert "1 error that makes numbers wrong" in texts(page)


def test_what_only_may_be_looked_at_is_not_said_to_change_no_figure():
    truth = b"frame,x,y,w,h\n0,9,9,40,90\n1,9,9,40,90\n2,9,9,40,90\n"
    both = b"frame,x,y,w,h,score\n0,9,9,40,90,0.9\n1,300,100,40,90,0.5\n"  # one of nobody
    third = b"2,10,9,40,90,0.9\n"
    page = open_files(sent(truth, ("a.csv", both), ("b.csv", both + third)))
    assert "where the ground truth has nobody" in texts(page)
    (badge,) = [text.value for text in page.markdown if "-badge[" in text.value]
    assert "Note" in badge
    assert "change numbers" not in texts(page)


def test_a_video_proposes_size_and_rate_finds_its_recording_and_can_be_shifted(
    tmp_path: Path, edit: Edit
):
    page = send_video(late_page(tmp_path), "drive.mp4")
    assert asked(page) == {
        "Width of the pictures (px)": 640,
        "Height of the pictures (px)": 480,
        "Frames per second of the camera": 20.0,
    }
    press(page, "open_upload")
    assert sizes_of(page) == [(640, 480)]
    assert recordings_of(page)["pictures"].tolist() == ["drive.mp4"]
    assert (space_of(page).pictures.indices[0] == range(60)).all()
    edit.apply(page, first_picture=1)
    assert space_of(page).pictures.indices[0].tolist() == list(range(-1, 59))
    assert "1 of 60 listed frames have no picture" in recordings_of(page)["note"][0]
    assert recordings_of(page)["first_picture"].tolist() == [1]
    edit.apply(page, first_picture=None)
    assert (space_of(page).pictures.indices[0] == range(60)).all()


def picture_choices(page: AppTest) -> str:
    """What the table's column of pictures offers."""
    (table,) = [item for item in page.dataframe if "note" in item.value]
    return json.loads(table.proto.columns)["pictures"]["type_config"]["options"]


def test_pictures_sent_later_can_be_chosen_and_taken_away_again(edit: Edit):
    page = send_video(opened(), "more.mp4")
    page.session_state["settings"] = {"midpoint": 60.0}
    assert "more.mp4" in str(picture_choices(page))
    edit.apply(page, pictures="more.mp4")
    assert space_of(page).pictures.sources[0].name == "more.mp4"
    edit.apply(page, pictures="no pictures")
    assert 0 not in space_of(page).pictures.sources
    press(page, "remove_pictures")
    assert "more.mp4" not in str(picture_choices(page))
    assert page.session_state["params"].midpoint == 60  # outlives corrections of the session
