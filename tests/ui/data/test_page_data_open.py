"""The Data page: session files, and files below the local root."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from data_page import PNG, ROOT, answer, opened, press, send, space_of
from inputs import drive, mot_layout, write
from streamlit.testing.v1 import AppTest

from pages import checked, texts


def test_a_session_file_opens_with_the_files_it_names(tmp_path: Path):
    page = opened()
    drive(tmp_path)
    session = (
        '[defaults]\nsize = "640x480"\nfps = 20\n[truth]\npath = "/elsewhere/truth.csv"\n'
        '[[system]]\nname = "far"\npath = "fir.csv"\nthreshold = 0.8\n'
        '[[system]]\npath = "runs/nir.csv"\n[parameters]\nalpha = 0.7\n'
    )
    page.file_uploader(key="session_file").set_value(("mine.toml", session.encode(), "text/plain"))
    names = ("truth.csv", "fir.csv", "nir.csv")
    send(page, "session_files", *((name, (tmp_path / name).read_bytes()) for name in names))
    press(page, "open_session_file")
    assert "Open now: mine.toml (" in texts(page)
    assert page.table[0].value["Source"].tolist() == ["Truth", "X: far", "Y: nir"]
    assert page.number_input(key="data_threshold_x").value == 0.8


BARE_SESSION = b'[truth]\npath = "truth.csv"\n[[system]]\npath = "fir.csv"\n'
"""Says neither the size of the pictures nor the frame rate."""


def test_a_session_file_that_lacks_facts_asks_for_them_and_opens(tmp_path: Path):
    page = opened()
    drive(tmp_path)
    send(page, "session_file", ("mine.toml", BARE_SESSION))
    names = ("truth.csv", "fir.csv")
    send(page, "session_files", *((name, (tmp_path / name).read_bytes()) for name in names))
    press(page, "open_session_file")
    assert "Fill in the fields for it" in texts(page)
    answer(page, "session_file", width=640, height=480, fps=20.0)
    press(page, "open_session_file")
    assert "Open now: mine.toml (" in texts(page)
    assert page.table[1].value["Size (px)"].tolist() == ["640 × 480"] * 2


def test_a_local_session_that_lacks_facts_asks_for_them_and_opens(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path)
    (tmp_path / "mine.toml").write_bytes(BARE_SESSION)
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    page = press(opened(), "open_local_session")
    assert "Fill in the fields for it" in texts(page)
    answer(page, "local_session", width=640, height=480, fps=20.0)
    press(page, "open_local_session")
    assert "Open now: mine.toml (" in texts(page)


def test_a_local_session_with_a_long_name_of_pictures_is_opened_without_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path)
    facts = b'[defaults]\nsize = "640x480"\nfps = 20\n[[recording]]\nname = "urban"\n'
    pictures = f'pictures = "{"a" * 300}"\n'.encode()
    (tmp_path / "mine.toml").write_bytes(facts + pictures + BARE_SESSION)
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    page = press(opened(), "open_local_session")
    assert "Open now: mine.toml (" in texts(page)
    assert "cannot be opened" in " ".join(page.table[1].value["Pictures"])


def test_a_session_file_cannot_name_files_of_the_machine(tmp_path: Path):
    page = opened()
    drive(tmp_path)
    session = (
        f'[defaults]\nsize = "640x480"\nfps = 20\n[truth]\npath = "{tmp_path}/truth.csv"\n'
        f'[[system]]\npath = "{tmp_path}/fir.csv"\n'
    )
    page.file_uploader(key="session_file").set_value(("mine.toml", session.encode(), "text/plain"))
    press(page, "open_session_file")
    assert "'truth.csv', which was not sent" in texts(page)


def test_a_session_file_that_is_no_toml_is_told():
    page = opened()
    page.file_uploader(key="session_file").set_value(("mine.toml", PNG, "text/plain"))
    press(page, "open_session_file")
    assert "is not TOML" in texts(page)


def test_files_of_the_machine_are_out_of_reach_unless_asked_for():
    page = opened()
    assert [tab.label for tab in page.tabs] == ["Sample", "Upload", "Session file"]


def test_files_below_the_local_root_are_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    drive(tmp_path / "night" / "one")
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path / "night"))
    page = opened()
    assert [tab.label for tab in page.tabs][-1] == "Local folder"
    checked(page.selectbox(key="local_next").set_value("one").run())
    for key, name in (("truth", "truth"), ("x", "fir"), ("y", "nir")):
        page.multiselect(key=f"local_{key}").set_value([f"one/{name}.csv"])
    checked(page.run())
    answer(page, "local", width=640, height=480, fps=20.0)
    press(page, "open_local")
    assert page.table[0].value["Source"].tolist() == ["Truth", "X: fir", "Y: nir"]


def test_a_local_session_that_names_files_outside_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path / "private")
    root = tmp_path / "night"
    write(
        root / "session.toml",
        '[defaults]\nsize = "640x480"\nfps = 20', '[truth]\npath = "../private/truth.csv"',
        '[[system]]\npath = "../private/fir.csv"',
    )  # fmt: skip
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(root))
    page = press(opened(), "open_local_session")
    assert "lies outside the folder" in texts(page)
    assert str(tmp_path) not in texts(page)


def test_a_local_root_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", "/nowhere/night")
    page = opened()
    assert "there is no such folder" in texts(page)


def test_local_files_of_one_name_are_called_by_their_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path)
    for name, folder in (("fir", "faster"), ("nir", "tracker")):
        write(tmp_path / folder / "out.csv", (tmp_path / f"{name}.csv").read_text())
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    page = opened()
    for key, path in (("truth", "truth.csv"), ("x", "faster"), ("y", "tracker")):
        page.multiselect(key=f"local_{key}").set_value([path])
    checked(page.run())
    names = [page.text_input(key=f"local_{letter}_name").value for letter in "xy"]
    assert names == ["faster", "tracker"]
    answer(page, "local", width=640, height=480, fps=20.0)
    press(page, "open_local")
    assert page.table[0].value["Source"].tolist() == ["Truth", "X: faster", "Y: tracker"]


def test_a_local_file_that_cannot_be_used_is_told_at_its_field(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path)
    (tmp_path / "bad.csv").write_bytes(PNG)
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    page = opened()
    page.multiselect(key="local_truth").set_value(["bad.csv"])
    page.multiselect(key="local_x").set_value(["fir.csv"])
    checked(page.run())
    (told,) = page.error
    assert "bad.csv: expected ground truth, found a PNG" in told.value.replace("\\", "")
    press(page, "open_local")
    assert "The files of the ground truth cannot be used" in texts(page)


def local_page(root: Path, monkeypatch: pytest.MonkeyPatch, **chosen: str) -> AppTest:
    """The form with what was chosen below the root, by role."""
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(root))
    page = opened()
    for role, path in chosen.items():
        page.multiselect(key=f"local_{role}").set_value([path])
    return checked(page.run())


def test_a_file_that_was_mended_in_a_chosen_folder_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path)
    good = (tmp_path / "truth.csv").read_bytes()
    file = write(tmp_path / "truth" / "night.csv", "frame,x,y,w,h", "1,2,3,4,oops")
    page = local_page(tmp_path, monkeypatch, truth="truth", x="fir.csv")
    assert "night.csv, line 2" in texts(page)
    file.write_bytes(good)
    checked(page.run())
    assert page.error == []
    assert "Read as plain CSV: 40 boxes" in texts(page)


def test_a_seqinfo_that_was_mended_is_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    mot_layout(tmp_path, ("A",))
    info = write(tmp_path / "A" / "seqinfo.ini", "[Wrong]")
    page = local_page(tmp_path, monkeypatch, truth="A")
    assert "expected a section [Sequence]" in texts(page)
    write(info, "[Sequence]", "frameRate=10", "imWidth=640", "imHeight=480", "seqLength=5")
    assert checked(page.run()).error == []


def test_chosen_pictures_that_go_are_told_and_the_page_lives_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path)
    video = shutil.copy(ROOT / "sample_data" / "odd_pose.mp4", tmp_path / "drive.mp4")
    page = local_page(tmp_path, monkeypatch, truth="truth.csv", x="fir.csv", pictures="drive.mp4")
    assert page.error == []
    Path(video).unlink()
    checked(page.run())
    (told,) = page.error
    assert "These pictures were refused" in told.value
    assert "drive.mp4: there is no such file or folder" in told.value.replace("\\", "")
    assert page.button(key="open_local").label == "Open these files"
    (without,) = [one for one in page.checkbox if "without the refused" in one.label]
    checked(without.check().run())
    answer(page, "local", width=640, height=480, fps=20.0)
    press(page, "open_local")
    assert "Opened: Local files" in texts(page)


def sampled_drive(folder: Path) -> Path:
    """One recording of which the frames 0, 3 and 9 were looked at, and boxes stand in two."""
    write(folder / "truth.csv", "frame,x,y,w,h", "0,100,100,40,90", "9,100,100,40,90")
    write(folder / "fir.csv", "frame,x,y,w,h,score", "0,100,100,40,90,0.9", "3,9,9,40,90,0.4")
    return write(folder / "frames.txt", "0", "3", "9")


def test_a_local_list_of_evaluated_frames_is_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    sampled_drive(tmp_path)
    chosen = {"truth": "truth.csv", "x": "fir.csv", "frames": "frames.txt"}
    page = local_page(tmp_path, monkeypatch, **chosen)
    assert "Read as 3 frames, 0 to 9." in texts(page)
    answer(page, "local", width=640, height=480, fps=20.0)
    press(page, "open_local")
    assert space_of(page).opened.dataset.frames["frame"].tolist() == [0, 3, 9]


def test_a_local_list_of_frames_that_goes_stops_the_opening(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    frames = sampled_drive(tmp_path)
    chosen = {"truth": "truth.csv", "x": "fir.csv", "frames": "frames.txt"}
    page = local_page(tmp_path, monkeypatch, **chosen)
    frames.unlink()
    checked(page.run())
    answer(page, "local", width=640, height=480, fps=20.0)
    press(page, "open_local")
    assert "frames.txt: there is no such file" in texts(page)
    assert "The list of evaluated frames cannot be used" in texts(page)
