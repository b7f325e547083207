"""Exports as tools write them: divided sets, several tasks, names and files of their own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from field_scene import FPS, N_FRAMES, RIGHT, SIZE, coco_truth, detections, found, truth, write_yolo

import nvcore as nv
from nvcore.common.findings import Remedy, Step
from nvcore.inputs.load import load, read_source
from nvcore.inputs.session import Session, Source, SystemSource

SIDES = ("truth", "x", "y")


def loaded(folder: Path, names: dict[str, str], **way: str) -> nv.Dataset:
    systems = tuple(SystemSource(names[side], name=side) for side in "xy")
    truth_source = Source(names["truth"], **way)
    return load(Session(folder=folder, truth=truth_source, systems=systems, size=SIZE, fps=FPS))


def subset(frame: int) -> str:
    return "train" if frame % 4 else "val"


def as_yolo(folder: Path, form: str) -> dict[str, str]:
    """Folders of truth, x and y, each divided in two."""
    for side in SIDES:
        for part in ("train", "val"):
            (folder / side / form.format(part)).mkdir(parents=True)
        write_yolo(folder / side, side, lambda i: f"{form.format(subset(i))}/frame_{i:06d}.txt")
    return {side: side for side in SIDES}


def write_coco(folder: Path, name: str, document: dict[str, object], frames: set[int]) -> str:
    """The part of a truth with these frames, ids of images counted from 1."""
    ids = {frame: number for number, frame in enumerate(sorted(frames), 1)}
    (folder / "annotations").mkdir(exist_ok=True)
    parts = {
        "images": [{**i, "id": ids[i["id"]]} for i in document["images"] if i["id"] in ids],
        "annotations": [
            {**a, "image_id": ids[a["image_id"]]}
            for a in document["annotations"]
            if a["image_id"] in ids
        ],
    }
    (folder / "annotations" / name).write_text(json.dumps({**document, **parts}))
    return "annotations"


def write_csv(folder: Path) -> dict[str, str]:
    for side in "xy":
        table = detections(side)
        table[table["name"] == "person"].drop(columns="name").to_csv(
            folder / f"{side}.csv", index=False
        )
    return {side: f"{side}.csv" for side in "xy"}


DOCUMENT = coco_truth(lambda i: f"frame_{i:06d}.PNG", first_id=0)


@pytest.mark.parametrize("form", ["labels/{}", "obj_{}_data", "{}/labels"])
def test_folders_of_a_divided_set_are_one_recording(tmp_path: Path, form: str) -> None:
    dataset = loaded(tmp_path, as_yolo(tmp_path, form))
    assert found(nv.compare(dataset)) == RIGHT
    assert dataset.recordings["name"].tolist() == ["recording"]
    assert "no frame number is in two of them" in dataset.inputs["conversion"].iloc[0]


def test_each_subset_is_a_recording_where_that_is_said(tmp_path: Path) -> None:
    dataset = loaded(tmp_path, as_yolo(tmp_path, "labels/{}"), frame_names="scenes")
    assert dataset.recordings["name"].tolist() == ["train", "val"]


def test_subsets_that_share_frame_numbers_are_different_recordings(tmp_path: Path) -> None:
    for side in SIDES:
        for part in ("train", "val"):
            write_yolo(tmp_path / side / part, side, lambda i: f"{i:06d}.txt")
    dataset = loaded(tmp_path, {side: side for side in SIDES})
    assert dataset.recordings["name"].tolist() == ["train", "val"]


def test_lists_of_a_divided_set_are_one_recording(tmp_path: Path) -> None:
    for part in ("train", "val"):
        frames = {i for i in range(N_FRAMES) if subset(i) == part}
        name = write_coco(tmp_path, f"instances_{part}.json", DOCUMENT, frames)
    dataset = loaded(tmp_path, {"truth": name, **write_csv(tmp_path)})
    assert found(nv.compare(dataset)) == RIGHT
    assert len(dataset.truth) == (truth()["name"] == "person").sum()


def test_the_same_pictures_for_other_tasks_are_passed_over(tmp_path: Path) -> None:
    every = set(range(N_FRAMES))
    no_boxes = {**DOCUMENT, "annotations": []}
    write_coco(tmp_path, "image_info_default.json", no_boxes, every)
    write_coco(tmp_path, "person_keypoints_default.json", DOCUMENT, every)
    name = write_coco(tmp_path, "instances_default.json", DOCUMENT, every)
    dataset = loaded(tmp_path, {"truth": name, **write_csv(tmp_path)})
    assert found(nv.compare(dataset)) == RIGHT
    assert "other tasks passed over" in dataset.inputs["conversion"].iloc[0]


def test_persons_in_kitti_text_of_other_tools_count(tmp_path: Path) -> None:
    """Datumaro and CVAT write their own names, and their colours into a text beside the folders."""
    row = "{} 0.0 0 -1 60 180 110 310 -1 -1 -1 -1 -1 -1 -1"
    (tmp_path / "label_colors.txt").write_text("0 0 0 person\n")
    (tmp_path / "000000.txt").write_text(f"{row.format('person')}\n{row.format('car')}\n")
    counted = read_source(Source("."), role="truth", folder=tmp_path)
    assert counted.boxes["ignore"].tolist() == [False]
    named = Source(".", classes=("Pedestrian",))
    findings = read_source(named, role="truth", folder=tmp_path).findings
    assert Step(Remedy.CLASSES, "person") in [step for found in findings for step in found.steps]


def test_a_column_frame_name_names_the_picture(tmp_path: Path) -> None:
    header = "x_min,y_min,x_max,y_max,class_id,confidence,tracker_id,frame_name"
    (tmp_path / "sink.csv").write_text(f"{header}\n60,180,110,310,0,0.9,,frame_000012.PNG\n")
    boxes = read_source(Source("sink.csv"), role="detections", folder=tmp_path).boxes
    assert boxes[["frame", *"xywh"]].to_numpy().tolist() == [[12, 60, 180, 50, 130]]
