"""MOTChallenge truth, detections and results."""

from __future__ import annotations

from pathlib import Path

import pytest
from reader_files import golden, only_finding, rows, source

from nvcore.common.errors import FormatError, InputError
from nvcore.dataset.schema import READING_DTYPES, UNKNOWN_OCCLUSION
from nvcore.inputs.readers import format_named
from nvcore.inputs.readers.base import Reading, ReadOptions
from nvcore.inputs.readers.mot import read

NAME = "A/gt/gt.txt"
TRUTH = "MOT16-02/gt/gt.txt"
DETECTIONS = ReadOptions(role="detections")


def read_text(folder: Path, text: str, options: ReadOptions | None = None, name: str = NAME):
    return read([source(folder, text, name)], options or ReadOptions())


def read_golden(name: str, **options: object) -> Reading:
    return read(golden("mot", name), ReadOptions(**options))


def test_truth_is_zero_based_and_visibility_a_level_of_occlusion():
    # Libraries disagree by one pixel on the same file. The class decides as well as the flag
    # whether a row is ignored. A car (line 4) is left out, and frame 3 has no row but is evaluated
    # all the same
    reading = read_golden(TRUTH)
    assert rows(reading.boxes, "frame track line x y w h ignore occlusion") == [
        [1, 1, 1, 0, 0, 10, 20, False, 0],
        [1, 2, 2, 100, 50, 30, 60, True, 0],
        [1, 3, 3, 200, 50, 30, 60, True, 1],
        [2, 1, 5, 2.5, 0, 10, 20, False, 1],
        [2, 5, 6, 400, 50, 30, 60, False, 2],
    ]
    assert rows(reading.recordings, "name width height fps") == [["MOT16-02", 1920, 1080, 30]]
    assert rows(reading.images, "recording frame") == [["MOT16-02", frame] for frame in (1, 2, 3)]
    assert "pedestrian counted; person_on_vehicle, static_person" in reading.conversion
    assert "others left out" in reading.conversion


@pytest.mark.parametrize("classes", [("static_person", "car"), ("7", "3")])
def test_the_classes_that_count_can_be_named_or_numbered(classes):
    boxes = read_golden(TRUTH, classes=classes).boxes
    assert rows(boxes, "x ignore") == [[100, False], [300, False]]


@pytest.mark.parametrize("name", ["dog", "14", "²"])
def test_an_unknown_class_is_answered_with_the_known_ones(name):
    with pytest.raises(InputError, match=f"no class '{name}'; the classes are pedestrian, "):
        read_golden(TRUTH, classes=(name,))


BOXMOT_ROWS = "1,1,10,20,30,60,1,0,0.75\n2,1,11,20,30,60,1,0,0.5\n"


def test_a_constant_score_beside_a_column_that_varies_is_asked_about(tmp_path: Path):
    reading = read_text(tmp_path, BOXMOT_ROWS, DETECTIONS)
    finding = only_finding(reading, "constant-score-column")
    assert (finding.severity, finding.count) == ("error", 2)
    assert "seventh column is 1 throughout, while the ninth column varies" in finding.message
    steps = [(step.remedy, step.value) for step in finding.steps]
    assert steps == [("format", "boxmot"), ("accept", "constant-score-column")]
    assert reading.boxes["score"].tolist() == [1, 1]


@pytest.mark.parametrize(
    ("text", "scores"),
    [
        (BOXMOT_ROWS, [0.75, 0.5]),
        ("1,1,1,1,9,9,-1,0.7,-1,-1\n2,1,1,1,9,9,-1,0.9,-1,-1\n", [0.7, 0.9]),
        ("1,1,1,1,9,9,1,0,0.7\n", [0.7]),
        ("1,1,1,1,9,9,0.4\n", [0.4]),
    ],
    ids=["ninth", "eighth", "a single row", "none behind"],
)
def test_boxmot_s_score_is_behind_the_seventh_column(tmp_path: Path, text: str, scores):
    reading = format_named("boxmot").read([source(tmp_path, text, NAME)], DETECTIONS)
    assert reading.boxes["score"].tolist() == scores
    assert reading.findings == ()


@pytest.mark.parametrize(
    "text",
    [
        BOXMOT_ROWS.replace("60,1,0,0.5", "60,0.9,0,0.5"),  # scores that vary
        BOXMOT_ROWS.replace("0.5", "0.75"),
        BOXMOT_ROWS.replace("0.5", "1.5"),  # a coordinate
        BOXMOT_ROWS.replace("0.75", "1").replace("0.5", "0"),  # flags
    ],
)
def test_other_columns_behind_the_score_are_not_asked_about(tmp_path: Path, text: str):
    assert read_text(tmp_path, text, DETECTIONS).findings == ()
    assert read_text(tmp_path, BOXMOT_ROWS).findings == ()  # visibility of a truth


def test_detections_have_scores_and_no_tracks():
    reading = read_golden("MOT16-02/det/det.txt", role="detections")
    assert rows(reading.boxes, "score track ignore") == [[0.9, -1, False], [-0.25, -1, False]]
    assert reading.images is None


def test_mot15_world_coordinates_are_not_classes(tmp_path):
    # columns 8 to 10 are x, y, z in MOT15: 4.0 is no bicycle
    reading = read_text(tmp_path, "1,1,1,1,9,9,1,4.0,5.5,0\n1,2,1,1,9,9,0,7.0,5.5,0\n")
    assert reading.boxes["ignore"].tolist() == [False, True]
    assert (reading.boxes["occlusion"] == UNKNOWN_OCCLUSION).all()
    assert "classes" not in reading.conversion


@pytest.mark.parametrize("conf", ["1", "-1", "0.4", ""])
def test_every_conf_but_0_is_active_in_truth(tmp_path, conf):
    # Conf -1 filtered the whole truth elsewhere
    boxes = read_text(tmp_path, f"1,1,1,1,9,9,{conf},-1,-1,-1\n").boxes
    assert boxes["ignore"].tolist() == [False]


def test_scores_are_unknown_only_where_all_are_minus_1(tmp_path):
    row = "1,1,1,1,9,9,-1,-1,-1,-1\n"
    reading = read_text(tmp_path, row * 2, DETECTIONS)
    assert reading.boxes["score"].isna().all()
    assert "-1 throughout: no scores" in reading.conversion
    boxes = read_text(tmp_path, row + "2,1,1,1,9,9,0.5,-1,-1,-1\n", DETECTIONS).boxes
    assert boxes["score"].tolist() == [-1, 0.5]


@pytest.mark.parametrize("n_columns", [7, 8, 9, 10])
def test_7_to_10_columns_are_read(tmp_path, n_columns):
    row = ["1", "4", "11", "21", "9", "8", "1", "1", "1", "-1"][:n_columns]
    assert rows(read_text(tmp_path, ",".join(row)).boxes, "x y w h") == [[10, 20, 9, 8]]


def test_a_vehicle_without_motor_is_a_distractor_in_mot20_only(tmp_path):
    row = "1,1,1,1,9,9,1,6,1\n"
    assert len(read_text(tmp_path, row, name="MOT17-02/gt/gt.txt").boxes) == 0
    new = read_text(tmp_path, row, name="MOT20-02/gt/gt.txt").boxes
    assert new["ignore"].tolist() == [True]


def test_classes_without_a_class_column_are_answered_in_the_conversion(tmp_path):
    reading = read_text(tmp_path, "1,1,1,1,9,9,1\n", ReadOptions(classes=("car",)))
    assert "no class column: all rows counted" in reading.conversion
    assert len(reading.boxes) == 1


@pytest.mark.parametrize(
    ("text", "role", "code", "example"),
    [
        ("1,1,1,1,9,9,1,1,1\n2,1,1,1,9,9,1,99,1\n", "truth", "unknown-class", "line 2: 99"),
        ("0,1,1,1,9,9,1\n", "detections", "frame-before-first", "line 1: frame 0"),
        ("1,1,1,1,9,9,85,-1,-1,-1\n2,1,1,1,9,9,1\n", "truth", "truth-with-scores", "line 1: 85"),
        ("1,-1,1,1,5,5,0.83\n2,-1,1,1,5,5,1\n", "truth", "truth-with-scores", "line 1: 0.83"),
    ],
)
def test_what_the_format_does_not_have_is_reported(tmp_path, text, role, code, example):
    finding = only_finding(read_text(tmp_path, text, ReadOptions(role=role)), code)
    assert (finding.count, finding.example) == (1, example)
    assert ("swapped" in finding.advice) == (code == "truth-with-scores")


def test_flags_of_minus_1_to_1_in_the_truth_are_not_reported(tmp_path):
    rows_of_truth = "1,1,1,1,5,5,1\n2,1,1,1,5,5,0\n3,1,1,1,5,5,-1\n"
    assert read_text(tmp_path, rows_of_truth).findings == ()


def test_boxes_without_numbers_are_passed_on(tmp_path):
    boxes = read_text(tmp_path, "1,1,nan,,9,0,1\n").boxes
    assert rows(boxes, "x y h") == [[None, None, 0]]


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,a,1,1,9,9,1", "expected numbers .*found 'a'"),  # text ids crashed
        ("1.5,1,1,1,9,9,1", "expected a whole number as frame, found 1.5"),
        ("1,0.5,1,1,9,9,1", "expected a whole number as id"),
        (",1,1,1,9,9,1", "expected a whole number as frame, found nan"),
        ("1,1,1,1,9,9", "expected 7 or 8 or 9 or 10 fields"),
        ("1,1,1,1,9,9,1,1.5,1", "expected a whole number as class"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"A/gt/gt\.txt, line 2: {words}"):
        read_text(tmp_path, f"1,1,1,1,9,9,1,1,1\n{row}\n")


@pytest.mark.parametrize("options", [ReadOptions(), DETECTIONS])
def test_an_empty_file_is_a_recording_without_boxes(tmp_path, options):
    # An empty list of results crashed elsewhere
    reading = read_text(tmp_path, "", options)
    assert len(reading.boxes) == 0
    assert list(reading.boxes.columns) == list(READING_DTYPES)
    assert reading.recordings["name"].tolist() == ["A"]


def test_several_recordings_are_told_apart_and_one_without_seqinfo_leaves_the_frames_open(tmp_path):
    files = [*golden("mot", TRUTH), source(tmp_path, "5,1,1,1,9,9,1\n", "B/gt/gt.txt")]
    reading = read(files, ReadOptions())
    assert rows(reading.boxes, "recording file frame")[-2:] == [["MOT16-02", 0, 2], ["B", 1, 5]]
    assert reading.images is None


def test_results_find_the_recording_of_the_truth_in_their_path(tmp_path):
    options = ReadOptions(role="detections", recordings=("MOT16-01", "MOT16-02"))
    boxes = read_text(tmp_path, "1,1,1,1,9,9,1\n", options, "MOT16-02/tracker/x.txt").boxes
    assert boxes["recording"].tolist() == ["MOT16-02"]
