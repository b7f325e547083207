"""Pascal VOC: one XML file per picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import DATA

from nvcore.errors import FormatError, InputError
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.readers.voc import FORMAT, read, recognise

FOLDER = DATA / "voc"
NAMES = ("drive1/000007.xml", "drive1/000008.xml")


def golden(**options: object) -> Reading:
    files = [SourceFile(FOLDER / name, name) for name in NAMES]
    return read(files, ReadOptions(**options))  # type: ignore[arg-type]


def read_xml(tmp_path: Path, body: str, name: str = "d_1.xml", **options: object) -> Reading:
    path = tmp_path / name
    path.write_text(f"<annotation>\n{body}\n</annotation>", encoding="utf-8")
    return read([SourceFile(path, name)], ReadOptions(**options))  # type: ignore[arg-type]


def object_at(x0: object, y0: object, x1: object, y1: object, more: str = "") -> str:
    corners = f"<xmin>{x0}</xmin><ymin>{y0}</ymin><xmax>{x1}</xmax><ymax>{y1}</ymax>"
    return f"<object><name>person</name>{more}<bndbox>{corners}</bndbox></object>\n"


def test_inclusive_one_based_corners_become_zero_based_width_and_height() -> None:
    boxes = golden().boxes
    assert boxes[["x", "y", "w", "h"]].to_numpy().tolist() == [[100, 50, 20, 40], [0, 0, 20, 30]]
    assert "pixels from 1-based to 0-based" in golden().conversion


def test_box_base_0_takes_the_corners_as_edges() -> None:
    reading = golden(box_base=0)
    assert reading.boxes[["x", "y", "w", "h"]].to_numpy().tolist() == [
        [101, 51, 19, 39],
        [1, 1, 19, 29],
    ]
    assert "pixels 0-based (box base 0)" in reading.conversion


def test_difficult_objects_are_ignore_regions_of_the_truth() -> None:
    assert golden().boxes["ignore"].tolist() == [False, True]
    assert golden(role="detections").boxes["ignore"].tolist() == [False, False]


def test_occluded_is_partial_occlusion_and_truncated_is_not() -> None:
    assert golden().boxes["occlusion"].tolist() == [1, -1]


def test_parts_of_objects_are_no_boxes_and_cars_are_left_out() -> None:
    reading = golden()
    assert len(reading.boxes) == 2
    assert "left out: car (1)" in reading.conversion


def test_every_box_has_its_file_and_line() -> None:
    assert golden().boxes[["file", "line"]].to_numpy().tolist() == [[0, 14], [0, 33]]


def test_files_without_objects_are_evaluated_frames() -> None:
    reading = golden()
    assert reading.images is not None
    assert reading.images.to_numpy().tolist() == [["drive1", 7, 1], ["drive1", 8, 2]]
    assert reading.recordings[["name", "width", "height"]].to_numpy().tolist() == [
        ["drive1", 640, 480]
    ]


def test_the_classes_option_chooses_what_counts() -> None:
    boxes = golden(classes=("car",)).boxes
    assert boxes["ignore"].tolist() == [True, True, False]


def test_an_unknown_class_lists_those_that_there_are() -> None:
    with pytest.raises(InputError, match=r"no class 'zebra'.*person.*car"):
        golden(classes=("zebra",))


def test_a_score_of_a_detection_is_kept(tmp_path: Path) -> None:
    body = object_at(1, 1, 2, 2, "<score>0.5</score>") + object_at(
        1, 1, 2, 2, "<confidence>0.25</confidence>"
    )
    assert read_xml(tmp_path, body, role="detections").boxes["score"].tolist() == [0.5, 0.25]


def test_corners_at_0_make_the_base_suspicious(tmp_path: Path) -> None:
    (finding,) = read_xml(tmp_path, object_at(1, 1, 9, 9) + object_at(0, 3, 9, 9)).findings
    assert (finding.code, finding.count, finding.example) == ("box-base", 1, "line 3")
    assert "--box-base 0" in finding.advice


def test_corners_at_0_are_fine_where_the_base_is_0(tmp_path: Path) -> None:
    assert read_xml(tmp_path, object_at(0, 0, 9, 9), box_base=0).findings == ()


def test_pedestrians_without_a_box_are_reported(tmp_path: Path) -> None:
    body = "<object><name>person</name><polygon/></object><object><name>road</name></object>"
    (finding,) = read_xml(tmp_path, body).findings
    assert (finding.code, finding.count, finding.example) == ("no-box", 1, "line 2: person")


def test_a_size_of_0_is_unknown(tmp_path: Path) -> None:
    body = "<size><width>0</width><height>0</height></size>"
    assert read_xml(tmp_path, body).recordings[["width", "height"]].isna().all(axis=None)


def test_a_picture_of_another_size_is_reported(tmp_path: Path) -> None:
    files = []
    for number, width in ((1, 64), (2, 64), (3, 65)):
        path = tmp_path / f"{number}.xml"
        size = f"<size><width>{width}</width><height>48</height></size>"
        path.write_text(f"<annotation>{size}</annotation>", encoding="utf-8")
        files.append(SourceFile(path, f"d/{number}.xml"))
    (finding,) = read(files, ReadOptions()).findings
    assert (finding.code, finding.file, finding.example) == ("picture-size", "d/3.xml", "65 x 48")


def test_empty_coordinates_are_passed_on(tmp_path: Path) -> None:
    assert np.isnan(read_xml(tmp_path, object_at("", 1, 2, 2)).boxes["x"].iloc[0])


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("\n" + object_at("left", 1, 2, 2), "line 3: .*number as <xmin>.*'left'"),
        (object_at(1, 1, 2, 2).replace("xmin", "x"), "line 2: expected <xmin> in <bndbox>"),
        ("<object><bndbox/></object>", "line 2: expected <object> with a <name>"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(FormatError, match=r"d_1\.xml, " + message):
        read_xml(tmp_path, body)


def test_an_empty_file_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "1.xml"
    path.touch()
    with pytest.raises(FormatError, match=r"1\.xml, line 1: .*no element found"):
        read([SourceFile(path, "1.xml")], ReadOptions())


def test_own_files_are_recognised_and_no_others() -> None:
    assert recognise("1.xml", (FOLDER / NAMES[0]).read_text(encoding="utf-8"), "truth")
    assert recognise("1.xml", '\ufeff<?xml version="1.0"?>\n<!-- a -->\n<annotation x="">', "truth")
    assert not recognise("1.xml", "<annotations><track>", "truth")
    assert not recognise("1.txt", "0 0.5 0.5 0.1 0.1", "truth")
    assert FORMAT.name == "voc"
