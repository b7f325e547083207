"""CVAT for video: tracks, outside, keyframes, frame step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import DATA

from nvcore.errors import FormatError, InputError
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.readers.cvat.video import FORMAT, read, recognise

GOLDEN = DATA / "cvat_video" / "annotations.xml"
META = "<meta><task><size>{size}</size><mode>interpolation</mode></task></meta>"


def golden(**options: object) -> Reading:
    return read([SourceFile(GOLDEN, "annotations.xml")], ReadOptions(**options))  # type: ignore[arg-type]


def read_xml(tmp_path: Path, body: str, name: str = "a.xml", **options: object) -> Reading:
    path = tmp_path / name
    path.write_text(f"<annotations>\n{body}\n</annotations>", encoding="utf-8")
    return read([SourceFile(path, name)], ReadOptions(**options))  # type: ignore[arg-type]


def box(frame: int, x: float = 0, *, more: str = "", inner: str = "") -> str:
    corners = f'xtl="{x}" ytl="0" xbr="{x + 10}" ybr="20"'
    return f'<box frame="{frame}" {corners} {more}>{inner}</box>\n'


def track(*boxes: str, number: int = 0, label: str = "person") -> str:
    return f'<track id="{number}" label="{label}">\n{"".join(boxes)}</track>\n'


OUTSIDE = 'outside="1"'


def test_keyframe_only_tracks_are_interpolated_up_to_the_outside_box() -> None:
    # peers.md item 17 (keyframes only: cvat#7498, fiftyone PR#1285) and item 47
    boxes = golden().boxes
    one = boxes[boxes["track"] == 0]
    assert one["frame"].tolist() == [10, 15, 20, 25, 30]
    assert one["x"].tolist() == [100, 110, 120, 130, 140]
    assert one["y"].tolist() == [50, 50, 50, 50, 50]
    assert one["w"].tolist() == [20, 21, 22, 23, 24]
    assert one["h"].tolist() == [40, 42, 44, 46, 48]
    assert one["occlusion"].tolist() == [0, 0, 0, 0, 1]


def test_outside_boxes_are_not_boxes() -> None:
    # peers.md item 47: datumaro keeps them as ordinary boxes
    boxes = golden().boxes
    assert boxes.loc[boxes["track"] == 1, "frame"].tolist() == [15]
    assert 35 not in boxes["frame"].to_numpy()


def test_frames_of_a_stepped_task_are_those_of_the_video() -> None:
    # peers.md item 17: cvat#764
    images = golden().images
    assert images is not None
    assert images["frame"].tolist() == [10, 15, 20, 25, 30, 35, 40]
    assert images["recording"].unique().tolist() == ["drive1"]
    assert images["image_id"].tolist() == images["frame"].tolist()


def test_the_recording_is_the_video_with_its_size() -> None:
    recordings = golden().recordings
    assert recordings["name"].tolist() == ["drive1"]
    assert recordings[["width", "height"]].to_numpy().tolist() == [[640, 480]]
    assert recordings["fps"].isna().all()


def test_riders_and_boxes_with_an_ignore_attribute_are_ignore_regions() -> None:
    boxes = golden().boxes
    assert boxes.groupby("track")["ignore"].first().to_dict() == {0: False, 1: True, 2: True}


def test_labels_that_are_left_out_are_told_with_their_number() -> None:
    reading = golden()
    assert 3 not in reading.boxes["track"].to_numpy()
    assert "left out: car (1)" in reading.conversion
    assert "3 boxes filled in between keyframes" in reading.conversion


def test_every_box_has_the_line_of_its_keyframe() -> None:
    boxes = golden().boxes
    lines = [32, 32, 32, 32, 35, 39, 43]
    assert boxes["line"].tolist() == lines


def test_the_golden_file_has_no_findings() -> None:
    assert golden().findings == ()


def test_detections_have_no_ignore_regions() -> None:
    boxes = golden(role="detections").boxes
    assert not boxes["ignore"].any()
    assert sorted(set(boxes["track"])) == [0, 2]


def test_a_score_attribute_is_the_score(tmp_path: Path) -> None:
    inner = '<attribute name="Score">0.75</attribute>'
    reading = read_xml(tmp_path, track(box(0, inner=inner), box(1)), role="detections")
    assert reading.boxes["score"].tolist()[0] == 0.75
    assert np.isnan(reading.boxes["score"].iloc[1])


def test_the_classes_option_chooses_what_counts() -> None:
    boxes = golden(classes=("Car",)).boxes
    assert boxes.loc[~boxes["ignore"], "track"].tolist() == [3]
    assert set(boxes.loc[boxes["ignore"], "track"]) == {0, 1, 2}


def test_a_declared_label_without_boxes_can_be_asked_for() -> None:
    reading = golden(classes=("child",))
    assert [one.code for one in reading.findings] == ["no-counted-class"]


def test_an_unknown_class_lists_those_that_there_are() -> None:
    with pytest.raises(InputError, match=r"no class 'zebra'.*Pedestrian.*car, child"):
        golden(classes=("zebra",))


def test_boxes_that_are_no_keyframes_are_not_filled_up(tmp_path: Path) -> None:
    # CVAT leaves out deleted frames, here 2 and 3, and writes all others
    full = track(box(0), box(1, more='keyframe="0"'), box(4, more='keyframe="0"'), box(5))
    reading = read_xml(tmp_path, full)
    assert reading.boxes["frame"].tolist() == [0, 1, 4, 5]
    assert [(one.code, one.count) for one in reading.findings] == [("track-with-gap", 1)]
    assert reading.findings[0].example == "line 4: track 0, frame 1"


def test_an_interpolated_export_stays_as_it_is(tmp_path: Path) -> None:
    full = track(box(0), box(1, 3, more='keyframe="0"'), box(2, 4), box(3, 4, more=OUTSIDE))
    reading = read_xml(tmp_path, full)
    assert reading.boxes["x"].tolist() == [0, 3, 4]
    assert "0 boxes filled in" in reading.conversion


def test_nothing_is_filled_in_while_the_object_is_outside(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, track(box(0), box(2, more=OUTSIDE), box(5), box(6)))
    assert reading.boxes["frame"].tolist() == [0, 1, 5, 6]


def test_keyframes_need_not_be_in_order(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, track(box(2, 20), box(0, 0)))
    assert reading.boxes[["frame", "x"]].to_numpy().tolist() == [[0, 0], [1, 10], [2, 20]]


def test_tracks_are_not_joined_by_interpolation(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, track(box(0), number=4) + track(box(9), number=8))
    assert reading.boxes[["track", "frame"]].to_numpy().tolist() == [[4, 0], [8, 9]]


def test_a_track_that_stops_without_an_end_is_reported(tmp_path: Path) -> None:
    task = "<meta><task><start_frame>0</start_frame><stop_frame>99</stop_frame></task></meta>"
    reading = read_xml(tmp_path, task + track(box(0), box(3)))
    assert reading.boxes["frame"].tolist() == [0, 1, 2, 3]
    assert [one.code for one in reading.findings] == ["track-without-end"]
    assert reading.findings[0].example.endswith("frame 3")


def test_a_track_that_lasts_to_the_end_is_not_reported(tmp_path: Path) -> None:
    task = "<meta><task><start_frame>0</start_frame><stop_frame>3</stop_frame></task></meta>"
    assert read_xml(tmp_path, task + track(box(0), box(3))).findings == ()


def test_boxes_beside_the_step_are_reported(tmp_path: Path) -> None:
    task = "<meta><task><frame_filter>step=5</frame_filter></task></meta>"
    reading = read_xml(tmp_path, task + track(box(0), box(1), box(2), box(3, more=OUTSIDE)))
    assert [(one.code, one.count) for one in reading.findings] == [("frame-beside-step", 2)]


def test_a_task_that_contradicts_itself_does_not_tell_the_frames(tmp_path: Path) -> None:
    task = (
        "<meta><task><size>5</size><start_frame>0</start_frame>"
        "<stop_frame>99</stop_frame></task></meta>"
    )
    reading = read_xml(tmp_path, task + track(box(99)))
    assert reading.images is None
    assert [one.code for one in reading.findings] == ["frame-count"]
    assert "5 frames, from 0 to 99" in reading.findings[0].example


def test_without_size_and_stop_there_is_no_frame_list(tmp_path: Path) -> None:
    assert read_xml(tmp_path, track(box(0))).images is None


def test_the_size_alone_tells_the_frames(tmp_path: Path) -> None:
    images = read_xml(tmp_path, META.format(size=3) + track(box(0))).images
    assert images is not None
    assert images["frame"].tolist() == [0, 1, 2]


def test_the_frames_of_an_exported_job_are_its_own(tmp_path: Path) -> None:
    job = (
        "<meta><job><size>2</size><start_frame>5</start_frame><stop_frame>6</stop_frame>"
        "<frame_filter></frame_filter></job></meta>"
    )
    images = read_xml(tmp_path, job + track(box(5), box(6))).images
    assert images is not None
    assert images["frame"].tolist() == [5, 6]


def test_a_project_has_one_recording_per_task(tmp_path: Path) -> None:
    tasks = "".join(
        f"<task><id>{number}</id><name>{name}</name><size>{size}</size></task>"
        for number, name, size in ((3, "tunnel", 2), (4, "bridge", 1))
    )
    body = (
        f"<meta><project><tasks>{tasks}</tasks></project></meta>"
        f'<track id="0" label="person" task_id="4">{box(0)}</track>'
        f'<track id="1" label="person" task_id="3">{box(1)}</track>'
    )
    reading = read_xml(tmp_path, body)
    assert reading.boxes[["recording", "frame"]].to_numpy().tolist() == [
        ["bridge", 0],
        ["tunnel", 1],
    ]
    assert reading.images is not None
    assert reading.images["recording"].tolist() == ["tunnel", "tunnel", "bridge"]


def test_tasks_of_one_name_are_told_apart_by_their_number(tmp_path: Path) -> None:
    tasks = "".join(f"<task><id>{n}</id><name>night</name></task>" for n in (3, 4))
    reading = read_xml(tmp_path, f"<meta><project><tasks>{tasks}</tasks></project></meta>")
    assert reading.recordings["name"].tolist() == ["night-3", "night-4"]


def test_a_track_of_no_task_is_an_error(tmp_path: Path) -> None:
    tasks = "".join(f"<task><id>{n}</id></task>" for n in (3, 4))
    body = f"<meta><project><tasks>{tasks}</tasks></project></meta>\n" + track(box(0))
    with pytest.raises(FormatError, match=r"a\.xml, line 3: expected one of the tasks 3, 4"):
        read_xml(tmp_path, body)


def test_a_known_recording_in_the_path_comes_first(tmp_path: Path) -> None:
    (tmp_path / "tunnel").mkdir()
    reading = read_xml(
        tmp_path, track(box(0)), "tunnel/annotations.xml", recordings=("tunnel", "bridge")
    )
    assert reading.recordings["name"].tolist() == ["tunnel"]


def test_a_rotated_box_becomes_the_upright_box_around_it(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, track(box(0, 100, more='rotation="90"')))
    # 10 x 20 about (105, 10) turned by 90 degrees: 20 x 10
    assert reading.boxes[["x", "y", "w", "h"]].to_numpy()[0] == pytest.approx([95, 5, 20, 10])
    assert "1 rotated boxes replaced by the upright box" in reading.conversion


def test_rotation_is_interpolated_the_shorter_way(tmp_path: Path) -> None:
    body = track(box(0, more='rotation="350"'), box(2, more='rotation="10"'))
    # half-way between 350 and 10 degrees the box is upright
    middle = read_xml(tmp_path, body).boxes.iloc[1]
    assert middle[["x", "y", "w", "h"]].tolist() == pytest.approx([0, 0, 10, 20])


def test_pedestrians_drawn_as_polygons_are_reported(tmp_path: Path) -> None:
    shapes = "".join(
        f'<polygon frame="{f}" outside="{o}" points="1,1;2,2;3,1"/>' for f, o in ((0, 0), (1, 1))
    )
    skeleton = '<skeleton frame="0"><points label="head" outside="0" points="1,1"/></skeleton>'
    body = track(shapes) + track(skeleton, number=1) + track(shapes, number=2, label="road")
    reading = read_xml(tmp_path, body)
    assert len(reading.boxes) == 0
    assert [(one.code, one.count) for one in reading.findings] == [("no-box", 2)]
    assert "polygon, skeleton" in reading.findings[0].message


def test_two_tracks_of_one_id_are_reported(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, track(box(0)) + track(box(9)))
    assert reading.boxes["frame"].tolist() == [0, 9]
    assert [one.code for one in reading.findings] == ["track-id-twice"]


def test_empty_coordinates_are_passed_on(tmp_path: Path) -> None:
    body = track('<box frame="0" xtl="" ytl="0" xbr="1" ybr="nan"/>')
    reading = read_xml(tmp_path, body)
    assert reading.boxes[["x", "h"]].isna().all(axis=None)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (track(box(0).replace('xtl="0"', 'xtl="wide"')), r"line 3: .*number as xtl.*'wide'"),
        (track(box(0).replace('xtl="0"', "")), "line 3: expected xtl, found none"),
        (track(box(0).replace('frame="0"', "")), "line 3: expected frame, found none"),
        (track(box(0).replace('frame="0"', 'frame="1.5"')), "line 3: .*whole number as frame"),
        (track(box(0).replace('frame="0"', 'frame="1e99"')), "line 3: .*whole number as frame"),
        (track(box(0)).replace("label", "name"), "line 2: expected a label in <track>"),
        ('<image id="0" name="a_1.png"/>', "line 2: .*cvat-images"),
        ("<meta><task><frame_filter>step=0</frame_filter></task></meta>", "line 2: .*step=5"),
        ("<meta><task><size>-1</size></task></meta>", "line 2: expected size of 0 or more"),
        ("<meta><task><size>999999999999</size></task></meta>", "line 2: .*at most 10000000"),
        (track(box(0), box(10**12)), "line 3: expected keyframes near each other"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(FormatError, match=r"a\.xml, " + message):
        read_xml(tmp_path, body)


def test_no_tracks_are_no_boxes_in_all_frames(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, META.format(size=2))
    assert len(reading.boxes) == 0
    assert reading.images is not None
    assert len(reading.images) == 2


def test_own_files_are_recognised_and_no_others() -> None:
    head = GOLDEN.read_text(encoding="utf-8")
    assert recognise("a.xml", head, "truth")
    assert recognise("a.xml", "<annotations><mode>interpolation</mode>", "truth")
    assert not recognise("a.xml", "<annotations><mode>annotation</mode>", "truth")
    assert not recognise("a.xml", '<annotations><image id="0">', "truth")
    assert not recognise("a.xml", "<annotation><track >", "truth")
    assert not recognise("a.txt", "1,1,1,1,1,1,1", "truth")
    assert FORMAT.name == "cvat-video"


def test_an_attribute_of_the_annotator_marks_occlusion(tmp_path: Path) -> None:
    inner = '<attribute name="Occluded">yes</attribute>'
    boxes = read_xml(tmp_path, track(box(0, inner=inner), box(1))).boxes
    assert boxes["occlusion"].tolist() == [1, -1]


def test_tasks_of_a_project_take_their_names_from_their_videos(tmp_path: Path) -> None:
    tasks = "".join(
        f"<task><id>{n}</id><name>night</name><source>{v}.mp4</source></task>"
        for n, v in ((3, "tunnel"), (4, "bridge"))
    )
    reading = read_xml(tmp_path, f"<meta><project><tasks>{tasks}</tasks></project></meta>")
    assert reading.recordings["name"].tolist() == ["tunnel", "bridge"]


def test_both_formats_are_offered_to_the_registry() -> None:
    assert [one.name for one in FORMATS][:2] == ["cvat-video", "cvat-images"]
