"""Pascal VOC: one XML file per picture."""

from __future__ import annotations

from pathlib import Path

import pytest
from reader_files import golden, only_finding, rows, source

from nvcore.common.errors import FormatError, InputError
from nvcore.common.findings import Remedy, Step
from nvcore.inputs.readers.base import Reading, ReadOptions
from nvcore.inputs.readers.voc import read

NAMES = ("drive1/000007.xml", "drive1/000008.xml")


def read_golden(**options: object) -> Reading:
    return read(golden("voc", *NAMES), ReadOptions(**options))  # type: ignore[arg-type]


def read_xml(folder: Path, body: str, **options: object) -> Reading:
    file = source(folder, f"<annotation>\n{body}\n</annotation>", "d_1.xml")
    return read([file], ReadOptions(**options))  # type: ignore[arg-type]


def object_at(x0: object, y0: object, x1: object, y1: object, more: str = "") -> str:
    corners = f"<xmin>{x0}</xmin><ymin>{y0}</ymin><xmax>{x1}</xmax><ymax>{y1}</ymax>"
    return f"<object><name>person</name>{more}<bndbox>{corners}</bndbox></object>\n"


def test_inclusive_one_based_corners_become_zero_based_width_and_height() -> None:
    # the first person is occluded, the second one difficult and truncated; parts of them are no
    # boxes, a car is left out, and frame 8 has no object
    reading = read_golden()
    assert rows(reading.boxes, "file line x y w h ignore occlusion") == [
        [0, 14, 100, 50, 20, 40, False, 1],
        [0, 33, 0, 0, 20, 30, True, -1],
    ]
    assert rows(reading.images, "recording frame image_id") == [["drive1", 7, 1], ["drive1", 8, 2]]
    assert rows(reading.recordings, "name width height") == [["drive1", 640, 480]]
    assert "pixels from 1-based to 0-based" in reading.conversion
    assert "left out: car (1)" in reading.conversion


def test_box_base_0_takes_the_corners_as_edges() -> None:
    reading = read_golden(box_base=0)
    assert rows(reading.boxes, "x y w h") == [[101, 51, 19, 39], [1, 1, 19, 29]]
    assert "pixels 0-based (box base 0)" in reading.conversion


@pytest.mark.parametrize(
    ("options", "box"), [({}, [60, 0, 50, 130]), ({"box_base": 1}, [59, -1, 51, 131])]
)
def test_corners_with_fractions_are_edges_counted_from_0(
    tmp_path: Path, options: dict[str, object], box: list[float]
) -> None:
    reading = read_xml(tmp_path, object_at("60.0", "0.0", "110.0", "130.0"), **options)
    assert rows(reading.boxes, "x y w h") == [box]
    assert ("they have fractions" in reading.conversion) == (not options)
    assert reading.usual == {"box_base": 0}


def test_difficult_detections_are_not_ignored() -> None:
    assert read_golden(role="detections").boxes["ignore"].tolist() == [False, False]


def test_the_classes_option_chooses_what_counts_among_those_that_there_are() -> None:
    assert read_golden(classes=("car",)).boxes["ignore"].tolist() == [True, True, False]
    with pytest.raises(InputError, match=r"no class 'zebra'.*person.*car"):
        read_golden(classes=("zebra",))


def test_a_score_of_a_detection_is_kept(tmp_path: Path) -> None:
    scores = ("<score>0.5</score>", "<confidence>0.25</confidence>")
    body = "".join(object_at(1, 1, 2, 2, score) for score in scores)
    assert read_xml(tmp_path, body, role="detections").boxes["score"].tolist() == [0.5, 0.25]


def test_corners_at_0_make_the_base_suspicious_unless_it_is_0(tmp_path: Path) -> None:
    body = object_at(1, 1, 9, 9) + object_at(0, 3, 9, 9)
    finding = only_finding(read_xml(tmp_path, body), "box-base")
    assert (finding.count, finding.example) == (1, "line 3")
    assert finding.steps == (Step(Remedy.BOX_BASE, "0"),)
    assert read_xml(tmp_path, body, box_base=0).findings == ()


def test_pedestrians_without_a_box_are_reported(tmp_path: Path) -> None:
    body = "<object><name>person</name><polygon/></object><object><name>road</name></object>"
    finding = only_finding(read_xml(tmp_path, body), "no-box")
    assert (finding.count, finding.example) == (1, "line 2: person")


def size(width: int, height: int) -> str:
    return f"<size><width>{width}</width><height>{height}</height></size>"


def test_a_size_of_0_is_unknown(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, size(0, 0))
    assert rows(reading.recordings, "width height") == [[None, None]]


def test_a_picture_of_another_size_is_reported(tmp_path: Path) -> None:
    files = [
        source(tmp_path, f"<annotation>{size(width, 48)}</annotation>", f"d/{number}.xml")
        for number, width in ((1, 64), (2, 64), (3, 65))
    ]
    finding = only_finding(read(files, ReadOptions()), "picture-size")
    assert (finding.file, finding.example) == ("d/3.xml", "65 x 48")


def test_empty_coordinates_are_passed_on(tmp_path: Path) -> None:
    assert rows(read_xml(tmp_path, object_at("", 1, 2, 2)).boxes, "x") == [[None]]


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
