"""The Data page, driven without a browser: what people open, good and bad."""

from __future__ import annotations

import asyncio
import io
import zipfile
from pathlib import Path

import pytest
from inputs import drive, mot_layout, write
from streamlit.testing.v1 import AppTest

from ui.uploads import PICTURES, receive

ROOT = Path(__file__).resolve().parents[2]
PAGE = f"""
import runpy
from ui import sidebar, state
state.begin_run()
sidebar.draw()
runpy.run_path({str(ROOT / "pages" / "data.py")!r})
"""
PNG = b"\x89PNG\r\n\x1a\n" + bytes(100)


@pytest.fixture(autouse=True)
def surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))
    monkeypatch.delenv("NVCORE_LOCAL_ROOT", raising=False)


def opened() -> AppTest:
    page = AppTest.from_string(PAGE, default_timeout=60)
    return checked(page.run())


def checked(page: AppTest) -> AppTest:
    assert [error.message for error in page.exception] == []
    return page


def press(page: AppTest, key: str) -> AppTest:
    return checked(page.button(key=key).click().run())


def texts(page: AppTest) -> str:
    """All that is said in words, markup taken away."""
    kinds = (page.markdown, page.caption, page.error, page.warning, page.info, page.success,
             page.header)  # fmt: skip
    return "\n".join(one.value for kind in kinds for one in kind).replace("\\", "")


def send(page: AppTest, key: str, *files: tuple[str, bytes]) -> None:
    page.file_uploader(key=key).set_value([(*file, "application/octet-stream") for file in files])


def send_drive(page: AppTest, folder: Path, *systems: str) -> None:
    drive(folder)
    send(page, "upload_truth", ("truth.csv", (folder / "truth.csv").read_bytes()))
    for number, name in enumerate(systems):
        send(page, f"upload_system_{number}", (name, (folder / name).read_bytes()))


def answer(page: AppTest, place: str = "upload", **values: float) -> None:
    """Fill in what the page asks for: width, height, fps."""
    for name, value in values.items():
        (field,) = [
            one for one in page.number_input if (one.key or "").startswith(f"{name}_{place}")
        ]
        field.set_value(value)


def opened_drive(folder: Path, *systems: str) -> AppTest:
    page = opened()
    send_drive(page, folder, *systems)
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    return press(page, "open_upload")


def space_of(page: AppTest):
    return page.session_state["workspace"]


def test_the_page_opens_on_the_sample():
    page = opened()
    assert "Open: Sample recordings" in texts(page)
    assert page.table[0].value["Source"].tolist() == ["Truth", "X: FIR", "Y: NIR"]
    assert len(page.table[1].value) == 10


def test_an_input_is_shown_with_its_conversion_and_without_folders_of_the_machine():
    table = opened().table[0].value
    assert [name.replace("\\", "") for name in table["Files"]] == [
        "truth.csv",
        "fir.csv",
        "nir.csv",
    ]
    assert all("pixels" in text for text in table["Read as"])


def test_pictures_of_the_sample_are_found():
    shown = opened().table[1].value["Pictures"]
    assert shown.str.contains("mp4", regex=False).all()


def test_an_upload_asks_for_what_the_files_do_not_say_and_opens_with_it(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    press(page, "open_upload")
    assert "image size and the frame rate" in texts(page)
    assert "Open: Sample recordings" in texts(page)
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
    assert space_of(page).dataset.systems == ("one", "<b>two</b>")


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


def test_choosing_x_as_y_swaps_them():
    page = opened()
    checked(page.selectbox(key="choice_y").set_value("FIR").run())
    assert (page.selectbox(key="choice_x").value, page.selectbox(key="choice_y").value) == (
        "NIR", "FIR",
    )  # fmt: skip


def test_swapping_takes_the_thresholds_along():
    page = opened()
    checked(page.number_input(key="data_threshold_x").set_value(0.7).run())
    before = page.number_input(key="data_threshold_y").value
    press(page, "swap_systems")
    assert page.number_input(key="data_threshold_y").value == 0.7
    assert page.number_input(key="data_threshold_x").value == before


def test_a_threshold_changes_what_is_kept():
    page = opened()
    before = page.metric[0].value
    checked(page.number_input(key="data_threshold_x").set_value(0.99).run())
    kept = int(page.metric[0].value.split(" of ")[0].replace(",", ""))
    assert kept < int(before.split(" of ")[0].replace(",", ""))


def test_the_same_operating_point_sets_the_threshold_of_y():
    page = opened()
    checked(page.number_input(key="data_threshold_x").set_value(0.9).run())
    press(page, "same_point")
    assert "false alarms per frame, X has" in texts(page)
    assert page.number_input(key="data_threshold_y").value > 0.5


def test_the_same_operating_point_may_lie_above_the_highest_score(tmp_path: Path):
    drive(tmp_path)
    with (tmp_path / "nir.csv").open("a") as stream:  # the best score is a false alarm
        stream.write("rural,5,500,200,40,100,0.95\n")
    page = opened()
    for key, name in (("truth", "truth"), ("system_0", "fir"), ("system_1", "nir")):
        send(page, f"upload_{key}", (f"{name}.csv", (tmp_path / f"{name}.csv").read_bytes()))
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    press(page, "same_point")
    assert page.session_state["params"].threshold_y > 0.95
    assert "0 false alarms per frame, X has 0." in texts(page)
    assert [one.value for one in page.metric if "False alarms" in one.label] == ["0.0", "0.0"]


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
    assert "Open: Sample recordings" in texts(page)


def test_an_error_names_no_folder_of_the_machine(tmp_path: Path):
    page = opened()
    send_drive(page, tmp_path, "fir.csv", "nir.csv")
    send(page, "upload_truth", ("truth.csv", b"frame,x,y,w,h\n1,2,3,4,oops\n"))
    press(page, "open_upload")
    (error,) = page.error
    assert "truth.csv, line 2" in error.value.replace("\\", "")
    assert "annotations" not in error.value
    assert "upload" not in error.value


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


def late_drive(folder: Path) -> tuple[bytes, bytes]:
    """Truth of three pedestrians walking across, and detections that are 3 frames late."""
    truth, late = ["frame,x,y,w,h,track"], ["frame,x,y,w,h,score"]
    for frame in range(60):
        for track in range(3):
            x = 20 + 150 * track + 4 * frame
            truth.append(f"{frame},{x},100,20,60,{track}")
            late.append(f"{frame + 3},{x},100,20,60,0.9")
    paths = write(folder / "t.csv", *truth), write(folder / "l.csv", *late)
    return paths[0].read_bytes(), paths[1].read_bytes()


def test_a_time_offset_found_is_applied_with_one_click(tmp_path: Path):
    page = opened()
    truth, late = late_drive(tmp_path)
    send(page, "upload_truth", ("truth.csv", truth))
    send(page, "upload_system_0", ("good.csv", truth.replace(b"track", b"score")))
    send(page, "upload_system_1", ("late.csv", late))
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert "3 frames too late" in texts(page)
    keys = [b.key for b in page.button if (b.key or "").startswith("apply_")]
    press(page, keys[0])
    assert space_of(page).session.systems[1].offset_frames == -3
    assert "frames too late" not in texts(page)


def test_findings_stand_worst_first(tmp_path: Path):
    page = opened()
    truth, _ = late_drive(tmp_path)
    twice = truth + b"5,40,100,20,60,0\n"
    send(page, "upload_truth", ("truth.csv", twice))
    send(page, "upload_system_0", ("good.csv", truth.replace(b"track", b"score")))
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    badges = [one.value for one in page.markdown if "-badge[" in one.value]
    order = [("Error" in one, "Warning" in one) for one in badges]
    assert order == sorted(order, reverse=True)
    assert "Error" in badges[0]


def send_video(page: AppTest, name: str) -> None:
    """As the upload route does it."""

    async def content():
        yield (ROOT / "sample_data" / "odd_pose.mp4").read_bytes()

    asyncio.run(receive(space_of(page), PICTURES, name, content()))


def late_page(folder: Path) -> AppTest:
    """The form with one recording and a system, not sent yet."""
    page = opened()
    truth, late = late_drive(folder)
    send(page, "upload_truth", ("night.csv", truth))
    send(page, "upload_system_0", ("late.csv", late))
    return page


def test_the_size_is_proposed_from_the_pictures_and_they_find_their_recording(tmp_path: Path):
    page = late_page(tmp_path)
    send_video(page, "drive.mp4")
    press(page, "open_upload")
    answer(page, fps=20.0)
    press(page, "open_upload")
    assert page.table[1].value["Size (px)"].tolist() == ["640 × 480"]
    assert "drive.mp4" in page.table[1].value["Pictures"][0].replace("\\", "")
    assert (space_of(page).picture_rows[0] == range(60)).all()


def test_the_first_pictures_frame_can_be_given(tmp_path: Path):
    page = late_page(tmp_path)
    send_video(page, "drive.mp4")
    press(page, "open_upload")
    answer(page, fps=20.0)
    press(page, "open_upload")
    (field,) = [one for one in page.number_input if "first picture" in one.label]
    field.set_value(1)
    (submit,) = [one for one in page.button if one.label == "Use these pictures"]
    checked(submit.click().run())
    assert space_of(page).picture_rows[0].tolist() == list(range(-1, 59))
    assert "1 of 60 listed frames have no picture" in page.table[1].value["Pictures"][0]


def test_pictures_sent_later_can_be_chosen_and_taken_away_again(tmp_path: Path):
    page = opened()
    send_video(page, "more.mp4")
    (choice,) = [one for one in checked(page.run()).selectbox if one.label == "Pictures"]
    choice.set_value("more.mp4")
    (submit,) = [one for one in page.button if one.label == "Use these pictures"]
    checked(submit.click().run())
    assert space_of(page).pictures[0].name == "more.mp4"
    (choice,) = [one for one in page.selectbox if one.label == "Pictures"]
    choice.set_value("no pictures")
    (submit,) = [one for one in page.button if one.label == "Use these pictures"]
    checked(submit.click().run())
    assert 0 not in space_of(page).pictures


def test_removed_pictures_are_no_longer_offered(tmp_path: Path):
    page = opened()
    send_video(page, "more.mp4")
    checked(page.run())
    press(page, "remove_pictures")
    (choice,) = [one for one in page.selectbox if one.label == "Pictures"]
    assert "more.mp4" not in choice.options


def test_a_live_parameter_survives_a_correction_of_the_session(tmp_path: Path):
    page = opened()
    checked(page.slider(key="alpha").set_value(0.6).run())
    (submit,) = [one for one in page.button if one.label == "Use these pictures"]
    checked(submit.click().run())
    assert page.session_state["params"].alpha == 0.6


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
    assert "Open: mine.toml" in texts(page)
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
    assert "Fill in the fields below" in texts(page)
    answer(page, "session_file", width=640, height=480, fps=20.0)
    press(page, "open_session_file")
    assert "Open: mine.toml" in texts(page)
    assert page.table[1].value["Size (px)"].tolist() == ["640 × 480"] * 2


def test_a_local_session_that_lacks_facts_asks_for_them_and_opens(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path)
    (tmp_path / "mine.toml").write_bytes(BARE_SESSION)
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    page = press(opened(), "open_local_session")
    assert "Fill in the fields below" in texts(page)
    answer(page, "local_session", width=640, height=480, fps=20.0)
    press(page, "open_local_session")
    assert "Open: mine.toml" in texts(page)


def test_a_local_session_with_a_long_name_of_pictures_is_opened_without_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drive(tmp_path)
    facts = b'[defaults]\nsize = "640x480"\nfps = 20\n[[recording]]\nname = "urban"\n'
    pictures = f'pictures = "{"a" * 300}"\n'.encode()
    (tmp_path / "mine.toml").write_bytes(facts + pictures + BARE_SESSION)
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    page = press(opened(), "open_local_session")
    assert "Open: mine.toml" in texts(page)
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
    press(page, "open_local")
    for name, value in (("width", 640), ("height", 480), ("fps", 20.0)):
        (field,) = [one for one in page.number_input if (one.key or "").startswith(f"{name}_local")]
        field.set_value(value)
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


def test_two_sessions_do_not_see_each_others_data(tmp_path: Path):
    mine, other = opened_drive(tmp_path, "fir.csv"), opened()
    assert "Open: Sample recordings" in texts(other)
    assert "Open: Uploaded files" in texts(mine)
    assert space_of(mine).token != space_of(other).token
