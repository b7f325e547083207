"""The Data page: files that people send, good and bad, and lists of evaluated frames."""

from __future__ import annotations

import gzip
import io
import zipfile
from pathlib import Path

import pytest
from data_page import (
    COMPARING,
    ON_SAMPLE,
    PNG,
    answer,
    asked,
    late_drive,
    late_page,
    open_files,
    opened,
    opened_drive,
    press,
    recordings_of,
    send,
    send_video,
    sent,
    sent_drive,
    sizes_of,
    space_of,
)
from field_scene import write_yolo
from inputs import drive, mot_layout
from streamlit.testing.v1 import AppTest

from pages import checked, part, texts
from ui.session import uploads
from ui.session.store import WAYS_OPEN


def test_an_upload_asks_for_what_the_files_do_not_say_and_opens_with_it(tmp_path: Path):
    page = sent_drive(tmp_path, "fir.csv", "nir.csv")
    assert "Not in the files: the image size and the frame rate" in texts(page)
    assert "Read as plain CSV: 2 recordings, 40 boxes in frames 0 to 19." in texts(page)
    assert "Read as plain CSV: 2 recordings, 11 boxes in frames 4 to 19." in texts(page)
    page.text_input(key="upload_name_1").set_value("[x](https://evil.example) :red[y]")
    press(page, "open_upload")
    assert ON_SAMPLE in texts(page)
    open_files(page)
    assert "Opened: Uploaded files" in texts(page)
    *sources, hostile = page.table[-1].value["Source"]
    assert sources == ["Truth", "X: fir"]
    assert "\\[x\\]\\(https:small[]\\://evil" in hostile  # shown as text, and no link
    assert sizes_of(page) == [(640, 480)] * 2
    other = opened()
    assert ON_SAMPLE in texts(other)
    assert space_of(page).token != space_of(other).token


def test_packed_files_are_read_and_bombs_refused_at_their_field(tmp_path: Path):
    drive(tmp_path)
    page = opened()
    content = (tmp_path / "truth.csv").read_bytes()
    send(page, "upload_truth", ("truth.csv.gz", gzip.compress(content)))
    bomb = gzip.compress(b"frame,x,y,w,h,score\n" + bytes(70 << 20))
    send(page, "upload_system_0", ("fir.csv.gz", bomb))
    shown = texts(checked(page.run()))
    assert "Read as plain CSV: 2 recordings, 40 boxes in frames 0 to 19." in shown
    assert "unpacks to more than 200 times its size" in shown


def test_files_of_one_name_in_a_field_are_refused_there(tmp_path: Path):
    """Browsers send no folders, so all recordings of MOTChallenge come as gt.txt."""
    mot_layout(tmp_path)
    page = opened()
    for key, name in (("truth", "gt"), ("system_0", "det")):
        files = [(path.name, path.read_bytes()) for path in tmp_path.glob(f"*/{name}/{name}.txt")]
        send(page, f"upload_{key}", *files)
    checked(page.run())
    shown = texts(page).replace("\\", "")
    for name in ("gt.txt", "det.txt"):
        assert f"2 files are called {name}, and cannot be told apart" in shown
    assert "Send a ZIP archive with the folders" in shown
    assert "Read as MOTChallenge" not in shown


def test_a_fact_that_the_files_hold_is_not_asked_for(tmp_path: Path):
    mot_layout(tmp_path)
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for path in tmp_path.rglob("*.*"):
            if path.is_file():
                archive.write(path, path.relative_to(tmp_path))
    page = opened()
    for key in ("upload_truth", "upload_system_0", "upload_system_1"):
        send(page, key, ("mot.zip", content.getvalue()))
    page.text_input(key="upload_name_0").set_value("one")
    page.text_input(key="upload_name_1").set_value("<b>two</b>")
    press(page, "open_upload")
    assert page.error == []
    assert recordings_of(page)["name"].tolist() == ["A", "B"]
    assert space_of(page).opened.dataset.systems == ("one", "<b>two</b>")


def test_one_system_only_is_shown_alone(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv")
    assert page.table[-1].value["Source"].tolist() == ["Truth", "X: fir"]
    again = part(*COMPARING)
    again.session_state["workspace"] = space_of(page)
    again = checked(again.run())
    assert "There is one system only" in texts(again)
    assert again.table[0].value["System"].tolist() == ["**X**: fir"]
    assert "sidebar_swap" not in [button.key for button in again.button]


def test_three_systems_can_be_sent(tmp_path: Path):
    page = sent_drive(tmp_path, "fir.csv", "nir.csv")
    press(page, "add_system_upload")
    send(page, "upload_system_2", ("third.csv", (tmp_path / "fir.csv").read_bytes()))
    open_files(checked(page.run()))
    assert page.table[-1].value["Source"].tolist() == ["Truth", "X: fir", "Y: nir", "third"]


def test_the_ways_are_folded_after_success_and_stay_open_after_failure(tmp_path: Path):
    page = sent_drive(tmp_path, "fir.csv", "nir.csv")
    assert not page.session_state[WAYS_OPEN.key]
    page.session_state[WAYS_OPEN.key] = True
    press(page, "open_upload")
    assert "Not opened" in texts(page)  # the size is not known
    assert page.session_state[WAYS_OPEN.key]
    open_files(page)
    assert "Opened: Uploaded files" in texts(page)
    assert not page.session_state[WAYS_OPEN.key]
    page.session_state[WAYS_OPEN.key] = True
    assert checked(page.run()).session_state[WAYS_OPEN.key]


def test_what_is_still_to_be_chosen_is_said_first_and_what_is_open_is_named(tmp_path: Path):
    page = press(opened(), "open_upload")
    assert "Choose the ground truth first" in texts(page)
    late = late_drive(tmp_path)
    send(page, "upload_truth", ("truth.csv", late[0]))
    press(page, "open_upload")
    assert "at least one system" in texts(page)
    first = page.main.children[0]
    assert first.type == "error"
    assert "Not opened: Uploaded files" in first.value
    assert "what this page is about: Sample recordings" in first.value
    assert "Open now: Sample recordings" in texts(page)
    assert sum("Note" in text.value for text in page.markdown) == 1
    send(page, "upload_system_0", ("late.csv", late[1]))
    assert checked(page.run()).error == []
    press(page, "open_upload")
    assert "Not opened" in texts(page)  # the size is not known
    press(page, "open_sample")
    assert "Not opened" not in texts(page)


@pytest.mark.parametrize(
    ("truth", "why"),
    [
        (PNG, "a PNG picture"),
        (b"", "the file is empty"),
        (b"frame,x,y,w,h\n1,2,3,4,oops\n", "truth.csv, line 2"),
    ],
    ids=["picture", "empty", "wrong"],
)
def test_a_file_that_cannot_be_used_is_told_at_its_field_and_what_is_open_stays(
    truth: bytes, why: str
):
    page = sent(truth, ("a.csv", b"frame,x,y,w,h,score\n1,1,1,9,20,0.5\n"))
    (error,) = [error.value.replace("\\", "") for error in page.error]
    assert why in error
    press(page, "open_upload")
    assert "The files of the ground truth cannot be used" in texts(page)
    assert ON_SAMPLE in texts(page)
    assert not any("annotations" in error.value or "upload-" in error.value for error in page.error)


def test_a_frame_rate_that_was_typed_stays_when_a_video_arrives(tmp_path: Path):
    page = late_page(tmp_path)
    answer(page, fps=7.0)
    send_video(checked(page.run()), "drive.mp4")
    assert asked(page)["Frames per second of the camera"] == 7.0


def kitti_page() -> AppTest:
    """Three files of one name, as KITTI has them."""
    label = "Pedestrian 0 0 -10 100 150 120 200 -1 -1 -1 -1000 -1000 -1000 -10"
    truth = "".join(f"{frame} 1 {label}\n" for frame in range(9)).encode()
    boxes = "".join(f"{frame},100,150,120,200,0.9\n" for frame in range(9)).encode()
    page = opened()
    send(page, "upload_truth", ("0016.txt", truth))
    for number in range(2):
        send(page, f"upload_system_{number}", ("0016.txt", boxes))
    return checked(page.run())


def test_kittis_usual_size_and_rate_are_proposed_and_a_typed_size_stays():
    page = kitti_page()
    assert list(asked(page).values()) == [1242, 375, 10]
    assert "The usual size in KITTI; some of its recordings have 1224 × 370" in texts(page)
    assert "The usual rate in KITTI." in texts(page)
    answer(page, width=1224.0)
    send_video(checked(page.run()), "drive.mp4")
    assert asked(page)["Width of the pictures (px)"] == 1224


def test_the_edge_at_which_boxes_end_proposes_the_size_of_each_recording():
    def truth(right: int) -> bytes:
        label = f"Pedestrian 0 0 -10 100 150 {right} 200 -1 -1 -1 -1000 -1000 -1000 -10"
        return "".join(f"{frame} 1 {label}\n" for frame in range(9)).encode()

    detections = "".join(f"{frame},100,150,120,200,0.9\n" for frame in range(9)).encode()
    page = opened()
    files = [("0012.txt", truth(1241)), ("0013.txt", truth(1241)), ("0016.txt", truth(1223))]
    send(page, "upload_truth", *files)
    send(page, "upload_system_0", *((name, detections) for name, _ in files))
    page = checked(page.run())
    assert list(asked(page).values()) == [1242, 375, 10]
    assert "The boxes end at this width; other recordings: 0016 1224 × 370." in texts(page)
    page.text_input(key="upload_name_0").set_value("RRC")
    press(page, "open_upload")
    sizes = space_of(page).opened.dataset.recordings.set_index("name")["width"].to_dict()
    assert sizes == {"0012": 1242, "0013": 1242, "0016": 1224}


def test_names_that_the_files_do_not_tell_are_asked_for_once_before_opening():
    page = kitti_page()
    press(page, "open_upload")
    assert "do not tell what System 1 and System 2 are" in texts(page)
    assert space_of(page).opened.label == "Sample recordings"
    press(page, "open_upload")
    assert space_of(page).opened.dataset.systems == ("System 1", "System 2")


def test_files_of_one_name_get_numbered_names_and_typed_ones_name_systems_and_recording():
    page = kitti_page()
    names = [page.text_input(key=f"upload_name_{number}").value for number in range(2)]
    assert names == ["System 1", "System 2"]
    assert texts(page).count("do not tell which system this is") == 2
    page.text_input(key="upload_name_0").set_value("RRC")
    page.text_input(key="upload_name_1").set_value("PointRCNN")
    page.text_input(key="recording_name_upload").set_value("crossing")
    press(page, "open_upload")
    assert space_of(page).opened.dataset.systems == ("RRC", "PointRCNN")
    assert recordings_of(page)["name"].tolist() == ["crossing"]
    assert not any("0016" in text for text in page.table[-1].value["Read as"])


def test_a_name_told_by_a_file_follows_the_file_until_one_is_typed(tmp_path: Path):
    page = sent_drive(tmp_path, "fir.csv")
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
    assert page.text_input(key="recording_name_upload").value == "drive"


def test_a_name_that_only_says_gt_is_said_to_be_none(tmp_path: Path):
    truth, late = late_drive(tmp_path)
    page = opened()
    send(page, "upload_truth", ("gt.csv", truth))
    send(page, "upload_system_0", ("A_result.csv", late))
    checked(page.run())
    assert "does not tell which recording this is" in texts(page)
    assert page.text_input(key="upload_name_0").value == "A"


def test_a_seqinfo_sent_along_says_size_rate_and_name(tmp_path: Path):
    page = opened()
    info = b"[Sequence]\nname=A7\nimWidth=640\nimHeight=480\nframeRate=20\nseqLength=3\n"
    rows = b"".join(b"%d,1,10,10,20,40,1,1,1\n" % frame for frame in (1, 2, 3))
    send(page, "upload_truth", ("seqinfo.ini", info), ("gt.txt", rows))
    send(page, "upload_system_0", ("fir.txt", rows))
    press(checked(page.run()), "open_upload")
    assert "Opened: Uploaded files" in texts(page)
    assert recordings_of(page)["name"].tolist() == ["A7"]


def test_a_second_upload_starts_without_the_pictures_of_the_first(tmp_path: Path):
    page = open_files(send_video(late_page(tmp_path), "drive.mp4"))
    space = space_of(page)
    assert "Here: drive.mp4" in texts(page)
    for key in ("upload_truth", "upload_system_0"):
        page.file_uploader(key=key).set_value([])
    checked(page.run())
    assert "Here: drive.mp4" not in texts(page)
    send_video(page, "other.mp4")
    assert "Here: other.mp4" in texts(page)
    # the open comparison keeps its own
    assert [path.name for path in space.sent] == ["other.mp4", "drive.mp4"]


def test_the_same_files_opened_again_have_the_same_recording(tmp_path: Path):
    truth, late = late_drive(tmp_path)
    page = opened()
    for form in ("", "_1"):
        send(page, f"upload_truth{form}", ("gt.csv", truth))
        send(page, f"upload_system_0{form}", ("late.csv", late))
        send_video(page, "drive.mp4")
        assert "Here: drive.mp4" in texts(page)
        open_files(page)
        assert recordings_of(page)[["name", "pictures"]].to_numpy().tolist() == [
            ["drive", "drive.mp4"]
        ]
        press(page, "empty_upload")
    assert len(space_of(page).sent) == 1  # the first one is open no more


def test_a_form_can_be_emptied_while_its_comparison_stays_open(tmp_path: Path):
    page = open_files(send_video(late_page(tmp_path), "drive.mp4"))
    press(page, "empty_upload")
    assert not page.file_uploader(key="upload_truth_1").value
    assert "Here: drive.mp4" not in texts(page)
    assert "Open now: Uploaded files" in texts(page)
    assert [path.name for path in space_of(page).sent] == ["drive.mp4"]


def test_a_video_that_cannot_be_opened_stops_until_one_goes_on_without(tmp_path: Path):
    page = send_video(late_page(tmp_path), "cut.mp4", n_bytes=1_000)
    open_files(page)
    assert "cut.mp4: is damaged" in texts(page)
    assert "Some pictures were refused" in texts(page)
    assert ON_SAMPLE in texts(page)
    (without,) = [box for box in page.checkbox if "without the refused" in box.label]
    checked(without.check().run())
    press(page, "open_upload")
    assert "Open now: Uploaded files (1 recording)" in texts(page)
    assert recordings_of(page)["pictures"].tolist() == ["no pictures"]


def test_pictures_of_no_recording_are_named(tmp_path: Path):
    page = send_video(sent_drive(tmp_path, "fir.csv"), "extra.mp4")
    assert "Of no recording by their names: extra.mp4" in texts(page)


def test_a_video_serves_the_recording_of_its_whole_name_alone(tmp_path: Path):
    rows = [f"{frame},10,10,20,60,drive_{n}" for n in (1, 10) for frame in range(9)]
    content = "\n".join(["frame,x,y,w,h,recording", *rows]).encode()
    page = send_video(sent(content, ("fir.csv", content)), "drive_10.mp4")
    assert "By their names: drive_10.mp4 for drive_10." in texts(page)
    assert recordings_of(open_files(page)).set_index("name")["pictures"].to_dict() == {
        "drive_1": "no pictures",
        "drive_10": "drive_10.mp4",
    }


def test_frames_without_a_picture_are_in_the_list_of_findings(tmp_path: Path):
    rows = [f"{frame},10,10,20,60" for frame in range(400)]
    content = "\n".join(["frame,x,y,w,h", *rows]).encode()
    page = open_files(send_video(sent(content, ("fir.csv", content)), "drive.mp4"))
    assert "Open now" in texts(page)
    assert "100 of 400 evaluated frames have none, first frame 300" in texts(page)
    assert "1 about pictures, on which no number depends" in texts(page)


def test_files_that_found_no_room_are_taken_when_there_is_room_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    with monkeypatch.context() as full:
        full.setattr(uploads, "MAX_SESSION_BYTES", 10)
        page = sent_drive(tmp_path, "fir.csv")
        assert "remove uploads that are no longer needed" in texts(page)
    assert checked(page.run()).error == []
    assert "Opened: Uploaded files" in texts(open_files(page))


def test_boxes_to_be_ignored_are_told_apart_before_and_after_opening():
    truth = b"frame,x,y,w,h,ignore\n0,9,9,40,90,0\n1,9,9,40,90,1\n2,9,9,40,90,0\n"
    page = sent(truth, ("a.csv", b"frame,x,y,w,h,score\n1,9,9,40,90,0.5\n"))
    assert "3 boxes in frames 0 to 2, 1 of them to be ignored" in texts(page)
    open_files(page)
    assert page.table[-1].value["Boxes"].tolist() == ["3: 2 pedestrians, 1 to be ignored", "1"]


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
    assert "Give this file as “Evaluated frames”." in texts(page)


def test_a_gap_in_a_list_of_pictures_is_asked_about_at_its_field(tmp_path: Path):
    def files(side: str) -> list[tuple[str, bytes]]:
        folder = write_yolo(
            tmp_path / side, side, lambda i: f"img_{i + (5000 if i >= 20 else 0):06d}.txt"
        )
        return [(file.name, file.read_bytes()) for file in sorted(folder.iterdir())]

    page = opened()
    send(page, "upload_truth", *files("truth"))
    send(page, "upload_system_0", *files("x"))
    checked(page.run())
    (trouble,) = [error.value for error in page.error if "a gap of" in error.value]
    assert "Choose “scenes” as “Names of pictures” under “How to read”" in trouble
    (field,) = [box for box in page.selectbox if box.key == "frame_names_upload_truth"]
    checked(field.set_value("scenes").run())
    assert not page.error
    n_files = len(files("truth"))
    shown = [caption.value for caption in page.caption if caption.value.startswith("Read as")]
    assert (
        shown == [f"Read as YOLO text\\: {n_files} files."] * 2
    )  # both need the size for their boxes


@pytest.mark.parametrize(
    ("field", "title"),
    [("speed", "Speed of the car over time"), ("system_0_alerts", "system 1 (X), its own log of")],
)
def test_an_error_in_a_further_file_names_its_field(tmp_path: Path, field: str, title: str):
    page = late_page(tmp_path)
    send(page, f"upload_{field}", ("mine.csv", b"a,b\n"))
    (_, error) = (error.value.replace("\\", "") for error in open_files(page).error)
    assert error.startswith(title)
    assert ": mine.csv, line 1: " in error


def test_boxes_that_another_system_has_are_pointed_out_at_the_field(tmp_path: Path):
    page = sent_drive(tmp_path, "fir.csv", "nir.csv")
    assert "the same boxes" not in texts(page)
    header, *rows = (tmp_path / "fir.csv").read_text().splitlines()
    other = "\n".join([header, *reversed(rows)]).encode()
    send(page, "upload_system_1", ("other.csv", other))
    assert "The file has the same boxes as system 1 (X)." in texts(checked(page.run()))


@pytest.mark.parametrize(
    ("others", "folders"),
    [
        (("det_frcnn/A.txt", "det_sdp/A.txt"), "det_frcnn and det_sdp look like one system each"),
        (
            ("A/gt/gt.txt", "A/det_frcnn/det.txt", "B/det_sdp/det.txt"),
            "no detections (*/det/det.txt), but the folders det_frcnn and det_sdp",
        ),
    ],
)
def test_an_archive_of_several_systems_names_their_folders(others: tuple[str, ...], folders: str):
    rows = b"".join(b"%d,1,10,10,20,40,1,1,1\n" % frame for frame in range(1, 30))

    def packed(*names: str) -> bytes:
        content = io.BytesIO()
        with zipfile.ZipFile(content, "w") as archive:
            for name in names:
                archive.writestr(name, rows)
        return content.getvalue()

    page = opened()
    send(page, "upload_truth", ("gt.zip", packed("A/gt/gt.txt", "B/gt/gt.txt")))
    send(page, "upload_system_0", ("all.zip", packed(*others)))
    (error,) = [error.value.replace("\\", "") for error in checked(page.run()).error]
    assert folders in error
    assert "archive of" in error
