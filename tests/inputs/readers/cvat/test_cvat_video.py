"""CVAT for video: tracks, outside, frame step, and the frames between keyframes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reader_files import golden, only_finding, rows, source

from nvcore.common.errors import FormatError, InputError
from nvcore.inputs.readers.base import Lines, Reading, ReadOptions, SourceFile
from nvcore.inputs.readers.cvat.video import FilledTracks, fill_between_keyframes, read


def read_golden(**options: object) -> Reading:
    return read(golden("cvat_video", "annotations.xml"), ReadOptions(**options))  # type: ignore[arg-type]


def read_xml(folder: Path, body: str, name: str = "a.xml", **options: object) -> Reading:
    file = source(folder, f"<annotations>\n{body}\n</annotations>", name)
    return read([file], ReadOptions(**options))  # type: ignore[arg-type]


def box(frame: int, x: float = 0, *, more: str = "", inner: str = "") -> str:
    corners = f'xtl="{x}" ytl="0" xbr="{x + 10}" ybr="20"'
    return f'<box frame="{frame}" {corners} {more}>{inner}</box>\n'


def track(*boxes: str, number: int = 0, label: str = "person") -> str:
    return f'<track id="{number}" label="{label}">\n{"".join(boxes)}</track>\n'


OUTSIDE = 'outside="1"'


def test_keyframe_only_tracks_are_interpolated_up_to_the_outside_box() -> None:
    # Other tools stumble over tracks of keyframes only (cvat#7498, fiftyone PR#1285), frames of a
    # stepped task (cvat#764) and outside boxes, here of track 0 in frame 35 (datumaro keeps them).
    # Track 1 has an ignore attribute, track 2 is a rider, track 3 a car
    reading = read_golden()
    assert rows(reading.boxes, "track frame line x y w h ignore occlusion") == [
        [0, 10, 32, 100, 50, 20, 40, False, 0],
        [0, 15, 32, 110, 50, 21, 42, False, 0],
        [0, 20, 32, 120, 50, 22, 44, False, 0],
        [0, 25, 32, 130, 50, 23, 46, False, 0],
        [0, 30, 35, 140, 50, 24, 48, False, 1],
        [1, 15, 39, 10.5, 20, 10, 20, True, 0],
        [2, 40, 43, 300, 100, 10, 30, True, 0],
    ]
    assert "left out: car (1)" in reading.conversion
    assert "3 boxes filled in between keyframes" in reading.conversion
    assert reading.findings == ()


def test_the_recording_is_the_video_with_its_size_and_frames() -> None:
    reading = read_golden()
    assert rows(reading.images, "recording frame image_id") == [
        ["drive1", frame, frame] for frame in range(10, 41, 5)
    ]
    assert rows(reading.recordings, "name width height fps") == [["drive1", 640, 480, None]]


def test_detections_have_no_ignore_regions() -> None:
    boxes = read_golden(role="detections").boxes
    assert not boxes["ignore"].any()
    assert sorted(set(boxes["track"])) == [0, 2]


def test_a_score_attribute_is_the_score(tmp_path: Path) -> None:
    inner = '<attribute name="Score">0.75</attribute>'
    reading = read_xml(tmp_path, track(box(0, inner=inner), box(1)), role="detections")
    assert rows(reading.boxes, "score") == [[0.75], [None]]


def test_the_classes_option_chooses_what_counts() -> None:
    boxes = read_golden(classes=("Car",)).boxes
    assert boxes.loc[~boxes["ignore"], "track"].tolist() == [3]
    assert set(boxes.loc[boxes["ignore"], "track"]) == {0, 1, 2}


def test_a_declared_label_can_be_asked_for_and_no_other() -> None:
    only_finding(read_golden(classes=("child",)), "no-counted-class")
    with pytest.raises(InputError, match=r"no class 'zebra'.*Pedestrian.*child.*car"):
        read_golden(classes=("zebra",))


def test_boxes_that_are_no_keyframes_are_not_filled_up(tmp_path: Path) -> None:
    # CVAT leaves out deleted frames, here 2 and 3, and writes all others
    full = track(box(0), box(1, more='keyframe="0"'), box(4, more='keyframe="0"'), box(5))
    reading = read_xml(tmp_path, full)
    assert reading.boxes["frame"].tolist() == [0, 1, 4, 5]
    finding = only_finding(reading, "track-with-gap")
    assert (finding.count, finding.example) == (1, "line 4: track 0, frame 1")


def test_an_interpolated_export_stays_as_it_is(tmp_path: Path) -> None:
    full = track(box(0), box(1, 3, more='keyframe="0"'), box(2, 4), box(3, 4, more=OUTSIDE))
    reading = read_xml(tmp_path, full)
    assert reading.boxes["x"].tolist() == [0, 3, 4]
    assert "0 boxes filled in" in reading.conversion


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (
            track(box(0), box(2, more=OUTSIDE), box(5), box(6)),
            [[0, 0, 0], [0, 1, 0], [0, 5, 0], [0, 6, 0]],
        ),
        (track(box(2, 20), box(0, 0)), [[0, 0, 0], [0, 1, 10], [0, 2, 20]]),
        (track(box(0), number=4) + track(box(9), number=8), [[4, 0, 0], [8, 9, 0]]),
    ],
    ids=["not while outside", "keyframes in any order", "not from track to track"],
)
def test_frames_between_keyframes_are_filled_in(
    tmp_path: Path, body: str, expected: list[list[int]]
) -> None:
    assert rows(read_xml(tmp_path, body).boxes, "track frame x") == expected


def task(kind: str = "task", **facts: object) -> str:
    """The description of a task or a job."""
    inner = "".join(f"<{name}>{value}</{name}>" for name, value in facts.items())
    return f"<meta><{kind}>{inner}</{kind}></meta>"


def test_a_track_that_stops_before_the_end_of_the_task_is_reported(tmp_path: Path) -> None:
    body = track(box(0), box(3))
    reading = read_xml(tmp_path, task(start_frame=0, stop_frame=99) + body)
    assert reading.boxes["frame"].tolist() == [0, 1, 2, 3]
    assert only_finding(reading, "track-without-end").example.endswith("frame 3")
    assert read_xml(tmp_path, task(start_frame=0, stop_frame=3) + body).findings == ()


def test_boxes_beside_the_step_are_reported(tmp_path: Path) -> None:
    boxes = track(box(1), box(2), box(3), box(4, more=OUTSIDE))
    reading = read_xml(tmp_path, task(start_frame=1, frame_filter="step=5") + boxes)
    assert only_finding(reading, "frame-beside-step").count == 2


@pytest.mark.parametrize(
    ("meta", "frames"),
    [
        (task(size=3, mode="interpolation"), [0, 1, 2]),
        (task("job", size=2, start_frame=5, stop_frame=6, frame_filter=""), [5, 6]),
        ("", None),
    ],
    ids=["size alone", "an exported job", "neither size nor stop"],
)
def test_the_frames_are_those_of_the_task(
    tmp_path: Path, meta: str, frames: list[int] | None
) -> None:
    images = read_xml(tmp_path, meta + track(box(5), box(6))).images
    assert (None if images is None else images["frame"].tolist()) == frames


def test_a_task_that_contradicts_itself_does_not_tell_the_frames(tmp_path: Path) -> None:
    meta = task(size=5, start_frame=0, stop_frame=99)
    reading = read_xml(tmp_path, meta + track(box(99)))
    assert reading.images is None
    assert "5 frames, from 0 to 99" in only_finding(reading, "frame-count").example


def project(*tasks: dict[str, object]) -> str:
    """The description of a project with these tasks."""
    parts = "".join(task(**facts).removeprefix("<meta>").removesuffix("</meta>") for facts in tasks)
    return f"<meta><project><tasks>{parts}</tasks></project></meta>\n"


def test_a_project_has_one_recording_per_task(tmp_path: Path) -> None:
    tracks = "".join(
        f'<track id="{n}" label="person" task_id="{number}">{box(n)}</track>'
        for n, number in enumerate((4, 3))
    )
    meta = project({"id": 3, "name": "tunnel", "size": 2}, {"id": 4, "name": "bridge", "size": 1})
    reading = read_xml(tmp_path, meta + tracks)
    assert rows(reading.boxes, "recording frame") == [["bridge", 0], ["tunnel", 1]]
    assert rows(reading.images, "recording") == [["tunnel"], ["tunnel"], ["bridge"]]


@pytest.mark.parametrize(
    ("facts", "names"),
    [
        ([{"name": "night"}, {"name": "night"}], ["night-3", "night-4"]),
        (
            [{"name": "night", "source": f"{video}.mp4"} for video in ("tunnel", "bridge")],
            ["tunnel", "bridge"],
        ),
    ],
    ids=["by number", "by video"],
)
def test_tasks_of_one_name_are_told_apart(
    tmp_path: Path, facts: list[dict[str, object]], names: list[str]
) -> None:
    tasks = [{"id": 3 + i, **more} for i, more in enumerate(facts)]
    assert read_xml(tmp_path, project(*tasks)).recordings["name"].tolist() == names


def test_a_track_of_no_task_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"a\.xml, line 3: expected one of the tasks 3, 4"):
        read_xml(tmp_path, project({"id": 3}, {"id": 4}) + track(box(0)))


def test_a_known_recording_in_the_path_comes_first(tmp_path: Path) -> None:
    known = ("tunnel", "bridge")
    reading = read_xml(tmp_path, track(box(0)), "tunnel/annotations.xml", recordings=known)
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


def polygon(frame: int, x: int, more: str = "") -> str:
    return f'<polygon frame="{frame}" {more} points="{x},1;{x + 2},9;{x + 4},1"/>'


def test_polygons_are_boxes_and_between_keyframes_the_box_moves(tmp_path: Path) -> None:
    body = track(polygon(0, 0), polygon(2, 6), polygon(3, 6, OUTSIDE))
    reading = read_xml(tmp_path, body)
    assert rows(reading.boxes, "track frame x y w h") == [
        [0, 0, 0, 1, 4, 8],
        [0, 1, 3, 1, 4, 8],
        [0, 2, 6, 1, 4, 8],
    ]
    assert "1 boxes filled in between keyframes (linear)" in reading.conversion
    assert "3 polygons, ellipses or masks replaced by the box around them" in reading.conversion
    assert reading.findings == ()


def test_pedestrians_drawn_as_lines_and_points_are_reported(tmp_path: Path) -> None:
    shapes = "".join(
        f'<polyline frame="{f}" outside="{o}" points="1,1;2,2"/>' for f, o in ((0, 0), (1, 1))
    )
    skeleton = '<skeleton frame="0"><points label="head" outside="0" points="1,1"/></skeleton>'
    body = track(shapes) + track(skeleton, number=1) + track(shapes, number=2, label="road")
    reading = read_xml(tmp_path, body)
    assert len(reading.boxes) == 0
    finding = only_finding(reading, "no-box")
    assert finding.count == 2
    assert "polyline, skeleton were left out" in finding.message


def test_two_tracks_of_one_id_are_reported(tmp_path: Path) -> None:
    reading = read_xml(tmp_path, track(box(0)) + track(box(9)))
    assert reading.boxes["frame"].tolist() == [0, 9]
    only_finding(reading, "track-id-twice")


def test_empty_coordinates_are_passed_on(tmp_path: Path) -> None:
    body = track('<box frame="0" xtl="" ytl="0" xbr="1" ybr="nan"/>')
    assert rows(read_xml(tmp_path, body).boxes, "x h") == [[None, None]]


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
    reading = read_xml(tmp_path, task(size=2))
    assert len(reading.boxes) == 0
    assert rows(reading.images, "frame") == [[0], [1]]


def test_an_attribute_of_the_annotator_marks_occlusion(tmp_path: Path) -> None:
    inner = '<attribute name="Occluded">yes</attribute>'
    boxes = read_xml(tmp_path, track(box(0, inner=inner), box(1))).boxes
    assert boxes["occlusion"].tolist() == [1, -1]


def test_frames_filled_in_have_the_attributes_of_the_keyframe_before_them(tmp_path: Path) -> None:
    inner = '<attribute name="age">child</attribute>'
    reading = read_xml(tmp_path, track(box(0, inner=inner), box(3, more=OUTSIDE)))
    assert rows(reading.boxes, "frame line") == [[0, 3], [1, 3], [2, 3]]
    assert reading.attributes is not None
    assert rows(reading.attributes, "file line attributes") == [[0, 3, "child"]]


def fill(frames: list[int], *, tracks: list[int] | None = None) -> FilledTracks:
    n = len(frames)
    return fill_between_keyframes(
        np.array(tracks or [0] * n, dtype=np.int64),
        np.array(frames, dtype=np.int64),
        np.zeros(n, dtype=bool),
        np.ones(n, dtype=bool),
        np.ones(n, dtype=np.int64),
        Lines.of(SourceFile(Path("a.xml"), "a.xml"), np.ones(n, dtype=np.int64)),
    )


def test_two_rows_of_one_frame_both_stay() -> None:
    assert fill([3, 3]).frame.tolist() == [3, 3]


def test_rows_keep_their_values_where_a_neighbour_has_none() -> None:
    filled = fill([0, 2])
    values = filled.between(np.array([1.0, np.nan]))
    np.testing.assert_array_equal(values, [1, np.nan, np.nan])


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 60)), max_size=12, unique=True))
def test_every_frame_between_the_first_and_the_last_of_a_track_is_there_once(
    rows: list[tuple[int, int]],
) -> None:
    tracks, frames = [row[0] for row in rows], [row[1] for row in rows]
    filled = fill(frames, tracks=tracks)
    filled_frames = (
        sorted(zip(np.array(tracks)[filled.left].tolist(), filled.frame.tolist(), strict=True))
        if rows
        else []
    )
    expected = []
    for track in sorted(set(tracks)):
        own = [f for t, f in rows if t == track]
        expected += [(track, f) for f in range(min(own), max(own) + 1)]
    assert filled_frames == expected


@given(st.lists(st.integers(0, 60), min_size=2, max_size=8, unique=True))
def test_a_quantity_that_is_linear_in_time_stays_so(frames: list[int]) -> None:
    filled = fill(frames)
    values = filled.between(3.0 * np.array(frames) - 7)
    assert values == pytest.approx(3.0 * filled.frame - 7)
