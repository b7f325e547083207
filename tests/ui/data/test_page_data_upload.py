"""The Data page: files that people send, good and bad."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest
from data_page import (
    PNG,
    answer,
    late_drive,
    late_page,
    opened,
    opened_drive,
    press,
    send,
    send_drive,
    send_video,
    space_of,
)
from inputs import mot_layout
from streamlit.testing.v1 import AppTest

from pages import checked, texts
from ui.data import upload
from ui.session import uploads


def test_an_upload_asks_for_what_the_files_do_not_say_and_opens_with_it(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    press(page, "open_upload")
    assert "image size and the frame rate" in texts(page)
    assert "Open now: Sample recordings (" in texts(page)
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert "Opened: Uploaded files" in texts(page)
    assert page.table[0].value["Source"].tolist() == ["Truth", "X: fir", "Y: nir"]
    assert page.table[1].value["Size (px)"].tolist() == ["640 × 480"] * 2


def test_a_fact_that_the_files_hold_is_not_asked_for(tmp_path: Path):
    page = opened()
    mot_layout(tmp_path)
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for path in tmp_path.rglob("*.*"):
            if path.is_file():
                archive.write(path, path.relative_to(tmp_path))
    for key in ("upload_truth", "upload_system_0", "upload_system_1"):
        send(page, key, ("mot.zip", content.getvalue()))
    page.text_input(key="upload_name_0").set_value("one")
    page.text_input(key="upload_name_1").set_value("<b>two</b>")
    press(page, "open_upload")
    assert page.error == []
    assert page.warning == [] or "Frames per second" not in texts(page)
    assert page.table[1].value["Recording"].tolist() == ["A", "B"]
    assert space_of(page).opened.dataset.systems == ("one", "<b>two</b>")


def test_hostile_names_are_shown_as_text(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    page.text_input(key="upload_name_0").set_value("[x](https://evil.example) :red[y]")
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert "\\[x\\]\\(https\\:" in page.table[0].value["Source"][1]


def test_one_system_only_is_shown_alone(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv")
    assert "There is one system only" in texts(page)
    assert len(page.metric) == 2
    assert "swap_systems" not in [button.key for button in page.button]


def test_three_systems_can_be_sent_and_any_two_compared(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    press(page, "add_system")
    send(page, "upload_system_2", ("third.csv", (tmp_path / "fir.csv").read_bytes()))
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    checked(page.selectbox(key="choice_y").set_value("third").run())
    assert page.table[0].value["Source"].tolist() == ["Truth", "X: fir", "nir", "Y: third"]


def test_without_truth_the_page_says_what_to_choose():
    page = press(opened(), "open_upload")
    assert "Choose the ground truth first" in texts(page)


def test_without_a_system_the_page_says_what_to_choose(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path)
    assert "at least one system" in texts(press(page, "open_upload"))


def test_a_picture_named_csv_is_told_and_what_was_open_stays(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    send(page, "upload_truth", ("truth.csv", PNG))
    press(page, "open_upload")
    assert "a PNG picture" in texts(page)
    assert "Open now: Sample recordings (" in texts(page)


def test_an_error_names_no_folder_of_the_machine(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    send(page, "upload_truth", ("truth.csv", b"frame,x,y,w,h\n1,2,3,4,oops\n"))
    press(page, "open_upload")
    told = [one.value.replace("\\", "") for one in page.error]
    assert any("truth.csv, line 2" in one for one in told)
    assert not any("annotations" in one or "upload-" in one for one in told)


def test_a_zip_bomb_is_told(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("truth.csv", bytes(100 << 20))
    send(page, "upload_truth", ("truth.zip", content.getvalue()))
    press(page, "open_upload")
    assert "only archives made to do harm" in texts(page)


def test_an_empty_file_is_told(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    send(page, "upload_truth", ("truth.csv", b""))
    assert "the file is empty" in texts(press(page, "open_upload"))


def test_an_error_goes_when_another_file_is_chosen(tmp_path: Path):
    page = press(opened(), "open_upload")
    assert page.error
    send_drive(page, tmp_path, "fir.csv")
    assert checked(page.run()).error == []


def test_two_sessions_do_not_see_each_others_data(tmp_path: Path):
    mine, other = opened_drive(tmp_path, "fir.csv"), opened()
    assert "Open now: Sample recordings (" in texts(other)
    assert "Open now: Uploaded files (" in texts(mine)
    assert space_of(mine).token != space_of(other).token


def test_what_the_files_do_not_say_is_asked_before_anything_is_opened(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    checked(page.run())
    assert "Not in the files: the image size and the frame rate" in texts(page)
    answer(page, width=640, height=480, fps=20.0)
    assert "Opened: Uploaded files" in texts(press(page, "open_upload"))


def test_what_the_files_turn_out_to_be_stands_at_their_field(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    checked(page.run())
    assert "Read as plain CSV: 40 boxes in frames 0 to 19." in texts(page)
    assert "Read as plain CSV: 11 boxes in frames 4 to 19." in texts(page)


def test_size_and_frame_rate_are_proposed_from_the_video(tmp_path: Path):
    page = late_page(tmp_path)
    send_video(page, "drive.mp4")
    checked(page.run())
    asked = {one.label: one.value for one in page.number_input if "upload" in (one.key or "")}
    assert asked == {
        "Width of the pictures (px)": 640,
        "Height of the pictures (px)": 480,
        "Frames per second": 20.0,
    }


def test_a_frame_rate_that_was_typed_stays_when_a_video_arrives(tmp_path: Path):
    page = late_page(tmp_path)
    checked(page.run())
    answer(page, fps=7.0)
    checked(page.run())
    send_video(page, "drive.mp4")
    checked(page.run())
    (rate,) = [one for one in page.number_input if one.label == "Frames per second"]
    assert rate.value == 7.0


def kitti_page() -> AppTest:
    """Three files of one name, as KITTI has them."""
    label = "Pedestrian 0 0 -10 100 150 120 200 -1 -1 -1 -1000 -1000 -1000 -10"
    truth = "".join(f"{frame} 1 {label}\n" for frame in range(9)).encode()
    found = "".join(f"{frame},100,150,120,200,0.9\n" for frame in range(9)).encode()
    page = opened()
    send(page, "upload_truth", ("0016.txt", truth))
    for number in range(2):
        send(page, f"upload_system_{number}", ("0016.txt", found))
    return checked(page.run())


def test_files_of_one_name_get_numbered_names_and_a_word_about_them():
    page = kitti_page()
    names = [page.text_input(key=f"upload_name_{number}").value for number in range(2)]
    assert names == ["System 1", "System 2"]
    assert texts(page).count("do not tell which system this is") == 2


def test_names_that_are_typed_name_systems_and_recording():
    page = kitti_page()
    page.text_input(key="upload_name_0").set_value("RRC")
    page.text_input(key="upload_name_1").set_value("PointRCNN")
    page.text_input(key="recording_name_upload").set_value("crossing")
    answer(page, width=1242, height=375, fps=10.0)
    press(page, "open_upload")
    assert space_of(page).opened.dataset.systems == ("RRC", "PointRCNN")
    assert page.table[1].value["Recording"].tolist() == ["crossing"]


def test_a_name_told_by_a_file_follows_the_file_until_one_is_typed(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv")
    checked(page.run())
    assert page.text_input(key="upload_name_0").value == "fir"
    content = (tmp_path / "nir.csv").read_bytes()
    send(page, "upload_system_0", ("nir.csv", content))
    checked(page.run())
    assert page.text_input(key="upload_name_0").value == "nir"
    page.text_input(key="upload_name_0").set_value("mine")
    send(page, "upload_system_0", ("third.csv", content))
    checked(page.run())
    assert page.text_input(key="upload_name_0").value == "mine"


def test_a_recording_in_a_file_called_gt_is_named_by_its_video(tmp_path: Path):
    page = opened()
    send(page, "upload_truth", ("gt.csv", late_drive(tmp_path)[0]))
    send_video(page, "drive.mp4")
    checked(page.run())
    assert page.text_input(key="recording_name_upload").value == "drive"


def test_an_error_stands_at_its_field_before_anything_is_opened(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    send(page, "upload_system_1", ("nir.csv", PNG))
    checked(page.run())
    assert [one.value.replace("\\", "") for one in page.error] == [
        "nir.csv: expected the detections of a system, found a PNG picture"
    ]
    press(page, "open_upload")
    assert "The files of system 2 (Y) cannot be used" in texts(page)


def test_what_could_not_be_opened_is_told_first_and_what_is_open_is_named(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path)
    press(page, "open_upload")
    first = page.main.children[1].children[0]
    assert first.type == "error"
    assert "Not opened: Uploaded files" in first.value
    assert "what this page is about: Sample recordings" in first.value
    assert "The audit of Sample recordings found nothing" in texts(page)


def test_a_failure_is_forgotten_when_something_else_is_opened():
    page = press(opened(), "open_upload")
    assert "Not opened" in texts(page)
    press(page, "open_sample")
    assert "Not opened" not in texts(page)


def test_a_video_that_cannot_be_opened_stops_until_one_goes_on_without(tmp_path: Path):
    page = late_page(tmp_path)
    send_video(page, "cut.mp4", n_bytes=1_000)
    checked(page.run())
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert "cut.mp4: is damaged" in texts(page)
    assert "Some pictures were refused" in texts(page)
    assert "Open now: Sample recordings (" in texts(page)
    (without,) = [one for one in page.checkbox if "without the refused" in one.label]
    checked(without.check().run())
    press(page, "open_upload")
    assert "Open now: Uploaded files (1 recording)" in texts(page)
    assert page.table[1].value["Pictures"].tolist() == ["no pictures"]


def test_a_file_that_the_upload_refused_stops_as_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    page = late_page(tmp_path)
    why = "notes.mp4: is neither a video nor a picture"
    monkeypatch.setattr(upload, "upload_pictures", lambda _space, key: [why])  # noqa: ARG005
    checked(page.run())
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert why in texts(page)
    assert "Some pictures were refused" in texts(page)


def test_pictures_of_no_recording_are_named(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv")
    send_video(page, "extra.mp4")
    checked(page.run())
    assert "Of no recording by their names: extra.mp4" in texts(page)


def test_frames_that_begin_with_another_number_are_told(tmp_path: Path):
    page = opened()
    send(page, "upload_truth", ("t.csv", b"frame,x,y,w,h\n0,1,1,9,20\n"))
    send(page, "upload_system_0", ("a.csv", b"frame,x,y,w,h,score\n1,1,1,9,20,0.5\n"))
    checked(page.run())
    assert "Begins with frame 1, the ground truth with frame 0" in texts(page)


def test_files_that_found_no_room_are_taken_when_there_is_room_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    page = opened()
    send_drive(page, tmp_path, "fir.csv")
    with monkeypatch.context() as full:
        full.setattr(uploads, "MAX_SESSION_BYTES", 10)
        checked(page.run())
        assert "remove uploads that are no longer needed" in texts(page)
    checked(page.run())
    assert page.error == []
    assert "Read as plain CSV: 40 boxes in frames 0 to 19." in texts(page)
    answer(page, width=640, height=480, fps=20.0)
    assert "Opened: Uploaded files" in texts(press(page, "open_upload"))


def test_kittis_usual_size_and_rate_are_proposed_without_pictures():
    page = kitti_page()
    asked = {one.label: one.value for one in page.number_input if "upload" in (one.key or "")}
    assert asked == {
        "Width of the pictures (px)": 1242,
        "Height of the pictures (px)": 375,
        "Frames per second": 10.0,
    }
    assert "The usual size in KITTI; some of its recordings have 1224 × 370" in texts(page)
    assert "The usual rate in KITTI." in texts(page)


def test_a_size_typed_in_place_of_the_usual_one_stays_when_a_video_arrives():
    page = kitti_page()
    answer(page, width=1224.0)
    checked(page.run())
    send_video(page, "drive.mp4")
    checked(page.run())
    (width,) = [one for one in page.number_input if one.label.startswith("Width")]
    assert width.value == 1224


def test_boxes_to_be_ignored_are_told_apart_before_and_after_opening():
    page = opened()
    rows = b"frame,x,y,w,h,ignore\n0,9,9,40,90,0\n1,9,9,40,90,1\n2,9,9,40,90,0\n"
    send(page, "upload_truth", ("t.csv", rows))
    send(page, "upload_system_0", ("a.csv", b"frame,x,y,w,h,score\n0,9,9,40,90,0.5\n"))
    checked(page.run())
    assert "3 boxes in frames 0 to 2, 1 of them to be ignored" in texts(page)
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert page.table[0].value["Boxes"].tolist() == ["3: 2 pedestrians, 1 to be ignored", "1"]


def test_what_was_read_does_not_call_the_recording_by_its_old_name():
    page = kitti_page()
    page.text_input(key="recording_name_upload").set_value("crossing")
    press(page, "open_upload")
    told = [text.replace("\\", "") for text in page.table[0].value["Read as"]]
    assert space_of(page).opened.dataset.recordings["name"].tolist() == ["crossing"]
    assert not any("0016" in text for text in told)
