from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from nvcore.common.errors import InputError
from nvcore.dataset.schema import NO_LABEL
from nvcore.inputs.readers import csv, mot, parquet
from nvcore.inputs.readers.base import (
    Reading,
    ReadOptions,
    SourceFile,
    reading_boxes,
    recordings_table,
)
from nvcore.inputs.readers.coco.results import read as read_coco_results
from nvcore.inputs.readers.coco.truth import read as read_coco
from nvcore.inputs.writers import write
from nvcore.settings.objects import SPEED_SIGN

PLACE = ["recording", "frame", "x", "y", "w", "h"]


def reading_of(names: list[str], sizes: dict[str, float], header: str, *boxes: tuple) -> Reading:
    """Boxes of these columns; the first recording has sizes."""
    columns = dict(zip(header.split(), map(list, zip(*boxes, strict=True)), strict=True))
    recordings = recordings_table(names)
    recordings.loc[0, list(sizes)] = list(sizes.values())
    return Reading(reading_boxes(len(boxes), **columns), recordings, "")


def truth(**columns: object) -> Reading:
    reading = reading_of(
        ["urban", "=rural"],
        {"width": 640, "height": 512, "fps": 20},
        "recording frame x y w h track ignore distance_m occlusion",
        ("urban", 9, 282.0, 205.0, 20.0, 43.0, 1, False, 31.5, 0),
        ("urban", 29, 1 / 3, 205.1, 37.0, 42.0, -1, True, np.nan, 2),
        ("=rural", 0, -4.5, 20.0, 5.0, 12.0, 7, False, 8.0, -1),
    )
    return replace(reading, boxes=reading.boxes.assign(**columns))


def detections(**columns: object) -> Reading:
    reading = reading_of(
        ["urban", "=rural"],
        {},
        "recording frame x y w h score track",
        ("urban", 9, 1.25, 3.0, 5.0, 7.0, 0.5, -1),
        ("=rural", 0, 2.0, 4.0, 6.0, 8.0, -3.25, 4),
    )
    return replace(reading, boxes=reading.boxes.assign(**columns))


def one_recording(reading: Reading) -> Reading:
    boxes = reading.boxes.assign(recording="urban")
    return Reading(boxes, reading.recordings.head(1), "")


READERS = {"csv": csv.read, "parquet": parquet.read, "coco": read_coco, "mot": mot.read}


def written(path: Path, reading: Reading, format_name: str, **options: object) -> list[str]:
    """The lines of the file that is written."""
    assert write(reading, format_name, path, **{"role": "truth", **options}) == [path]
    return path.read_text(encoding="utf-8").splitlines()


def assert_same_boxes(back: Reading, reading: Reading) -> None:
    pd.testing.assert_frame_equal(
        back.boxes.drop(columns=["file", "line"]),
        reading.boxes.drop(columns=["file", "line"]),
        check_exact=True,
    )


@pytest.mark.parametrize(
    ("reading", "format_name", "role"),
    [(truth(), "csv", "truth"), (detections(), "csv", "detections"), (truth(), "coco", "truth")],
)
def test_boxes_come_back_exactly(tmp_path, reading, format_name, role):
    path = tmp_path / "boxes"
    written(path, reading, format_name, role=role)
    back = READERS[format_name]([SourceFile(path, "boxes")], ReadOptions(role=role))
    is_named = format_name == "coco"  # its files name the class
    label = np.full(len(reading.boxes), 0 if is_named else NO_LABEL, np.int32)
    named = replace(reading, boxes=reading.boxes.assign(label=label))
    assert_same_boxes(back, named)
    assert back.findings == ()
    if format_name == "coco":
        assert back.labels == ("pedestrian",)
        urban = back.recordings.set_index("name").loc["urban"]
        assert urban[["width", "height", "fps"]].tolist() == [640, 512, 20]


@pytest.mark.parametrize("reading_and_role", [(truth(), "truth"), (detections(), "detections")])
def test_parquet_holds_what_csv_holds_with_types_and_gives_the_same_bytes_again(
    tmp_path, reading_and_role
):
    reading, role = reading_and_role
    path = tmp_path / "boxes.parquet"
    assert write(reading, "parquet", path, role=role) == [path]
    content = path.read_bytes()
    write(reading, "parquet", path, role=role, force=True)
    assert path.read_bytes() == content
    table = pq.read_table(path)
    types = {field.name: str(field.type) for field in table.schema}
    last = {"score": "double"} if role == "detections" else {"ignore": "bool"}
    assert types == {
        "recording": "string",
        "frame": "int64",
        **dict.fromkeys("xywh", "double"),
        "track": "int64",
        "distance_m": "double",
        "occlusion": "int64",
        **last,
    }
    back = parquet.read([SourceFile(path, "boxes.parquet")], ReadOptions(role=role))
    assert_same_boxes(back, reading)


def test_csv_has_the_documented_columns_and_neutralised_names(tmp_path):
    lines = written(tmp_path / "truth.csv", truth(), "csv")
    assert lines[0] == "recording,frame,x,y,w,h,track,ignore,distance_m,occlusion"
    assert lines[3] == "'=rural,0,-4.5,20,5,12,7,0,8,"


def test_frames_without_boxes_come_back_from_coco(tmp_path):
    images = pd.DataFrame({"recording": "urban", "frame": [9, 19, 29], "image_id": [0, 1, 2]})
    reading = one_recording(truth(frame=[9, 29, 29]))
    reading = Reading(reading.boxes, reading.recordings, "", images=images)
    path = tmp_path / "truth.json"
    write(reading, "coco", path, role="truth")
    back = read_coco([SourceFile(path, "truth.json")], ReadOptions())
    pd.testing.assert_frame_equal(
        back.images[["recording", "frame", "image_id"]], images, check_dtype=False
    )


def test_coco_annotation_ids_start_at_one(tmp_path):
    # Pycocotools takes id 0 for "no match"
    document = json.loads("".join(written(tmp_path / "truth.json", truth(), "coco")))
    assert [row["id"] for row in document["annotations"]] == [1, 2, 3]


def test_coco_results_name_the_truths_images(tmp_path):
    images = pd.DataFrame({"recording": ["=rural", "urban"], "frame": [0, 9], "image_id": [0, 12]})
    path = tmp_path / "x.json"
    write(detections(), "coco", path, role="detections", truth=replace(truth(), images=images))
    rows = json.loads(path.read_text(encoding="utf-8"))
    assert rows[0] == {"image_id": 12, "category_id": 1, "bbox": [1.25, 3, 5, 7], "score": 0.5}
    options = ReadOptions(role="detections", images=images)
    assert_same_boxes(read_coco_results([SourceFile(path, "x.json")], options), detections())


def test_coco_results_without_image_list_name_recording_and_frame(tmp_path):
    path = tmp_path / "x.json"
    write(detections(), "coco", path, role="detections")
    back = read_coco_results([SourceFile(path, "x.json")], ReadOptions(role="detections"))
    assert back.boxes[PLACE].to_numpy().tolist() == detections().boxes[PLACE].to_numpy().tolist()


def test_a_box_outside_the_image_list_cannot_be_named_in_coco(tmp_path):
    images = pd.DataFrame({"recording": ["urban"], "frame": [9], "image_id": [1]})
    with pytest.raises(InputError, match=r"1 boxes are in frames .* first in frame 0 of =rural"):
        write(
            detections(),
            "coco",
            tmp_path / "x.json",
            role="detections",
            truth=replace(truth(), images=images),
        )


def test_coco_cannot_hold_a_box_without_coordinates(tmp_path):
    reading = truth(x=[1.0, np.nan, 2.0])
    with pytest.raises(InputError, match="there are 1, the first in frame 29 of urban"):
        write(reading, "coco", tmp_path / "x.json", role="truth")


def test_no_detections_give_an_empty_coco_list(tmp_path):
    empty = Reading(reading_boxes(0), recordings_table([]), "")
    assert written(tmp_path / "x.json", empty, "coco", role="detections") == ["[]"]


def test_mot_truth_is_one_based_with_ignored_rows_at_confidence_zero(tmp_path):
    reading = one_recording(truth(x=[282.0, 0.5, -4.5]))
    assert written(tmp_path / "gt.txt", reading, "mot") == [
        "9,1,283,206,20,43,1,1,1",
        "29,-1,1.5,206.1,37,42,0,1,0.4",
        "0,7,-3.5,21,5,12,1,1,-1",
    ]


@pytest.mark.parametrize(
    ("scores", "fields"),
    [([0.5, -3.25], ["0.5", "-3.25"]), (np.nan, ["-1", "-1"]), ([-0.5, np.nan], ["-0.5", "nan"])],
    ids=["scores", "none", "one missing"],
)
def test_mot_detections_have_their_score_and_no_id(tmp_path, scores, fields):
    reading = one_recording(detections(score=scores))
    assert written(tmp_path / "det.txt", reading, "mot", role="detections") == [
        f"9,-1,2.25,4,5,7,{fields[0]},-1,-1,-1",
        f"0,4,3,5,6,8,{fields[1]},-1,-1,-1",
    ]


def test_truth_comes_back_from_mot(tmp_path):
    path = tmp_path / "gt.txt"
    reading = one_recording(truth())
    written(path, reading, "mot")
    back = mot.read([SourceFile(path, "urban/gt.txt")], ReadOptions()).boxes
    columns = ["frame", "track", "ignore", "occlusion"]
    pd.testing.assert_frame_equal(back[columns], reading.boxes[columns])
    np.testing.assert_allclose(back[["x", "y", "w", "h"]], reading.boxes[["x", "y", "w", "h"]])


def test_several_recordings_become_mot_files_with_harmless_names(tmp_path):
    reading = truth(recording=["set06/V000", "../V000", "set06_V000"])
    reading = Reading(reading.boxes, recordings_table(reading.boxes["recording"]), "")
    paths = write(reading, "mot", tmp_path / "out", role="truth")
    names = ["set06_V000.txt", "_V000.txt", "set06_V000_2.txt"]
    assert paths == [tmp_path / "out" / name for name in names]
    assert [len(path.read_text(encoding="utf-8").splitlines()) for path in paths] == [1, 1, 1]


@pytest.mark.parametrize(
    ("format_name", "words"), [("voc", "csv, parquet, coco, mot"), ("csv", "cannot be written")]
)
def test_a_format_and_a_path_that_cannot_be_written_are_errors(tmp_path, format_name, words):
    with pytest.raises(InputError, match=words):
        write(truth(), format_name, tmp_path, role="truth")


@pytest.mark.parametrize(
    ("format_name", "read"), [("csv", csv.read), ("parquet", parquet.read), ("coco", read_coco)]
)
def test_attributes_come_back_from_all_that_hold_them(tmp_path: Path, format_name, read):
    path = tmp_path / "truth.csv"
    path.write_text("frame,x,y,w,h,attributes\n1,2,3,4,5,=child\n2,2,3,4,5,\n3,2,3,4,5,dog\n")
    first = csv.read([SourceFile(path, path.name)], ReadOptions())
    target = tmp_path / f"again.{format_name}"
    write(first, format_name, target, role="truth")
    again = read([SourceFile(target, target.name)], ReadOptions())
    assert again.attributes["attributes"].tolist() == ["=child", "dog"]
    assert again.boxes["frame"].to_numpy()[[0, 2]].tolist() == [1, 3]


def signs(role: str) -> Reading:
    """Three speed signs: 50, one without a number, 30."""
    reading = truth() if role == "truth" else detections()
    boxes = pd.concat([reading.boxes, reading.boxes.iloc[:1]])[:3]
    label = np.array([0, NO_LABEL, 1], np.int32)
    return replace(reading, boxes=boxes.assign(label=label, ignore=False), labels=("50", "30"))


def limits(reading: Reading) -> list[str]:
    return [*np.array([*reading.labels, "none"])[reading.boxes["label"]]]


@pytest.mark.parametrize("format_name", ["csv", "parquet", "coco"])
def test_classes_come_back_from_all_that_hold_them(tmp_path: Path, format_name: str):
    target = tmp_path / f"signs.{format_name}"
    write(signs("truth"), format_name, target, role="truth", objects=SPEED_SIGN)
    again = READERS[format_name]([SourceFile(target, target.name)], ReadOptions(objects=SPEED_SIGN))
    assert limits(again) == ["50", "none", "30"]
    assert not again.findings


def test_coco_results_number_classes_as_the_truth_does(tmp_path: Path):
    categories = {"1": "car", "7": "speed limit 30", "9": "speed sign", "8": "speed limit 50"}
    path = tmp_path / "signs.json"
    of_truth = replace(signs("truth"), categories=categories)
    write(signs("detections"), "coco", path, role="detections", truth=of_truth, objects=SPEED_SIGN)
    assert [row["category_id"] for row in json.loads(path.read_text())] == [8, 9, 7]


@pytest.mark.parametrize(
    ("categories", "words"),
    [(None, "it is needed"), ({"1": "speed sign 50"}, "no category for speed sign 30")],
)
def test_coco_results_of_classes_that_cannot_be_numbered_are_refused(tmp_path, categories, words):
    of_truth = None if categories is None else replace(signs("truth"), categories=categories)
    path = tmp_path / "signs.json"
    given = {"role": "detections", "truth": of_truth, "objects": SPEED_SIGN}
    with pytest.raises(InputError, match=words):
        write(signs("detections"), "coco", path, **given)


@pytest.mark.parametrize(("number", "category"), [("30", 7), ("50", None)])
def test_coco_results_of_one_class_have_its_category_of_the_truth_and_no_other(
    tmp_path: Path, number: str, category: int | None
):
    of_truth = replace(signs("truth"), categories={"1": "car", "7": "speed limit 30"})
    detected = signs("detections")
    label = np.zeros(3, np.int32)
    detected = replace(detected, boxes=detected.boxes.assign(label=label), labels=(number,))
    path = tmp_path / "signs.json"
    given = {"role": "detections", "truth": of_truth, "objects": SPEED_SIGN}
    if category is None:
        with pytest.raises(InputError, match="no category for speed sign 50"):
            write(detected, "coco", path, **given)
    else:
        write(detected, "coco", path, **given)
        assert {row["category_id"] for row in json.loads(path.read_text())} == {category}
