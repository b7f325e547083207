"""From a session to a dataset: recordings, their facts, and the frames that are evaluated."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from inputs import DETECTIONS, TRUTH, boxes_of, drive, mot_layout, one_box, session_of, write
from places import DATA
from reader_files import rows

import nvcore as nv
from nvcore.common.errors import InputError, MissingFactError, SessionError
from nvcore.common.findings import Remedy, Step
from nvcore.dataset import Dataset
from nvcore.inputs.load import load, read_source
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource
from nvcore.metrics.encounter_classes import classes_of
from nvcore.metrics.encounters import encounters_of
from nvcore.settings.params import Params
from nvcore.tables.result import encounters_table


def mot_session(folder: Path, truth: str, system: str) -> Session:
    return Session(folder, Source((truth,)), (SystemSource((system,)),))


def names(dataset: Dataset) -> list[str]:
    return dataset.recordings["name"].tolist()


# one recording or several


def test_single_files_of_different_names_are_the_same_recording(tmp_path: Path):
    write(tmp_path / "night" / "annotated.csv", TRUTH, "0,1,1,5,10,1")
    write(tmp_path / "out" / "thermal.csv", DETECTIONS, "0,1,1,5,10,0.5")
    dataset = load(session_of(tmp_path, "night/annotated.csv", "out/thermal.csv"))
    assert names(dataset) == ["annotated"]
    assert (len(dataset.system("thermal")), len(dataset.left_out)) == (1, 0)


def test_the_assumption_that_single_recordings_are_the_same_is_reported(tmp_path: Path):
    write(tmp_path / "truth.csv", "recording," + TRUTH, "urban,0,1,1,5,10,1")
    write(tmp_path / "fir.csv", "recording," + DETECTIONS, "city,0,1,1,5,10,0.5")
    conversion = load(session_of(tmp_path, "truth.csv", "fir.csv")).inputs["conversion"]
    assert "recording 'city' taken for the truth's only recording 'urban'" in conversion[1]


def test_mot_layout_gives_one_recording_per_folder_and_globs_the_same(tmp_path: Path):
    mot_layout(tmp_path)
    by_folder = load(mot_session(tmp_path, ".", "."))
    assert names(by_folder) == ["A", "B"]
    assert len(by_folder.left_out) == 0
    by_glob = load(mot_session(tmp_path, "*/gt/gt.txt", "*/det/det.txt"))
    assert by_glob.boxes.equals(by_folder.boxes)
    assert by_glob.frames.equals(by_folder.frames)


def test_one_file_per_picture_below_folders_gives_recordings_by_folder(tmp_path: Path):
    for name in ("set06/V000/I00019", "set06/V000/I00039", "set09/V000/I00019"):
        write(tmp_path / "gt" / f"{name}.txt", "person 10 20 20 50 0 0 0 0 0")
    write(tmp_path / "fir.csv", "recording," + DETECTIONS, "set06/V000,19,10,20,20,50,0.5")
    dataset = load(session_of(tmp_path, "gt", "fir.csv"))
    assert names(dataset) == ["set06/V000", "set09/V000"]
    assert dataset.frames["frame"].tolist() == [19, 39, 19]


@pytest.mark.parametrize(
    ("paths", "systems"),
    [
        (("fir.csv", "fir.csv"), ("fir", "fir (2)")),
        (("faster/out.csv", "tracker/out.csv"), ("faster", "tracker")),
    ],
)
def test_systems_in_files_of_one_name_are_told_apart(
    tmp_path: Path, paths: tuple[str, ...], systems: tuple[str, ...]
):
    one_box(tmp_path)
    for path in paths:
        write(tmp_path / path, DETECTIONS, "0,1,1,5,10,0.5")
    assert load(session_of(tmp_path, "truth.csv", *paths)).systems == systems


def test_a_name_that_nobody_can_have_meant_is_refused(tmp_path: Path):
    session = session_of(drive(tmp_path))
    text = (tmp_path / "truth.csv").read_text().replace("rural", 1000 * "r")
    (tmp_path / "truth.csv").write_text(text)
    load(session)
    (tmp_path / "truth.csv").write_text(text.replace("rr,", "rrr,"))
    words = "a recording's name has 1,001 signs, expected 1,000 at the most"
    with pytest.raises(InputError, match=words):
        load(session)
    with pytest.raises(InputError, match=words):
        read_source(session.truth, role="truth", folder=tmp_path)


def test_a_truth_without_a_recording_is_an_input_error(tmp_path: Path):
    write(tmp_path / "truth.csv", "recording," + TRUTH)
    write(tmp_path / "fir.csv", DETECTIONS)
    with pytest.raises(InputError, match="the ground truth holds no"):
        load(session_of(tmp_path, "truth.csv", "fir.csv"))


# size and frame rate


@pytest.mark.parametrize(
    ("given", "expected"),
    [({}, (640, 480, 10)), ({"size": (1280, 960), "fps": 25.0}, (1280, 960, 25))],
    ids=["from seqinfo", "given by a flag"],
)
def test_a_given_size_and_frame_rate_go_before_those_of_the_data(
    tmp_path: Path, given: dict, expected: tuple[int, ...]
):
    session = replace(mot_session(mot_layout(tmp_path), ".", "."), **given)
    row = load(session).recordings.iloc[0]
    assert (row["width"], row["height"], row["fps"]) == expected


def test_what_a_session_says_of_a_recording_goes_before_its_defaults(tmp_path: Path):
    facts = RecordingEntry(
        "B", fps=30.0, width=320, height=240, horizon=100.0, tags=("night", "rain")
    )
    session = replace(mot_session(mot_layout(tmp_path), ".", "."), fps=25.0, recordings=(facts,))
    assert rows(load(session).recordings, "fps width height horizon tags") == [
        [25, 640, 480, None, ()],
        [30, 320, 240, 100, ("night", "rain")],
    ]


def test_the_only_recording_of_session_and_truth_is_the_same_and_no_box_is_lost(tmp_path: Path):
    folder = one_box(tmp_path, "0,1,1,5,10,0.5")
    facts = (RecordingEntry("PETS09", fps=12.5, frames="0:9"),)
    dataset = load(session_of(folder, "truth.csv", "fir.csv", fps=None, recordings=facts))
    assert names(dataset) == ["PETS09"]
    assert dataset.recordings["fps"].tolist() == [12.5]
    assert (len(dataset.truth), len(dataset.system("fir")), len(dataset.left_out)) == (10, 1, 0)


def test_a_recording_does_not_get_the_name_of_another_that_a_system_holds(tmp_path: Path):
    write(tmp_path / "truth.csv", "recording," + TRUTH, "day,0,1,1,5,10,1")
    lines = [f"{name},0,1,1,5,10,0.5" for name in ("day", "dusk")]
    write(tmp_path / "fir.csv", "recording," + DETECTIONS, *lines)
    dataset = load(
        session_of(tmp_path, "truth.csv", "fir.csv", recordings=(RecordingEntry("dusk"),))
    )
    assert len(dataset.system("fir")) == 1


@pytest.mark.parametrize(
    ("unknown", "words"),
    [
        (("size",), "image size of .* is not .* session file can state width and height"),
        (("fps",), "frame rate of .* is not .* session file can state fps"),
        (("size", "fps"), "size and frame rate of .* are not .* state width, height and fps"),
    ],
)
def test_an_error_names_all_unknown_facts(tmp_path: Path, unknown, words: str):
    with pytest.raises(MissingFactError, match=words) as caught:
        load(session_of(one_box(tmp_path), "truth.csv", "fir.csv", **dict.fromkeys(unknown)))
    remedies = {"size": Remedy.SIZE, "fps": Remedy.RATE}
    assert caught.value.facts == unknown
    assert [step.remedy for step in caught.value.steps] == [remedies[fact] for fact in unknown]
    assert caught.value.needs_all_steps


def test_an_unknown_fact_of_several_recordings_says_of_how_many(tmp_path: Path):
    with pytest.raises(MissingFactError, match=r"recording 'urban' .* \(nor those of 1 more\)"):
        load(session_of(drive(tmp_path), fps=None))


def test_a_recording_that_the_session_does_not_describe_is_said_to_be_of_the_truth(tmp_path: Path):
    session = session_of(
        drive(tmp_path), fps=None, recordings=(RecordingEntry("other", fps=20.0, frames=None),)
    )
    with pytest.raises(
        MissingFactError, match=r"not in the session's .* compare only some: recordings = "
    ):
        load(session)


def yolo(folder: Path) -> Path:
    for name in ("gt", "out"):
        shutil.copytree(DATA / "yolo", folder / name)
    return folder


def test_the_size_of_a_session_s_recordings_serves_formats_with_relative_boxes(tmp_path: Path):
    facts = RecordingEntry("drive1", width=640, height=480, fps=20.0)
    session = session_of(yolo(tmp_path), "gt", "out", size=None, fps=None, recordings=(facts,))
    assert boxes_of(load(session), 0)[0] == [240, 120, 160, 240]


def test_the_size_of_the_truth_serves_detections_with_relative_boxes(tmp_path: Path):
    yolo(tmp_path)
    shutil.rmtree(tmp_path / "gt")
    shutil.copytree(DATA / "voc", tmp_path / "gt")
    dataset = load(session_of(tmp_path, "gt", "out", size=None))
    assert boxes_of(dataset, 0)[0] == [100, 50, 20, 40]
    assert "out" in dataset.systems


# evaluated frames


def test_seqinfo_lists_frames_without_truth(tmp_path: Path):
    dataset = load(mot_session(mot_layout(tmp_path, ("A",)), ".", "."))
    assert dataset.frames["frame"].tolist() == [1, 2, 3, 4, 5]
    assert "those that the ground truth lists (5 in all)" in dataset.notes[0]


def test_sampled_annotation_is_evaluated_at_its_step(tmp_path: Path):
    write(tmp_path / "truth.csv", TRUTH, *(f"{f},1,1,5,10,1" for f in range(9, 200, 20)))
    write(tmp_path / "fir.csv", DETECTIONS, "9,1,1,5,10,0.5", "10,1,1,5,10,0.5")
    dataset = load(session_of(tmp_path, "truth.csv", "fir.csv"))
    assert dataset.frames["frame"].tolist() == list(range(9, 200, 20))
    assert "every 20th frame from 9 to 189: annotation is sampled at that step" in dataset.notes[0]


def test_given_frames_go_before_those_of_the_data(tmp_path: Path):
    session = replace(mot_session(mot_layout(tmp_path), ".", "."), frames="2:4:2")
    dataset = load(session)
    assert dataset.frames["frame"].tolist() == [2, 4, 2, 4]
    assert "as given for all recordings (4 in all)" in dataset.notes[0]


def test_a_recording_s_own_frames_go_before_those_given_for_all(tmp_path: Path):
    write(tmp_path / "b.txt", "5")
    session = replace(
        mot_session(mot_layout(tmp_path), ".", "."),
        frames="1:2",
        recordings=(RecordingEntry("B", frames="b.txt"),),
    )
    dataset = load(session)
    assert dataset.frames["frame"].tolist() == [1, 2, 5]
    assert dataset.notes == (
        "evaluated frames of A: as given for all recordings (2 in all)",
        "evaluated frames of B: as the session says (1 in all)",
    )


def test_a_recording_without_truth_counts_where_its_frames_are_given(tmp_path: Path):
    session = session_of(drive(tmp_path), recordings=(RecordingEntry("empty", frames="0:4"),))
    dataset = load(session)
    assert names(dataset) == ["urban", "rural", "empty"]
    assert len(dataset.frames) == 45
    dataset = load(replace(session, recordings=(RecordingEntry("empty"),)))
    assert names(dataset) == ["urban", "rural"]
    assert any("empty: no frame is known; recording left out" in note for note in dataset.notes)


def test_no_frame_at_all_asks_for_frames(tmp_path: Path):
    write(tmp_path / "truth.csv", TRUTH)
    write(tmp_path / "fir.csv", DETECTIONS, "0,1,1,5,10,0.5")
    with pytest.raises(MissingFactError, match=r"truth\.csv: no frame is evaluated") as raised:
        load(session_of(tmp_path, "truth.csv", "fir.csv"))
    assert raised.value.steps == (Step(Remedy.CLASSES), Step(Remedy.FRAMES))
    assert not raised.value.needs_all_steps


def test_progress_names_each_step(tmp_path: Path):
    steps: list[str] = []
    load(session_of(drive(tmp_path)), progress=lambda _share, what: steps.append(what))
    assert steps == [
        *(f"reading {what}" for what in ("the ground truth", "fir", "nir")),
        "placing boxes in frames",
    ]


KITTI = "0 0 0 10 20 40 80 1 1 1 0 0 20 0"


@pytest.mark.parametrize(
    ("format_name", "header", "car", "pedestrian"),
    [
        ("mot", (), "{},7,10,20,30,60,1,3,1", "{},1,10,20,30,60,1,1,1"),
        ("kitti-tracking", (), f"{{}} 7 Car {KITTI}", f"{{}} 1 Pedestrian {KITTI}"),
        ("csv", ("frame,x,y,w,h,class",), "{},1,1,9,9,car", "{},1,1,9,9,person"),
    ],
)
def test_frames_with_other_classes_only_are_annotated_frames(
    tmp_path: Path, format_name: str, header: tuple[str, ...], car: str, pedestrian: str
):
    lines = [car.format(frame) for frame in (1, 2, 3, 9)]
    lines += [pedestrian.format(frame) for frame in (5, 6)]
    one_box(tmp_path)
    write(tmp_path / "drive.txt", *header, *lines)
    dataset = load(session_of(tmp_path, "drive.txt", "fir.csv"))
    assert dataset.inputs["format"].iloc[0] == format_name
    assert dataset.frames["frame"].tolist() == list(range(1, 10))


def test_a_given_size_and_rate_that_contradict_the_data_are_reported(tmp_path: Path):
    session = replace(mot_session(mot_layout(tmp_path), ".", "."), size=(11, 12), fps=99.0)
    findings = [
        finding for finding in load(session).findings if finding.code == "contradicted-fact"
    ]
    assert [finding.count for finding in findings] == [2, 2]
    assert any(
        "frame rate given (99) is not that of the data" in finding.message for finding in findings
    )
    findings = load(replace(session, size=(640, 480), fps=10.0)).findings
    assert "contradicted-fact" not in {finding.code for finding in findings}


def test_pictures_that_are_not_there_are_reported(tmp_path: Path):
    one_box(tmp_path)
    entry = RecordingEntry("truth", pictures="frames/night")
    session = replace(session_of(tmp_path, "truth.csv", "fir.csv"), recordings=(entry,))
    (finding,) = [
        finding for finding in load(session).findings if finding.code == "missing-pictures"
    ]
    assert (finding.severity, finding.count, finding.file) == ("warning", 1, "frames/night")
    assert "pictures named that are not there" in finding.message
    (tmp_path / "frames" / "night").mkdir(parents=True)
    assert "missing-pictures" not in {finding.code for finding in load(session).findings}


def test_frame_numbers_are_moved_by_the_offset(tmp_path: Path):
    system = SystemSource(("fir.csv",), offset_frames=-2)
    dataset = load(session_of(one_box(tmp_path, "5,1,1,5,10,0.5"), "truth.csv", system))
    assert dataset.frames["frame"][int(dataset.system("fir").frame_index[0])] == 3
    assert "frame numbers moved by -2" in dataset.inputs["conversion"].iloc[-1]


def test_boxes_of_one_system_are_scaled_first_and_then_moved(tmp_path: Path):
    one_box(tmp_path, "0,1,4,5,10,0.5")
    system = SystemSource(("fir.csv",), name="moved", scale=(2.0, 0.5), offset_px=(10.0, -1.0))
    dataset = load(session_of(tmp_path, "truth.csv", system, "fir.csv"))
    assert boxes_of(dataset, 1) == [[12, 1, 10, 5]]
    assert boxes_of(dataset, 2) == [[1, 4, 5, 10]]
    conversion = dataset.inputs["conversion"][1]
    assert "coordinates scaled by 2, 0.5; boxes moved by 10, -1 px" in conversion


# nothing is lost


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("city,0,1,1,5,10,0.5", "unknown recording"),
        ("urban,99,1,1,5,10,0.5", "frame not listed"),
        ("urban,-1,1,1,5,10,0.5", "frame not listed"),
        ("urban,9007199254740991,1,1,5,10,0.5", "frame not listed"),
        ("urban,0,nan,1,5,10,0.5", "not a number"),
        ("urban,0,1,1,0,10,0.5", "no area"),
        ("urban,0,1,1,5,-10,0.5", "no area"),
    ],
)
def test_a_row_without_a_place_is_left_out_with_its_reason(tmp_path: Path, row: str, reason: str):
    drive(tmp_path)
    write(tmp_path / "fir.csv", "recording," + DETECTIONS, "rural,3,1,1,5,10,0.5", row)
    dataset = load(session_of(tmp_path, "truth.csv", "fir.csv"))
    assert len(dataset.system("fir")) == 1
    lost = dataset.left_out
    assert lost[["subject", "line", "reason"]].to_numpy().tolist() == [["fir", 3, reason]]
    assert dataset.inputs["file"][int(lost["file"][0])].endswith("fir.csv")


def test_a_frame_between_listed_ones_is_not_listed(tmp_path: Path):
    one_box(tmp_path, "0,1,1,5,10,0.5", "1,1,1,5,10,0.5", "2,1,1,5,10,0.5")
    dataset = load(session_of(tmp_path, "truth.csv", "fir.csv", frames="0:8:2"))
    assert dataset.left_out.query("subject == 'fir'")["frame"].tolist() == [1]
    assert len(dataset.truth) == 5


# X and Y


SYSTEMS = (SystemSource(("fir.csv",), threshold=0.1), SystemSource(("nir.csv",), threshold=0.2))


@pytest.mark.parametrize(
    ("chosen", "expected", "thresholds"),
    [
        ({}, ("fir", "nir"), (0.1, 0.2)),
        ({"x": "nir"}, ("nir", "fir"), (0.2, 0.1)),
        ({"y": "fir"}, ("nir", "fir"), (0.2, 0.1)),
        ({"x": "nir", "y": "nir"}, ("nir", "nir"), (0.2, 0.2)),
        ({"params": Params(threshold_y=0.7)}, ("fir", "nir"), (0.1, 0.7)),
    ],
)
def test_each_compared_system_keeps_its_own_threshold(
    tmp_path: Path, chosen: dict, expected: tuple[str, str], thresholds: tuple[float, float]
):
    session = replace(session_of(drive(tmp_path)), systems=SYSTEMS, **chosen)
    dataset = load(session)
    params = dataset.params_of()
    assert dataset.compared() == expected
    assert (params.threshold_x, params.threshold_y) == thresholds


def test_a_single_system_is_compared_with_none(tmp_path: Path):
    session = session_of(drive(tmp_path), "truth.csv", "fir.csv")
    assert load(session).compared() == ("fir", None)


def test_attributes_find_their_encounters_also_past_boxes_without_a_place(tmp_path: Path):
    drive(tmp_path)
    path = tmp_path / "truth.csv"
    head, *lines = path.read_text(encoding="utf-8").splitlines()
    texts = ["child" if line.startswith("urban") else "" for line in lines]
    rows = [f"{line},{text}" for line, text in zip(lines, texts, strict=True)]
    # before all others: a row of no area, which is left out
    write(path, f"{head},attributes", "urban,0,1,1,0,0,1,dog", *rows)
    dataset = load(session_of(tmp_path))
    classes = classes_of(dataset)
    places = dataset.recordings["name"].to_numpy()[encounters_of(dataset)[1].recording]
    assert dict(zip(places, classes.attributes, strict=True)) == {"urban": "child", "rural": ""}
    assert classes_of(dataset.only(names=["rural"])).named == ()
    assert classes_of(dataset.only(names=["urban"])).attributes.tolist() == ["child"]


def test_attributes_of_a_table_are_those_of_its_rows(tmp_path: Path):
    drive(tmp_path)
    truth = pd.read_csv(tmp_path / "truth.csv")
    truth["attributes"] = np.where(truth["recording"] == "rural", "pram", "")
    x, y = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("fir", "nir"))
    comparison = nv.compare(truth=truth, x=x, y=y, size=(640, 480), fps=20)
    table = encounters_table(comparison.result)
    assert dict(zip(table["recording"], table["attributes"], strict=True)) == {
        "urban": "",
        "rural": "pram",
    }


def test_a_recording_s_own_speed_is_that_of_the_comparison(tmp_path: Path):
    session = session_of(drive(tmp_path))
    stated = replace(session, recordings=(RecordingEntry("urban", speed_kmh=30.0),))
    recordings = load(stated).recordings.set_index("name")
    assert recordings.loc["urban", "speed_kmh"] == 30
    assert recordings["speed_kmh"].drop("urban").isna().all()
    with pytest.raises(SessionError, match="speed_kmh: expected a positive number, found 0"):
        RecordingEntry("urban", speed_kmh=0.0)
