"""The Data page: session files, and files below the local root."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from data_page import (
    ASKED,
    PNG,
    ROOT,
    answer,
    opened,
    press,
    recordings_of,
    send,
    sizes_of,
    space_of,
)
from inputs import drive, mot_layout, write
from streamlit.testing.v1 import AppTest

from pages import checked, texts
from pages import opened as opened_app


def opened_session_file(folder: Path, text: str, *names: str) -> AppTest:
    """The page once a session file was sent, with these files of the drive."""
    page = opened()
    drive(folder)
    send(page, "session_file", ("mine.toml", text.encode()))
    send(page, "session_files", *((name, (folder / name).read_bytes()) for name in names))
    return press(page, "open_session_file")


def test_a_session_file_opens_with_the_files_it_names(tmp_path: Path):
    session = (
        '[defaults]\nsize = "640x480"\nfps = 20\n[truth]\npath = "/elsewhere/truth.csv"\n'
        '[[system]]\nname = "far"\npath = "fir.csv"\nthreshold = 0.8\n'
        '[[system]]\npath = "runs/nir.csv"\n[parameters]\nalpha = 0.7\n'
    )
    page = opened_session_file(tmp_path, session, "truth.csv", "fir.csv", "nir.csv")
    assert "Open now: mine.toml (" in texts(page)
    assert page.table[-1].value["Source"].tolist() == ["Truth", "X: far", "Y: nir"]
    assert page.session_state["params"].threshold_x == 0.8
    assert "Every detection of nir counts, however low its score" in texts(page)
    assert page.session_state["params"].alpha == 0.7


def test_files_of_one_name_beside_a_session_file_are_refused():
    page = opened()
    send(page, "session_file", ("mine.toml", b'[truth]\npath = "a/x.csv"\n'))
    send(page, "session_files", ("x.csv", b"1"), ("x.csv", b"2"))
    assert "2 files are called x.csv" in texts(press(page, "open_session_file"))


BARE_SESSION = '[truth]\npath = "truth.csv"\n[[system]]\npath = "fir.csv"\n'
"""Says neither the size of the pictures nor the frame rate."""


def test_a_session_file_that_lacks_facts_asks_for_them_and_opens(tmp_path: Path):
    page = opened_session_file(tmp_path, BARE_SESSION, "truth.csv", "fir.csv")
    assert "Fill in the fields for it" in texts(page)
    answer(page, "session_file", **ASKED)
    press(page, "open_session_file")
    assert "Open now: mine.toml (" in texts(page)
    assert sizes_of(page) == [(640, 480)] * 2


def test_a_session_file_cannot_name_files_of_the_machine(tmp_path: Path):
    session = BARE_SESSION.replace('path = "', f'path = "{tmp_path}/')
    page = opened_session_file(tmp_path, f'[defaults]\nsize = "640x480"\nfps = 20\n{session}')
    assert "'truth.csv', which was not sent" in texts(page)
    send(page, "session_file", ("mine.toml", PNG))
    assert "is not TOML" in texts(press(page, "open_session_file"))


@pytest.fixture
def local(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., AppTest]:
    """Opens the page with a local root, and chooses paths below it, by role."""

    def open_page(root: Path = tmp_path, **chosen: str) -> AppTest:
        monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(root))
        page = opened()
        return choose_local(page, **chosen) if chosen else page

    return open_page


def choose_local(page: AppTest, **chosen: str) -> AppTest:
    systems = {"x": "system_0", "y": "system_1"}
    for role, path in chosen.items():
        page.multiselect(key=f"local_{systems.get(role, role)}").set_value([path])
    return checked(page.run())


def open_local(page: AppTest) -> AppTest:
    answer(page, "local", **ASKED)
    return press(page, "open_local")


def test_a_local_session_that_lacks_facts_asks_for_them_and_opens(tmp_path: Path, local):
    drive(tmp_path)
    # a name of pictures that no file can have does not keep it from opening
    recording = f'[[recording]]\nname = "urban"\npictures = "{"a" * 300}"\n'
    (tmp_path / "mine.toml").write_text(recording + BARE_SESSION)
    page = press(local(), "open_local_session")
    assert "Fill in the fields for it" in texts(page)
    answer(page, "local_session", **ASKED)
    press(page, "open_local_session")
    assert "Open now: mine.toml (" in texts(page)
    assert "Recordings whose pictures cannot be opened" in texts(page)
    assert "cannot be opened" in " ".join(recordings_of(page)["note"])


def test_a_local_session_that_names_files_outside_is_refused(tmp_path: Path, local):
    drive(tmp_path / "private")
    session = BARE_SESSION.replace('path = "', 'path = "../private/')
    write(tmp_path / "night" / "session.toml", session)
    page = press(local(tmp_path / "night"), "open_local_session")
    assert "lies outside the folder" in texts(page)
    assert str(tmp_path) not in texts(page)


def test_a_local_root_that_is_not_there_is_told(local):
    assert "there is no such folder" in texts(local(Path("/nowhere/night")))


def test_files_below_the_local_root_are_opened(tmp_path: Path, local):
    drive(tmp_path / "night" / "one")
    page = local(tmp_path / "night")
    assert "Local folder" in [tab.label for tab in page.tabs]
    checked(page.selectbox(key="local_next").set_value("one").run())
    open_local(choose_local(page, truth="one/truth.csv", x="one/fir.csv", y="one/nir.csv"))
    assert page.table[-1].value["Source"].tolist() == ["Truth", "X: fir", "Y: nir"]


def test_a_pattern_names_the_files_of_all_recordings(tmp_path: Path, local):
    mot_layout(tmp_path / "mot")
    page = local()
    checked(page.selectbox(key="local_next").set_value("mot").run())
    assert page.multiselect(key="local_truth").options[:2] == [
        "mot/*/det/det.txt",
        "mot/*/gt/gt.txt",
    ]
    choose_local(page, truth="mot/*/gt/gt.txt", x="mot/*/det/det.txt")
    press(page, "open_local")
    assert recordings_of(page)["name"].tolist() == ["A", "B"]

    # the files of all recordings have one name, and each takes the place of its own
    for name in ("A", "B"):
        file = tmp_path / "mot" / name / "det" / "det.txt"
        write(tmp_path / "mot" / name / "new" / "det.txt", *file.read_text().splitlines()[:2])
    checked(page.segmented_control(key="form_purpose_local").set_value("replace").run())
    key = f"local_change_{space_of(page).n_opened}_system_0"
    checked(page.multiselect(key=key).set_value(["mot/*/new/det.txt"]).run())
    press(page, "open_local")
    dataset = space_of(page).opened.whole
    rows = dataset.system(dataset.systems[0]).frame_index
    assert np.bincount(dataset.frame_columns.recording[rows]).tolist() == [2, 2]


def test_local_files_of_one_name_are_called_by_their_folders(tmp_path: Path, local):
    drive(tmp_path)
    for name, folder in (("fir", "faster"), ("nir", "tracker")):
        write(tmp_path / folder / "out.csv", (tmp_path / f"{name}.csv").read_text())
    page = local(truth="truth.csv", x="faster", y="tracker")
    names = [page.text_input(key=f"local_name_{number}").value for number in range(2)]
    assert names == ["faster", "tracker"]
    assert open_local(page).table[-1].value["Source"].tolist()[1:] == ["X: faster", "Y: tracker"]


def test_what_was_mended_in_a_chosen_folder_is_read_again(tmp_path: Path, local):
    drive(tmp_path)
    good = (tmp_path / "truth.csv").read_bytes()
    file = write(tmp_path / "truth" / "night.csv", "frame,x,y,w,h", "1,2,3,4,oops")
    mot_layout(tmp_path, ("A",))
    info = write(tmp_path / "A" / "seqinfo.ini", "[Wrong]")
    page = local(truth="truth", x="fir.csv")
    assert "night.csv, line 2" in texts(page)
    file.write_bytes(good)
    assert checked(page.run()).error == []
    assert "Read as plain CSV: 2 recordings, 40 boxes" in texts(page)
    choose_local(page, truth="A")
    assert "expected a section [Sequence]" in texts(page)
    write(info, "[Sequence]", "frameRate=10", "imWidth=640", "imHeight=480", "seqLength=5")
    assert "expected a section [Sequence]" not in texts(checked(page.run()))


def test_chosen_pictures_that_go_are_told_and_the_page_lives_on(tmp_path: Path, local):
    drive(tmp_path)
    video = shutil.copy(ROOT / "sample_data" / "odd_pose.mp4", tmp_path / "drive.mp4")
    page = local(truth="truth.csv", x="fir.csv", pictures="drive.mp4")
    assert page.error == []
    Path(video).unlink()
    checked(page.run())
    (error,) = page.error
    assert "drive.mp4: there is no such file or folder" in error.value.replace("\\", "")
    (without,) = [box for box in page.checkbox if "without the refused" in box.label]
    checked(without.check().run())
    assert "Opened: Local files" in texts(open_local(page))


def test_a_local_list_of_evaluated_frames_is_followed_and_stops_the_opening_when_it_goes(
    tmp_path: Path, local
):
    """Frames 0, 3 and 9 were looked at, and boxes stand in two."""
    write(tmp_path / "truth.csv", "frame,x,y,w,h", "0,100,100,40,90", "9,100,100,40,90")
    write(tmp_path / "fir.csv", "frame,x,y,w,h,score", "0,100,100,40,90,0.9", "3,9,9,40,90,0.4")
    frames = write(tmp_path / "frames.txt", "0", "3", "9")
    chosen = {"truth": "truth.csv", "x": "fir.csv", "frames": "frames.txt"}
    page = open_local(local(**chosen))
    assert space_of(page).opened.dataset.frames["frame"].tolist() == [0, 3, 9]
    page = local(**chosen)
    assert "Read as 3 frames, 0 to 9." in texts(page)
    frames.unlink()
    open_local(checked(page.run()))
    assert "frames.txt: there is no such file" in texts(page)
    assert "The list of evaluated frames cannot be used" in texts(page)


def test_the_second_sample_opens_beside_the_first():
    page = press(checked(opened_app("data")), "open_signs")
    assert "Opened: Sample drives past speed signs" in texts(page)
    assert space_of(page).opened.dataset.systems == ("Mono", "Stereo")
