"""The Data page: systems, recordings and files that join or replace those of what is open."""

from __future__ import annotations

from pathlib import Path

import pytest
from data_page import Edit, answer, opened, opened_drive, press, send, sent, sent_drive, space_of
from inputs import drive, write
from streamlit.testing.v1 import AppTest

from pages import checked, texts
from ui.jobs.page_run import is_uploaded
from ui.views.export.session import portable_session


def changing(page: AppTest, purpose: str, place: str = "upload", **files: Path) -> AppTest:
    """The form for a purpose, with these files in its fields."""
    (choice,) = [each for each in page.segmented_control if each.key == f"form_purpose_{place}"]
    checked(choice.set_value(purpose).run())
    for field, file in files.items():
        send(page, key_of(page, purpose, field), (file.name, file.read_bytes()))
    return checked(page.run())


def key_of(page: AppTest, purpose: str, field: str, place: str = "upload") -> str:
    form = space_of(page).form
    key = f"{place}_change_{space_of(page).n_opened}_{field}"
    return f"{key}_{form}" if form and place == "upload" else key


def rows(page: AppTest) -> dict[str, list[str]]:
    return page.table[-1].value.set_index("Source")["Files"].to_dict()


@pytest.fixture
def page(tmp_path: Path) -> AppTest:
    """Two recordings and two systems, opened from files that were sent."""
    return opened_drive(tmp_path, "fir.csv", "nir.csv")


def more(folder: Path) -> dict[str, Path]:
    """Ground truth and detections of a third recording."""
    head, lines = "recording,frame,x,y,w,h", [f"tunnel,{f},100,100,40,90" for f in range(9)]
    return {
        "truth": write(folder / "more.csv", head, *lines),
        "system_0": write(folder / "fir_more.csv", f"{head},score", *(f"{n},0.9" for n in lines)),
        "system_1": write(folder / "nir_more.csv", f"{head},score", *(f"{n},0.4" for n in lines)),
    }


def test_a_system_joins_those_that_are_open_and_nothing_else_changes(page, tmp_path: Path):
    before = space_of(page).opened
    changing(
        page, "add", system_2=write(tmp_path / "lidar.csv", (tmp_path / "fir.csv").read_text())
    )
    assert "Now: truth.csv" in texts(page)
    assert "The file has the same boxes as fir." in texts(page)
    press(page, "open_upload")
    after = space_of(page).opened
    assert after.dataset.systems == ("fir", "nir", "lidar")
    assert after.dataset.compared() == ("fir", "nir")
    assert after.label == before.label
    assert after.whole.frames.equals(before.whole.frames)
    assert after.whole.system("nir").x.tolist() == before.whole.system("nir").x.tolist()
    # the form is empty again, and the next system has a field
    assert key_of(page, "add", "system_3") in [field.key for field in page.file_uploader]
    assert not any(field.value for field in page.file_uploader if "change" in (field.key or ""))


def test_a_file_takes_the_place_of_another_and_name_and_threshold_stay(page, tmp_path: Path):
    page.session_state["new_params"] = {"threshold_y": 0.65}
    checked(page.run())
    boxes = (tmp_path / "nir.csv").read_text().splitlines()
    changing(page, "replace", system_1=write(tmp_path / "release_2.csv", boxes[0], *boxes[2:]))
    press(page, "open_upload")
    said = texts(page).replace("\\", "")
    assert "Replaced: nir (by release_2.csv). Names stay: see “Change the names of the" in said
    now = space_of(page).opened
    assert rows(page)["Y: nir"].replace("\\", "") == "release_2.csv"
    assert len(now.dataset.system("nir")) == len(boxes) - 2
    assert now.session.systems[1].threshold == 0.65


def test_recordings_join_with_truth_and_the_detections_of_every_system(page, tmp_path: Path):
    files = more(tmp_path)
    changing(page, "add", truth=files["truth"], system_0=files["system_0"])
    answer(page, width=320, height=240, fps=10)
    press(page, "open_upload")
    assert "Choose the detections of nir as well" in texts(page)
    send(page, key_of(page, "add", "system_1"), ("nir_more.csv", files["system_1"].read_bytes()))
    checked(page.run())
    press(page, "open_upload")
    whole = space_of(page).opened.whole
    facts = whole.recordings.set_index("name")[["width", "height", "fps"]].T.to_dict("list")
    assert facts == {"rural": [640, 480, 20], "tunnel": [320, 240, 10], "urban": [640, 480, 20]}
    names = whole.recordings["name"].tolist()
    of_tunnel = whole.frame_columns.recording == names.index("tunnel")
    assert of_tunnel.sum() == 9
    assert of_tunnel[whole.system("nir").frame_index].sum() == 9


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({"truth": "truth.csv"}, "are open already"),
        ({"system_0": "fir.csv"}, "fir has detections in"),
        ({}, "Choose the files to add"),
    ],
    ids=["recordings", "detections", "nothing"],
)
def test_what_is_open_already_is_not_counted_twice(page, tmp_path: Path, files, words: str):
    changing(page, "add", **{field: tmp_path / name for field, name in files.items()})
    before = space_of(page).n_opened
    press(page, "open_upload")
    assert words in texts(page)
    assert space_of(page).n_opened == before


def test_a_table_says_more_of_open_recordings_by_either_of_their_names(page, edit: Edit):
    edit.apply(page, name="City")
    table = b"recording,tags,title,unit\nurban,wet,Town,urban\nrural,day,,\n"
    changing(page, "replace")
    send(page, key_of(page, "replace", "recordings"), ("r.csv", table))
    press(checked(page.run()), "open_upload")
    recordings = space_of(page).opened.whole.recordings
    assert recordings[["name", "tags", "unit"]].to_numpy().tolist() == [
        ["Town", ("wet",), "urban"],
        ["rural", ("day",), ""],
    ]


def test_a_table_of_strangers_is_refused_at_its_field(page):
    changing(page, "add")
    send(page, key_of(page, "add", "recordings"), ("r.csv", b"recording,width\nnowhere,3\n"))
    assert "there is no recording 'nowhere'" in texts(checked(page.run()))


def test_files_of_the_only_recording_keep_it_when_another_joins(tmp_path: Path):
    """Neither is named after the recording, "gt": each was taken as the only file."""
    box = "100,100,40,90"
    truth, boxes = b"frame,x,y,w,h\n", b"frame,x,y,w,h,score\n"
    truth += "".join(f"{frame},{box}\n" for frame in range(9)).encode()
    boxes += "".join(f"{frame},{box},0.{frame + 1}\n" for frame in range(9)).encode()
    page = sent(truth, ("far.csv", boxes), ("near.csv", boxes))
    answer(page, width=640, height=480, fps=20)
    page = press(page, "open_upload")
    changing(page, "add")
    for field, content in (("truth", truth), ("system_0", boxes), ("system_1", boxes)):
        send(page, key_of(page, "add", field), ("night_02.csv", content))
    answer(checked(page.run()), width=640, height=480, fps=20)
    page = press(checked(page.run()), "open_upload")
    whole = space_of(page).opened.whole
    assert len(whole.recordings) == 2
    assert [len(whole.system(name)) for name in whole.systems] == [18, 18]
    assert "Added: night_02." in texts(page).replace("\\", "")


@pytest.fixture
def two_files(tmp_path: Path) -> tuple[AppTest, dict[str, bytes]]:
    """A system with a file for each of two recordings."""
    drive(tmp_path)
    head, *lines = (tmp_path / "fir.csv").read_text().splitlines()
    files = {
        f"{name}.csv": "\n".join(
            [head, *(line for line in lines if line.startswith(name))]
        ).encode()
        for name in ("urban", "rural")
    }
    page = opened()
    send(page, "upload_truth", ("truth.csv", (tmp_path / "truth.csv").read_bytes()))
    send(page, "upload_system_0", *files.items())
    answer(checked(page.run()), width=640, height=480, fps=20)
    page.text_input(key="upload_name_0").set_value("far")
    return press(page, "open_upload"), files


def replace_with(page: AppTest, name: str, content: bytes) -> AppTest:
    changing(page, "replace")
    send(page, key_of(page, "replace", "system_0"), (name, content))
    return press(checked(page.run()), "open_upload")


def test_of_several_files_that_of_the_same_name_is_replaced(two_files):
    page, files = two_files
    page = replace_with(page, "urban.csv", b"\n".join(files["urban.csv"].split(b"\n")[:-5]))
    assert len(space_of(page).opened.whole.system("far")) == 35
    assert "Replaced: far (by urban.csv)." in texts(page)


def test_a_file_that_leaves_a_recording_without_boxes_is_asked_about(two_files):
    page, files = two_files
    page = replace_with(page, "release_2.csv", files["urban.csv"])
    assert "No box would be left: far in rural" in texts(page)
    assert len(space_of(page).opened.whole.system("far")) == 40
    page = press(page, "open_upload")
    assert len(space_of(page).opened.whole.system("far")) == 20


def test_alert_logs_and_speeds_have_fields(tmp_path: Path):
    page = sent_drive(tmp_path, "fir.csv")
    alerts = b"start_s,end_s,kind,recording\n0.1,0.4,pedestrian,urban\n"
    send(page, "upload_system_0_alerts", ("log.csv", alerts))
    send(page, "upload_speed", ("urban.csv", b"time_s,speed_kmh\n0,30\n1,31\n"))
    answer(page, width=640, height=480, fps=20)
    checked(page.run())
    press(page, "open_upload")
    assert page.error == []
    session = space_of(page).opened.session
    assert session.systems[0].alerts.endswith("log.csv")
    speed = {entry.name: entry.speed for entry in session.recordings}
    assert speed["urban"].endswith("urban.csv")
    assert "speed" in space_of(page).opened.dataset.inputs["subject"].tolist()


def test_a_system_below_the_local_root_joins_the_sample(tmp_path: Path, monkeypatch):
    drive(tmp_path)
    sample = opened()
    boxes = space_of(sample).opened.whole
    recording = boxes.recordings["name"][0]
    write(tmp_path / "lidar.csv", "recording,frame,x,y,w,h,score", f"{recording},3,9,9,40,90,0.5")
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    page = changing(opened(), "add", place="local")
    n_open = len(boxes.systems)
    field = page.multiselect(key=key_of(page, "add", f"system_{n_open}", "local"))
    field.set_value(["lidar.csv"])
    press(checked(page.run()), "open_local")
    assert space_of(page).opened.whole.systems == (*boxes.systems, "lidar")
    assert str(tmp_path) not in texts(page)


def test_a_written_session_names_added_files_by_their_names_alone(tmp_path: Path):
    """The sample lies in a folder of the program, what was sent in one of the visitor."""
    page = opened()
    whole = space_of(page).opened.whole
    line = f"{whole.recordings['name'][0]},3,9,9,40,90,0.5"
    new = write(tmp_path / "lidar.csv", "recording,frame,x,y,w,h,score", line)
    changing(page, "add", **{f"system_{len(whole.systems)}": new})
    press(page, "open_upload")
    space = space_of(page)
    session = portable_session(
        space.opened.session, is_upload=is_uploaded(space, space.opened.session)
    )
    assert session.systems[-1].path == ("lidar.csv",)


def test_another_file_is_read_as_the_one_before_and_added_ones_as_those_that_are_there(
    tmp_path: Path,
):
    page = sent_drive(tmp_path, "fir.csv")
    (base,) = [box for box in page.selectbox if box.key == "frame_base_upload_system_0"]
    base.set_value("the first frame is 0")
    answer(page, width=640, height=480, fps=20)
    page = press(checked(page.run()), "open_upload")
    changing(page, "add")
    in_form = [box.key or "" for box in page.selectbox]
    assert not any("upload_change" in key and key.endswith("system_0") for key in in_form)
    boxes = (tmp_path / "fir.csv").read_text().splitlines()
    changing(page, "replace", system_0=write(tmp_path / "release_2.csv", *boxes[:-1]))
    press(page, "open_upload")
    assert space_of(page).opened.session.systems[0].frame_base == 0
