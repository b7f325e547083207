"""CVAT for images: boxes by picture."""

from __future__ import annotations

from pathlib import Path

import pytest
from places import DATA

from nvcore.errors import FormatError
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.readers.cvat.images import FORMAT, read, recognise

GOLDEN = DATA / "cvat_images" / "annotations.xml"


def golden(**options: object) -> Reading:
    return read([SourceFile(GOLDEN, "annotations.xml")], ReadOptions(**options))  # type: ignore[arg-type]


def read_xml(tmp_path: Path, body: str, name: str = "a.xml", **options: object) -> Reading:
    path = tmp_path / name
    path.write_text(f"<annotations>\n{body}\n</annotations>", encoding="utf-8")
    return read([SourceFile(path, name)], ReadOptions(**options))  # type: ignore[arg-type]


def image(name: str, number: int = 0, inner: str = "") -> str:
    return f'<image id="{number}" name="{name}" width="64" height="48">{inner}</image>\n'


BOX = '<box label="person" occluded="0" xtl="1" ytl="2" xbr="4" ybr="6"/>'


def test_boxes_are_converted_to_width_and_height() -> None:
    boxes = golden().boxes
    assert boxes[["x", "y", "w", "h"]].to_numpy().tolist() == [
        [100, 50, 20, 40],
        [10.25, 20, 20, 20],
    ]
    assert boxes["occlusion"].tolist() == [0, 1]
    assert boxes["line"].tolist() == [12, 14]


def test_recording_and_frame_come_from_the_picture_names() -> None:
    reading = golden()
    assert reading.boxes["recording"].unique().tolist() == ["drive1"]
    assert reading.boxes["frame"].unique().tolist() == [5]
    assert reading.recordings[["name", "width", "height"]].to_numpy().tolist() == [
        ["drive1", 640, 480],
        ["drive2", 320, 240],
    ]


def test_pictures_without_boxes_are_evaluated_frames() -> None:
    images = golden().images
    assert images is not None
    assert images.to_numpy().tolist() == [["drive1", 5, 0], ["drive1", 10, 1], ["drive2", 5, 2]]


def test_people_are_an_ignore_region_and_dogs_are_left_out() -> None:
    reading = golden()
    assert reading.boxes["ignore"].tolist() == [False, True]
    assert "left out: dog (1)" in reading.conversion


def test_a_pedestrian_drawn_as_polygon_is_reported() -> None:
    (finding,) = golden().findings
    assert (finding.code, finding.count) == ("no-box", 1)
    assert finding.example == "line 23: polygon of person"


def test_boxes_of_pictures_have_no_track() -> None:
    assert golden().boxes["track"].tolist() == [-1, -1]


def test_bare_frame_names_take_the_file_as_recording(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, image("frame_000012", 12, BOX), "tunnel.xml")
    assert reading.boxes[["recording", "frame"]].to_numpy().tolist() == [["tunnel", 12]]


def test_pictures_without_number_take_their_ids_and_are_reported(tmp_path: Path) -> None:
    body = image("a_1.png", 0) + image("left.png", 1, BOX)
    reading = read_xml(tmp_path, body, "tunnel.xml")
    assert reading.images is not None
    assert reading.images["frame"].tolist() == [0, 1]
    assert reading.images["recording"].tolist() == ["tunnel", "tunnel"]
    assert [(one.code, one.count) for one in reading.findings] == [("picture-without-number", 1)]


def test_two_pictures_of_one_frame_are_an_error(tmp_path: Path) -> None:
    body = image("x/frame_1.png", 0) + image("x/frame_01.jpg", 1)
    with pytest.raises(FormatError, match=r"line 3: .*frame 1 of recording 'x'.*line 2"):
        read_xml(tmp_path, body)


def test_tasks_of_a_project_keep_their_frames_apart(tmp_path: Path) -> None:
    tasks = "".join(f"<task><id>{n}</id><name>night</name></task>" for n in (3, 4))
    body = f"<meta><project><tasks>{tasks}</tasks></project></meta>" + "".join(
        image("frame_000000", 0, BOX).replace("<image", f'<image task_id="{n}"') for n in (3, 4)
    )
    reading = read_xml(tmp_path, body)
    assert reading.boxes["recording"].tolist() == ["night-3", "night-4"]
    assert reading.images is not None
    assert reading.images["image_id"].tolist() == [0, 1]


def test_a_picture_of_another_size_is_reported(tmp_path: Path) -> None:
    body = image("x/1.png", 0) + image("x/2.png", 1).replace("64", "65")
    reading = read_xml(tmp_path, body)
    assert [(one.code, one.example) for one in reading.findings] == [
        ("picture-size", "line 3: 65 x 48")
    ]


def test_tracks_are_an_error_that_names_the_format(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"a\.xml, line 2: .*cvat-video"):
        read_xml(tmp_path, '<track id="0" label="person"></track>')


def test_a_box_without_label_is_an_error_with_its_line(tmp_path: Path) -> None:
    body = image("x/1.png", 0, "\n" + BOX.replace("label", "name"))
    with pytest.raises(FormatError, match=r"a\.xml, line 3: expected a label in <box>"):
        read_xml(tmp_path, body)


def test_no_pictures_give_empty_tables(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, "<meta></meta>")
    assert len(reading.boxes) == 0
    assert reading.images is not None
    assert len(reading.images) == 0


def test_own_files_are_recognised_and_no_others() -> None:
    assert recognise("a.xml", GOLDEN.read_text(encoding="utf-8"), "truth")
    assert recognise("a.xml", "<annotations><mode>annotation</mode>", "truth")
    assert not recognise("a.xml", "<annotations><mode>interpolation</mode>", "truth")
    assert not recognise("a.xml", '<annotations><track id="0">', "truth")
    assert not recognise("a.xml", "<annotation><filename>", "truth")
    assert FORMAT.name == "cvat-images"


def test_a_known_recording_in_the_path_of_the_file_comes_first(tmp_path: Path) -> None:
    reading = read_xml(
        tmp_path, image("upload/frame_7.png", 0, BOX), "tunnel.xml", recordings=("tunnel", "b")
    )
    assert reading.boxes["recording"].tolist() == ["tunnel"]


def test_findings_of_several_files_are_counted_together(tmp_path: Path) -> None:
    files = []
    for name in ("a", "b"):
        path = tmp_path / f"{name}.xml"
        inner = '<ellipse label="person" cx="1" cy="1" rx="1" ry="1"/>'
        body = image(f"{name}/1.png", 0, inner)
        path.write_text(f"<annotations>{body}</annotations>", encoding="utf-8")
        files.append(SourceFile(path, path.name))
    (finding,) = read(files, ReadOptions()).findings
    assert (finding.code, finding.count, finding.file) == ("no-box", 2, "a.xml")


def test_many_labels_that_are_left_out_are_told_in_short(tmp_path: Path) -> None:
    boxes = "".join(BOX.replace("person", f"thing {n}") for n in range(10))
    reading = read_xml(tmp_path, image("x/1.png", 0, BOX + boxes))
    assert "thing 7 (1), 2 more labels (2)" in reading.conversion
