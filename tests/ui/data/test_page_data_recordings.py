"""The Data page: a table of recordings that is sent along, and their traffic context."""

from __future__ import annotations

from pathlib import Path

import pytest
from data_page import (
    Edit,
    open_files,
    opened,
    opened_drive,
    press,
    recordings_of,
    send,
    sent_drive,
    space_of,
)
from inputs import drive, write
from streamlit.testing.v1 import AppTest

from pages import checked, texts

TABLE = (
    b"recording,width,height,fps,context,speed_kmh,horizon,tags,pictures\n"
    b"urban,640,480,20,urban,50,,night,\nrural,640,480,20,0.75,,236.5,,\n"
)


def with_table(folder: Path, content: bytes) -> AppTest:
    page = sent_drive(folder, "fir.csv", "nir.csv")
    send(page, "upload_recordings", ("recordings.csv", content))
    return checked(page.run())


def contexts(page: AppTest) -> list[str]:
    return recordings_of(page)["context"].tolist()


def test_a_table_of_recordings_answers_what_the_files_do_not_say(tmp_path: Path):
    page = with_table(tmp_path, TABLE)
    assert (
        "Read as 2 recordings: sizes, frame rates, traffic context, speeds, horizon and tags."
        in texts(page)
    )
    assert "Not in the files" not in texts(page)
    press(page, "open_upload")
    assert page.error == []
    assert contexts(page) == ["urban", "0.75"]
    dataset = space_of(page).opened.dataset
    assert dataset.recordings["context"].tolist() == [0, 0.75]
    assert dataset.recordings["speed_kmh"].fillna(-1).tolist() == [50, -1]
    assert dataset.recordings["horizon"].fillna(-1).tolist() == [-1, 236.5]
    assert dataset.recordings["tags"].tolist() == [("night",), ()]


def test_a_table_that_lacks_a_rate_leaves_that_to_be_asked_for(tmp_path: Path):
    page = with_table(tmp_path, b"recording,width,height,fps\nurban,640,480,20\nrural,640,480,\n")
    assert "Not in the files: the frame rate" in texts(page)
    open_files(page, fps=10.0)
    recordings = space_of(page).opened.dataset.recordings
    assert recordings["fps"].tolist() == [20, 10]


def test_a_table_that_cannot_be_used_stops_the_opening(tmp_path: Path):
    page = with_table(tmp_path, b"recording,context\nurban,suburb\n")
    assert "recordings.csv, line 2: context: expected urban" in texts(page)
    assert str(space_of(page).folder) not in texts(page)
    open_files(page)
    assert "The table of recordings cannot be used: the reason stands at its field" in texts(page)


def test_a_table_of_other_recordings_is_refused_at_its_field(tmp_path: Path):
    page = with_table(tmp_path, b"recording,context\nurban,0\nrurl,1\n")
    shown = texts(page)
    assert "recordings.csv, line 3: there is no recording 'rurl'" in shown.replace("\\", "")
    assert "Read as 2 recordings" not in shown
    open_files(page)
    assert "The table of recordings cannot be used: the reason stands at its field" in texts(page)


def test_a_table_says_which_of_its_pictures_were_not_sent(tmp_path: Path):
    page = with_table(tmp_path, b"recording,pictures\nurban,night/frames\nrural,\n")
    assert "The table names pictures that were not sent: frames." in texts(page)


def test_a_table_sent_names_no_pictures_of_the_machine(tmp_path: Path):
    video = Path(__file__).parents[3] / "sample_data" / "odd_pose.mp4"
    lines = (
        f"recording,width,height,fps,pictures\nurban,640,480,20,{video}\nrural,640,480,20,/etc\n"
    )
    page = with_table(tmp_path, lines.encode())
    press(page, "open_upload")
    assert recordings_of(page)["pictures"].tolist() == ["no pictures"] * 2
    assert space_of(page).pictures.sources == {}


def test_a_session_file_finds_its_table_among_the_files_sent(tmp_path: Path):
    drive(tmp_path)
    text = '[recordings]\npath = "/elsewhere/meta/recordings.csv"\n[truth]\npath = "truth.csv"\n'
    text += "".join(f'[[system]]\npath = "{name}.csv"\n' for name in ("fir", "nir"))
    page = opened()
    send(page, "session_file", ("session.toml", text.encode()))
    names = ("truth.csv", "fir.csv", "nir.csv")
    files = [(name, (tmp_path / name).read_bytes()) for name in names]
    send(page, "session_files", *files)
    press(page, "open_session_file")
    assert "names 'recordings.csv', which was not sent" in texts(page)
    send(page, "session_files", *files, ("recordings.csv", TABLE))
    press(page, "open_session_file")
    assert contexts(page) == ["urban", "0.75"]


def test_a_local_table_is_read_where_it_lies_and_names_nothing_outside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    root = drive(tmp_path / "root")
    write(root / "recordings.csv", *TABLE.decode().splitlines())
    write(root / "bad.csv", "recording,width,height,fps,pictures",
          "urban,640,480,20,../secret.mp4", "rural,640,480,20,")  # fmt: skip
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(root))
    page = opened()
    for key, name in (("truth", "truth"), ("system_0", "fir"), ("system_1", "nir")):
        page.multiselect(key=f"local_{key}").set_value([f"{name}.csv"])
    page.multiselect(key="local_recordings").set_value(["bad.csv"])
    press(checked(page.run()), "open_local")
    assert "which lies outside the folder that the app may read" in texts(page)
    page.multiselect(key="local_recordings").set_value(["recordings.csv"])
    press(checked(page.run()), "open_local")
    assert contexts(page) == ["urban", "0.75"]


def test_the_traffic_context_is_stated_and_taken_back(tmp_path: Path, edit: Edit):
    page = opened_drive(tmp_path, "fir.csv", "nir.csv")
    assert contexts(page) == ["", ""]
    before = space_of(page).opened.dataset.fingerprint
    edit.apply(page, context="rural")
    assert contexts(page) == ["rural", ""]
    assert "1 rural and 1 unstated (as urban)." in texts(page)
    assert space_of(page).opened.dataset.fingerprint != before
    edit.apply(page, context="")
    assert space_of(page).opened.dataset.fingerprint == before


def test_a_value_in_the_sidebar_is_said_to_go_before_the_context(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv", "nir.csv")
    assert "which holds for all recordings" not in texts(page)
    page.session_state["settings"] = {"edge_weight": 0.4}
    assert "which holds for all recordings" in texts(checked(page.run()))
