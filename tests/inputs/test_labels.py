"""Of which class boxes are: from the files to the dataset, in the words of the objects."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import nvcore as nv
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_LABEL
from nvcore.dataset.tables import dataset_from_tables
from nvcore.inputs.readers.meaning.classes import codes_of, labels_of, merged
from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN, labels_in_order

TRUTH = "recording,frame,x,y,w,h,class\n"


def labels(dataset: Dataset, source: int) -> list[str]:
    codes = dataset.sources[source].label
    return ["" if code == NO_LABEL else dataset.labels[code] for code in codes]


def loaded(folder: Path, truth: list[str], x: list[str], **given: object) -> Dataset:
    """A box a frame, of these classes."""
    for name, kinds in (("truth", truth), ("x", x)):
        rows = [f"drive,{i},10,10,20,20,{kind}\n" for i, kind in enumerate(kinds)]
        (folder / f"{name}.csv").write_text(TRUTH + "".join(rows))
    paths = str(folder / "truth.csv"), str(folder / "x.csv")
    return nv.load(truth=paths[0], x=paths[1], size=(640, 480), fps=10, **given)


def test_limits_have_the_same_label_whatever_a_file_calls_them(tmp_path: Path):
    dataset = loaded(
        tmp_path,
        ["speed limit 100", "Speed limit (30km/h)", "speed limit", "give way", "sign"],
        ["maximum speed 30", "speed limit 100 km/h", "speed limit 070", "speed limit 30"],
        objects="speed sign",
    )
    assert dataset.labels == ("30", "70", "100")
    # the third has no number, the fourth is left out, the last an ignore region
    assert labels(dataset, 0) == ["100", "30", "", ""]
    assert labels(dataset, 1) == ["30", "100", "70", "30"]


def test_names_for_a_pedestrian_are_one_label(tmp_path: Path):
    dataset = loaded(tmp_path, ["person", "pedestrian", "car"], ["pedestrian", "car", "Person"])
    assert dataset.labels == ("pedestrian",)
    assert labels(dataset, 0) == ["pedestrian"] * 2


def test_files_without_classes_have_no_labels():
    table = pd.DataFrame({"frame": [0], "x": [1.0], "y": [1.0], "w": [5.0], "h": [9.0]})
    dataset = nv.load(truth=table, x=table, size=(640, 480), fps=10)
    assert dataset.labels == ()
    assert labels(dataset, 0) == labels(dataset, 1) == [""]


@pytest.mark.parametrize(
    ("name", "label"),
    [("70", "70"), ("70 km/h", "70"), ("speed limit 007", "7"), ("speed limit", ""), ("0", "0")],
)
def test_a_number_is_what_tells_speed_signs_apart(name: str, label: str):
    assert SPEED_SIGN.label_of(name) == label


def test_a_number_of_any_length_is_read(tmp_path: Path):
    assert SPEED_SIGN.label_of("speed limit " + "9" * 10_000) == "9" * 9


def test_of_pedestrians_other_classes_keep_their_names():
    assert labels_of(["Pedestrian", "rider 2 "], PEDESTRIAN) == {
        "Pedestrian": "pedestrian",
        "rider 2 ": "rider 2",
    }


def test_rows_of_other_classes_have_no_label():
    codes = codes_of(["b", "a", "c", "b"], {"a": "1", "b": "2"})
    assert codes.tolist() == [1, 0, NO_LABEL, 1]
    assert codes_of(["b"], {}).tolist() == [NO_LABEL]


def test_labels_of_two_readings_become_one_list_in_the_order_of_their_numbers():
    names, places = merged([("100", "30"), ("50",), ()])
    assert names == ("30", "50", "100")
    assert [place.tolist() for place in places] == [[2, 0, -1], [1, -1], [-1]]
    assert labels_in_order(["b", "9", "10", "a"]) == ("9", "10", "a", "b")


def test_labels_are_part_of_the_fingerprint_of_tables_only_where_there_are_any():
    recordings = pd.DataFrame({"name": ["r"], "width": [9.0], "height": [9.0], "fps": [1.0]})
    boxes = pd.DataFrame(
        {"frame_index": [0], "source": [0], "x": 1.0, "y": 1.0, "w": 1.0, "h": 1.0}
    )

    def fingerprint(**more: object) -> str:
        frames = [np.array([0])]
        return dataset_from_tables(recordings, frames, boxes.assign(**more), []).fingerprint

    assert fingerprint() == fingerprint(label=NO_LABEL) != fingerprint(label=0)


LIMITS = ("speed limit 30", "Speed limit (70km/h)", "give way")
"""Classes of three boxes in one picture."""


def coco(folder: Path) -> str:
    """With results of the same boxes, which name their categories by number alone."""
    image = {"id": 1, "file_name": "drive/000001.png", "width": 640, "height": 480}
    box = {"image_id": 1, "bbox": [10, 10, 20, 20]}
    truth = {
        "images": [image],
        "annotations": [{**box, "id": i, "category_id": i + 4} for i in range(len(LIMITS))],
        "categories": [{"id": i + 4, "name": name} for i, name in enumerate(LIMITS)],
    }
    (folder / "truth.json").write_text(json.dumps(truth))
    results = [{**box, "category_id": kind, "score": 0.5} for kind in (5, 4, 6)]
    (folder / "x.json").write_text(json.dumps(results))
    return "truth.json"


def voc(folder: Path) -> str:
    corners = "<xmin>1</xmin><ymin>1</ymin><xmax>9</xmax><ymax>9</ymax>"
    signs = [f"<object><name>{x}</name><bndbox>{corners}</bndbox></object>" for x in LIMITS]
    (folder / "voc").mkdir()
    (folder / "voc" / "drive_1.xml").write_text(f"<annotation>{''.join(signs)}</annotation>")
    return "voc"


def cvat(folder: Path) -> str:
    place = 'occluded="0" xtl="1" ytl="2" xbr="4" ybr="6"'
    signs = "".join(f'<box label="{name}" {place}/>' for name in LIMITS)
    image = f'<image id="0" name="drive_1.png" width="640" height="480">{signs}</image>'
    (folder / "cvat.xml").write_text(f"<annotations>{image}</annotations>")
    return "cvat.xml"


def yolo(folder: Path) -> str:
    (folder / "drive").mkdir()
    (folder / "drive" / "1.txt").write_text("".join(f"{i} .5 .5 .1 .1\n" for i in range(3)))
    (folder / "drive" / "classes.txt").write_text("\n".join(LIMITS))
    return "drive"


@pytest.mark.parametrize("written", [coco, voc, cvat, yolo])
def test_every_format_that_names_classes_hands_them_on(tmp_path: Path, written):
    truth = tmp_path / written(tmp_path)
    results = tmp_path / "x.json"
    x = results if results.exists() else truth
    given = {"size": (640, 480), "fps": 10, "objects": "speed sign"}
    dataset = nv.load(truth=str(truth), x=str(x), **given)
    assert dataset.labels == ("30", "70")
    assert labels(dataset, 0) == ["30", "70"]
    assert labels(dataset, 1) == (["70", "30"] if x == results else ["30", "70"])
