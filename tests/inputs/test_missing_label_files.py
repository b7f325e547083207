"""Pictures without a label file: nobody is there, unless only some pictures were annotated."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from field_scene import FPS, RIGHT, SIZE, found, write_yolo

import nvcore as nv
from nvcore.common.findings import Finding, Remedy, Severity
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource

GAP = range(15, 25)
"""Frames in which X detects the first pedestrian and, from 20 on, the third; Y all three."""
NOBODY_IN_GAP = {"matched": (45, 72), "false_alarms": (15, 36), "encounters": (3, 5)}
"""Each of the three is there before and after it; X misses the second and, at first, the third."""


def name_of(frame: int) -> str:
    return f"frame_{frame:06d}.txt"


def write_scene(folder: Path, labels: str, without: Iterable[int]) -> None:
    write_yolo(folder / labels, "truth", name_of)
    for frame in without:
        (folder / labels / name_of(frame)).unlink()
    for side in "xy":
        write_yolo(folder / side, side, name_of)


def write_pictures(folder: Path, frames: Iterable[int] = range(40)) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("cover", *(Path(name_of(frame)).stem for frame in frames)):
        (folder / f"{name}.jpg").touch()


def write_list(path: Path, picture: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{picture.format(Path(name_of(i)).stem)}\n" for i in range(40)))


def loaded(
    folder: Path, labels: str, frames: str | None = None, pictures: str | None = None
) -> nv.Dataset:
    session = Session(
        folder=folder,
        truth=Source(labels),
        systems=tuple(SystemSource(side, name=side) for side in "xy"),
        size=SIZE,
        fps=FPS,
        frames=frames,
        recordings=() if pictures is None else (RecordingEntry("drive", pictures=pictures),),
    )
    return load(session)


def compared(*files: Any, **facts: Any) -> tuple[dict[str, Any], nv.Dataset]:
    dataset = loaded(*files, **facts)
    return found(nv.compare(dataset)), dataset


def finding_of(dataset: nv.Dataset, *codes: str) -> Finding:
    (finding,) = [finding for finding in dataset.findings if finding.code in codes]
    return finding


PLACES: dict[str, tuple[str, Callable[[Path], object], str | None]] = {
    "images beside labels": (
        "data/labels/train",
        lambda root: write_pictures(root / "data/images/train"),
        None,
    ),
    "the same folder": ("labels", lambda root: write_pictures(root / "labels"), None),
    "Pascal VOC's folders": (
        "VOC/Annotations",
        lambda root: write_pictures(root / "VOC/JPEGImages"),
        None,
    ),
    "a list beside": (
        "obj_train_data",
        lambda root: write_list(root / "train.txt", "data/obj_train_data/{}.jpg"),
        None,
    ),
    "a list of stems": (
        "VOC/Annotations",
        lambda root: write_list(root / "VOC/ImageSets/Main/val.txt", "{}"),
        None,
    ),
    "data.yaml": (
        "yolo/labels",
        lambda root: (
            write_pictures(root / "photos"),
            (root / "yolo/data.yaml").write_text("train: ../photos\nnames: [person]\n"),
        ),
        None,
    ),
    "the session": ("labels", lambda root: write_pictures(root / "drive"), "drive/*.jpg"),
}


@pytest.mark.parametrize(("labels", "write", "pictures"), PLACES.values(), ids=PLACES)
def test_nobody_is_in_a_listed_picture_without_a_label_file(tmp_path, labels, write, pictures):
    write_scene(tmp_path, labels, GAP)
    write(tmp_path)
    numbers, dataset = compared(tmp_path, labels, pictures=pictures)
    assert numbers == NOBODY_IN_GAP
    assert dataset.frame_columns.frame.tolist() == [*range(40)]
    finding = finding_of(dataset, "pictures-without-label-file")
    assert (finding.severity, finding.count) == (Severity.NOTE, 10)


@pytest.mark.parametrize(
    ("annotated", "steps"),
    [
        (range(0, 40, 4), ["0:39", "0:36:4"]),
        ([i for i in range(40) if i % 5 != 2], ["0:39"]),
        (range(12), ["0:39", "0:11:1"]),
    ],
    ids=["every fourth annotated", "every fifth not", "the first twelve"],
)
def test_pictures_of_which_only_some_may_be_annotated_are_asked_about(tmp_path, annotated, steps):
    write_scene(tmp_path, "labels", {*range(40)} - {*annotated})
    write_pictures(tmp_path / "images")
    dataset = loaded(tmp_path, "labels")
    assert dataset.frame_columns.frame.tolist() == [*annotated]
    finding = finding_of(dataset, "pictures-not-annotated")
    assert finding.severity is Severity.WARNING
    assert [(step.remedy, step.value) for step in finding.steps] == [
        (Remedy.FRAMES, step) for step in steps
    ]
    dataset = loaded(tmp_path, "labels", frames=finding.steps[0].value)
    assert len(dataset.frame_columns) == 40


def test_a_gap_between_label_files_is_warned_of_where_nothing_lists_the_pictures(tmp_path):
    write_scene(tmp_path, "labels", GAP)
    numbers, dataset = compared(tmp_path, "labels")
    assert numbers["false_alarms"] == (0, 4)
    finding = finding_of(dataset, "missing-label-files")
    assert (finding.severity, finding.count) == (Severity.WARNING, 10)
    assert finding.example == "recording recording, frame 15"
    (step,) = finding.steps
    numbers, dataset = compared(tmp_path, "labels", frames=step.value)
    assert numbers == NOBODY_IN_GAP
    assert not dataset.findings


def test_nothing_is_said_of_label_files_without_gaps(tmp_path):
    write_scene(tmp_path, "labels", ())
    write_pictures(tmp_path / "images")
    numbers, dataset = compared(tmp_path, "labels")
    assert (numbers, dataset.findings) == (RIGHT, ())


def test_annotation_of_every_fourth_frame_is_no_gap(tmp_path):
    write_scene(tmp_path, "labels", {*range(40)} - {*range(0, 40, 4)})
    assert not loaded(tmp_path, "labels").findings


def test_a_second_picture_of_a_frame_is_no_frame_of_its_own(tmp_path):
    write_scene(tmp_path, "labels", GAP)
    write_pictures(tmp_path / "images")
    for name in ("frame_16.jpg", "frame_3.jpg"):
        (tmp_path / "images" / name).touch()
    numbers, dataset = compared(tmp_path, "labels")
    assert numbers == NOBODY_IN_GAP
    assert finding_of(dataset, "pictures-without-label-file").count == 10
