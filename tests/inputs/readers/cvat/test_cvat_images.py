"""CVAT for images: boxes by picture."""

from __future__ import annotations

from pathlib import Path

import pytest
from reader_files import golden, only_finding, rows, source

from nvcore.common.errors import FormatError
from nvcore.inputs.readers.base import Reading, ReadOptions
from nvcore.inputs.readers.cvat.images import read


def read_golden(**options: object) -> Reading:
    return read(golden("cvat_images", "annotations.xml"), ReadOptions(**options))  # type: ignore[arg-type]


def read_xml(folder: Path, body: str, name: str = "a.xml", **options: object) -> Reading:
    file = source(folder, f"<annotations>\n{body}\n</annotations>", name)
    return read([file], ReadOptions(**options))  # type: ignore[arg-type]


def image(name: str, number: int = 0, inner: str = "") -> str:
    return f'<image id="{number}" name="{name}" width="64" height="48">{inner}</image>\n'


BOX = '<box label="person" occluded="0" xtl="1" ytl="2" xbr="4" ybr="6"/>'


def test_pictures_become_frames_and_their_boxes_width_and_height() -> None:
    # people are an ignore region, a dog is left out, a polygon of a person is the box around it
    reading = read_golden()
    assert rows(reading.boxes, "recording frame line track x y w h ignore occlusion") == [
        ["drive1", 5, 12, -1, 100, 50, 20, 40, False, 0],
        ["drive1", 5, 14, -1, 10.25, 20, 20, 20, True, 1],
        ["drive2", 5, 23, -1, 1, 1, 2, 1, False, 0],
    ]
    assert rows(reading.images, "recording frame image_id") == [
        ["drive1", 5, 0],
        ["drive1", 10, 1],
        ["drive2", 5, 2],
    ]
    assert rows(reading.recordings, "name width height") == [
        ["drive1", 640, 480],
        ["drive2", 320, 240],
    ]
    assert "left out: dog (1)" in reading.conversion
    assert "1 polygons, ellipses or masks replaced by the box around them" in reading.conversion
    assert reading.findings == ()


@pytest.mark.parametrize(
    ("shape", "box"),
    [
        ('polygon points="320,190;360.5,200;330,300"', [320, 190, 40.5, 110]),
        ('ellipse cx="30" cy="20" rx="10" ry="5"', [20, 15, 20, 10]),
        ('ellipse cx="30" cy="20" rx="10" ry="5" rotation="90"', [25, 10, 10, 20]),
        ('ellipse cx="30" cy="20" rx="10" ry="10" rotation="30"', [20, 10, 20, 20]),
        ('mask rle="3, 4" left="7" top="8" width="4" height="9"', [7, 8, 4, 9]),
    ],
)
def test_a_shape_is_read_as_the_box_around_it(tmp_path: Path, shape: str, box: list[float]) -> None:
    inner = '<attribute name="age">child</attribute><attribute name="ignore">true</attribute>'
    tag = shape.partition(" ")[0]
    body = f'<{shape} label="person" occluded="1">{inner}</{tag}>'
    reading = read_xml(tmp_path, image("a/1.png", 0, body))
    assert reading.boxes[[*"xywh"]].iloc[0].tolist() == pytest.approx(box)
    assert rows(reading.boxes, "ignore occlusion") == [[True, 1]]
    assert reading.attributes is not None
    assert reading.attributes["attributes"].tolist() == ["child"]


@pytest.mark.parametrize("rotation", ["inf", "nan", "1e308"])
def test_an_ellipse_of_any_rotation_is_read(tmp_path: Path, rotation: str) -> None:
    body = f'<ellipse label="person" cx="1" cy="2" rx="3" ry="4" rotation="{rotation}"/>'
    assert len(read_xml(tmp_path, image("a/1.png", 0, body)).boxes) == 1


ON_BOX = '<polygon label="person" points="61,101;99,101;98,198"/>'
BESIDE = '<polygon label="person" points="70,101;109,101;98,198"/>'  # IoU below 0.7


@pytest.mark.parametrize(
    ("shapes", "kept"),
    [
        ([ON_BOX], [60]),
        ([ON_BOX.replace("person", "people")], [60, 61]),
        ([ON_BOX, ON_BOX, BESIDE], [60, 70]),
        ([ON_BOX, BESIDE], [60, 61, 70]),  # one passes before another
    ],
)
def test_outlines_of_objects_that_have_a_box_are_left_out(
    tmp_path: Path, shapes: list[str], kept: list[int]
) -> None:
    """Some draw each pedestrian twice, for detection and for segmentation."""
    box = '<box label="person" xtl="60" ytl="100" xbr="100" ybr="200"/>'
    reading = read_xml(tmp_path, image("a/1.png", 0, "".join([box, *shapes])))
    assert reading.boxes["x"].tolist() == kept
    n_doubles = 1 + len(shapes) - len(kept)
    text = f"{n_doubles} polygons, ellipses or masks on a box of the same label left out"
    assert (text in reading.conversion) == bool(n_doubles)


@pytest.mark.parametrize("points", ["", 'points="1,1;2"', 'points="1,x"'])
def test_a_polygon_without_pairs_of_numbers_is_an_error(tmp_path: Path, points: str) -> None:
    body = image("a/1.png", 0, f'<polygon label="person" {points}/>')
    with pytest.raises(FormatError, match=r"line 2: expected .*points"):
        read_xml(tmp_path, body)


def test_pictures_without_id_are_numbered_in_their_order(tmp_path: Path) -> None:
    """So globox writes CVAT."""
    body = "".join(image(f"a/{n}.png", n, BOX).replace(f'id="{n}" ', "") for n in (4, 9))
    reading = read_xml(tmp_path, body)
    assert rows(reading.images, "recording frame image_id") == [["a", 4, 0], ["a", 9, 1]]
    assert reading.boxes["frame"].tolist() == [4, 9]


def test_bare_frame_names_take_the_file_or_a_known_recording_in_its_path(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, image("frame_000012", 12, BOX), "tunnel.xml")
    assert rows(reading.boxes, "recording frame") == [["tunnel", 12]]
    body = image("upload/frame_7.png", 0, BOX)
    reading = read_xml(tmp_path, body, "tunnel.xml", recordings=("tunnel", "b"))
    assert reading.boxes["recording"].tolist() == ["tunnel"]


def test_pictures_without_number_take_their_ids_and_are_reported(tmp_path: Path) -> None:
    body = image("a_1.png", 0) + image("left.png", 1, BOX)
    reading = read_xml(tmp_path, body, "tunnel.xml")
    assert rows(reading.images, "recording frame") == [["tunnel", 0], ["tunnel", 1]]
    assert only_finding(reading, "picture-without-number").count == 1


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            image("x/frame_1.png", 0) + image("x/frame_01.jpg", 1),
            r"line 3: .*frame 1 of recording 'x'.*line 2",
        ),
        ('<track id="0" label="person"></track>', "line 2: .*cvat-video"),
        (
            image("x/1.png", 0, "\n" + BOX.replace("label", "name")),
            "line 3: expected a label in <box>",
        ),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(FormatError, match=r"a\.xml, " + message):
        read_xml(tmp_path, body)


def test_tasks_of_a_project_keep_their_frames_apart(tmp_path: Path) -> None:
    tasks = "".join(f"<task><id>{n}</id><name>night</name></task>" for n in (3, 4))
    body = f"<meta><project><tasks>{tasks}</tasks></project></meta>" + "".join(
        image("frame_000000", 0, BOX).replace("<image", f'<image task_id="{n}"') for n in (3, 4)
    )
    reading = read_xml(tmp_path, body)
    assert reading.boxes["recording"].tolist() == ["night-3", "night-4"]
    assert rows(reading.images, "image_id") == [[0], [1]]


def test_a_picture_of_another_size_is_reported(tmp_path: Path) -> None:
    body = image("x/1.png", 0) + image("x/2.png", 1).replace("64", "65")
    finding = only_finding(read_xml(tmp_path, body), "picture-size")
    assert finding.example == "line 3: 65 x 48"


def test_no_pictures_give_empty_tables(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, "<meta></meta>")
    assert rows(reading.boxes, "frame") == rows(reading.images, "frame") == []


def test_findings_of_several_files_are_counted_together(tmp_path: Path) -> None:
    inner = '<polyline label="person" points="1,1;2,2"/>'
    files = [
        source(tmp_path, f"<annotations>{image(f'{n}/1.png', 0, inner)}</annotations>", f"{n}.xml")
        for n in ("a", "b")
    ]
    finding = only_finding(read(files, ReadOptions()), "no-box")
    assert (finding.count, finding.file) == (2, "a.xml")


def test_many_labels_that_are_left_out_are_told_in_short(tmp_path: Path) -> None:
    boxes = "".join(BOX.replace("person", f"thing {n}") for n in range(10))
    reading = read_xml(tmp_path, image("x/1.png", 0, BOX + boxes))
    assert "thing 7 (1), 2 more (2)" in reading.conversion


def person(line_end: str = "\n", **attributes: str) -> str:
    inner = "".join(
        f'<attribute name="{name}">{value}</attribute>' for name, value in attributes.items()
    )
    return f'<box label="person" xtl="1" ytl="2" xbr="4" ybr="6">{inner}</box>{line_end}'


def test_attributes_of_the_truth_name_classes_and_those_of_the_box_do_not(tmp_path: Path) -> None:
    boxes = person(age="child", with_dog="true", occluded="true") + person(score="0.5") + person()
    reading = read_xml(tmp_path, image("a_1.png", 0, boxes))
    assert reading.attributes is not None
    assert rows(reading.attributes, "file line attributes") == [[0, 2, "child;with_dog"]]
    assert "other attributes as classes of encounters" in reading.conversion
    assert read_xml(tmp_path, image("a_1.png", 0, boxes), role="detections").attributes is None


def test_boxes_of_one_line_lose_attributes_that_differ_and_are_reported(tmp_path: Path) -> None:
    boxes = person("", age="child") + person("", age="adult") + "\n" + person("", age="adult") * 2
    reading = read_xml(tmp_path, image("a_1.png", 0, boxes))
    assert reading.attributes is not None
    assert rows(reading.attributes, "line attributes") == [[3, "adult"]]
    assert only_finding(reading, "shared-line").count == 2
