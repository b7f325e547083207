"""MOTChallenge truth, detections and results."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import DATA

from nvcore.errors import FormatError, InputError
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.mot import FORMAT, read, recognise
from nvcore.schema import NO_TRACK, READING_DTYPES, UNKNOWN_OCCLUSION

GOLDEN = DATA / "mot"
DETECTIONS = ReadOptions(role="detections")


def source(tmp_path: Path, content: str, name: str = "A/gt/gt.txt") -> SourceFile:
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    return SourceFile(path, name)


def golden(name: str) -> SourceFile:
    return SourceFile(GOLDEN / name, name)


TRUTH = "MOT16-02/gt/gt.txt"


def test_a_box_at_1_1_lies_at_the_origin():
    # peers.md 42: libraries disagree by one pixel on the same file
    first = read([golden(TRUTH)], ReadOptions()).boxes.iloc[0]
    assert first[["x", "y", "w", "h"]].tolist() == [0, 0, 10, 20]


def test_frames_tracks_and_lines_are_kept():
    boxes = read([golden(TRUTH)], ReadOptions()).boxes
    assert boxes["frame"].tolist() == [1, 1, 1, 2, 2]
    assert boxes["track"].tolist() == [1, 2, 3, 1, 5]
    assert boxes["line"].tolist() == [1, 2, 3, 5, 6]
    assert boxes["x"].tolist() == [0, 100, 200, 2.5, 400]


def test_conf_0_and_distractors_are_ignored_and_cars_left_out():
    # peers.md 40: the class decides as well as the flag
    reading = read([golden(TRUTH)], ReadOptions())
    assert reading.boxes["ignore"].tolist() == [False, True, True, False, False]
    assert "pedestrian counted; person_on_vehicle, static_person" in reading.conversion
    assert "others left out" in reading.conversion


def test_visibility_becomes_a_level_of_occlusion():
    boxes = read([golden(TRUTH)], ReadOptions()).boxes
    assert boxes["occlusion"].tolist() == [0, 0, 1, 1, 2]


@pytest.mark.parametrize("classes", [("static_person", "car"), ("7", "3")])
def test_the_classes_that_count_can_be_named_or_numbered(classes):
    boxes = read([golden(TRUTH)], ReadOptions(classes=classes)).boxes
    assert boxes["x"].tolist() == [100, 300]
    assert not boxes["ignore"].any()


@pytest.mark.parametrize("name", ["dog", "14", "²"])
def test_an_unknown_class_is_answered_with_the_known_ones(name):
    with pytest.raises(InputError, match=f"no class '{name}'; it has pedestrian, person_on"):
        read([golden(TRUTH)], ReadOptions(classes=(name,)))


def test_size_rate_and_evaluated_frames_come_from_seqinfo():
    reading = read([golden(TRUTH)], ReadOptions())
    assert reading.recordings.iloc[0].tolist() == ["MOT16-02", 1920, 1080, 30]
    # frame 3 has no row: it is evaluated all the same
    assert reading.images["frame"].tolist() == [1, 2, 3]
    assert set(reading.images["recording"]) == {"MOT16-02"}


def test_detections_have_scores_and_no_tracks():
    reading = read([golden("MOT16-02/det/det.txt")], DETECTIONS)
    assert reading.boxes["score"].tolist() == [0.9, -0.25]
    assert (reading.boxes["track"] == NO_TRACK).all()
    assert not reading.boxes["ignore"].any()
    assert reading.images is None


def test_mot15_world_coordinates_are_not_classes(tmp_path):
    # columns 8 to 10 are x, y, z in MOT15: 4.0 is no bicycle
    file = source(tmp_path, "1,1,1,1,9,9,1,4.0,5.5,0\n1,2,1,1,9,9,0,7.0,5.5,0\n")
    reading = read([file], ReadOptions())
    assert reading.boxes["ignore"].tolist() == [False, True]
    assert (reading.boxes["occlusion"] == UNKNOWN_OCCLUSION).all()
    assert "classes" not in reading.conversion


@pytest.mark.parametrize("conf", ["1", "-1", "0.4", ""])
def test_every_conf_but_0_is_active_in_truth(tmp_path, conf):
    # peers.md 39: conf -1 filtered the whole truth elsewhere
    file = source(tmp_path, f"1,1,1,1,9,9,{conf},-1,-1,-1\n")
    assert read([file], ReadOptions()).boxes["ignore"].tolist() == [False]


def test_scores_of_nothing_but_minus_1_are_no_scores(tmp_path):
    file = source(tmp_path, "1,1,1,1,9,9,-1,-1,-1,-1\n2,1,1,1,9,9,-1,-1,-1,-1\n")
    reading = read([file], DETECTIONS)
    assert reading.boxes["score"].isna().all()
    assert "-1 throughout: no scores" in reading.conversion


def test_one_score_of_minus_1_among_others_is_a_score(tmp_path):
    file = source(tmp_path, "1,1,1,1,9,9,-1,-1,-1,-1\n2,1,1,1,9,9,0.5,-1,-1,-1\n")
    assert read([file], DETECTIONS).boxes["score"].tolist() == [-1, 0.5]


@pytest.mark.parametrize("n_columns", [7, 8, 9, 10])
def test_7_to_10_columns_are_read(tmp_path, n_columns):
    row = ["1", "4", "11", "21", "9", "8", "1", "1", "1", "-1"][:n_columns]
    boxes = read([source(tmp_path, ",".join(row))], ReadOptions()).boxes
    assert boxes[["x", "y", "w", "h"]].iloc[0].tolist() == [10, 20, 9, 8]


def test_a_vehicle_without_motor_is_a_distractor_in_mot20_only(tmp_path):
    row = "1,1,1,1,9,9,1,6,1\n"
    old = read([source(tmp_path, row, "MOT17-02/gt/gt.txt")], ReadOptions()).boxes
    new = read([source(tmp_path, row, "MOT20-02/gt/gt.txt")], ReadOptions()).boxes
    assert len(old) == 0
    assert new["ignore"].tolist() == [True]


def test_a_row_of_a_class_beyond_13_is_reported(tmp_path):
    file = source(tmp_path, "1,1,1,1,9,9,1,1,1\n2,1,1,1,9,9,1,99,1\n")
    (finding,) = read([file], ReadOptions()).findings
    assert (finding.code, finding.count) == ("unknown-class", 1)
    assert finding.example == "line 2: class 99"


def test_classes_without_a_class_column_are_answered_in_the_conversion(tmp_path):
    file = source(tmp_path, "1,1,1,1,9,9,1\n")
    reading = read([file], ReadOptions(classes=("car",)))
    assert "no class column: all rows counted" in reading.conversion
    assert len(reading.boxes) == 1


def test_frame_0_is_reported_because_frames_begin_at_1(tmp_path):
    (finding,) = read([source(tmp_path, "0,1,1,1,9,9,1\n")], DETECTIONS).findings
    assert finding.code == "frame-before-first"
    assert finding.example == "line 1: frame 0"


def test_whole_scores_in_the_truth_are_reported_as_fractions_are(tmp_path):
    file = source(tmp_path, "1,1,1,1,9,9,85,-1,-1,-1\n2,1,1,1,9,9,1,-1,-1,-1\n")
    (finding,) = read([file], ReadOptions()).findings
    assert (finding.code, finding.count) == ("truth-with-scores", 1)
    assert finding.example == "line 1: 85"


def test_boxes_without_numbers_are_passed_on(tmp_path):
    boxes = read([source(tmp_path, "1,1,nan,,9,0,1\n")], ReadOptions()).boxes
    assert np.isnan(boxes["x"][0])
    assert np.isnan(boxes["y"][0])
    assert boxes["h"][0] == 0


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,a,1,1,9,9,1", "expected numbers .*found 'a'"),  # peers.md 41: text ids crashed
        ("1.5,1,1,1,9,9,1", "expected a whole number as frame, found 1.5"),
        ("1,0.5,1,1,9,9,1", "expected a whole number as id"),
        (",1,1,1,9,9,1", "expected a whole number as frame, found nan"),
        ("1,1,1,1,9,9", "expected 7 or 8 or 9 or 10 fields"),
        ("1,1,1,1,9,9,1,1.5,1", "expected a whole number as class"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"A/gt/gt\.txt, line 2: {words}"):
        read([source(tmp_path, f"1,1,1,1,9,9,1,1,1\n{row}\n")], ReadOptions())


@pytest.mark.parametrize("options", [ReadOptions(), DETECTIONS])
def test_an_empty_file_is_a_recording_without_boxes(tmp_path, options):
    # peers.md 36: an empty list of results crashed elsewhere
    reading = read([source(tmp_path, "")], options)
    assert len(reading.boxes) == 0
    assert list(reading.boxes.columns) == list(READING_DTYPES)
    assert reading.recordings["name"].tolist() == ["A"]


def test_several_recordings_keep_their_file_numbers_and_names(tmp_path):
    files = [
        source(tmp_path, "1,1,1,1,9,9,1\n", "A/gt/gt.txt"),
        source(tmp_path, "5,1,1,1,9,9,1\n", "B/gt/gt.txt"),
    ]
    reading = read(files, ReadOptions())
    assert reading.boxes["recording"].tolist() == ["A", "B"]
    assert reading.boxes["file"].tolist() == [0, 1]
    assert reading.boxes["frame"].tolist() == [1, 5]
    assert reading.images is None


def test_one_recording_without_seqinfo_leaves_the_frames_open(tmp_path):
    files = [golden(TRUTH), source(tmp_path, "1,1,1,1,9,9,1\n", "B/gt/gt.txt")]
    assert read(files, ReadOptions()).images is None


def test_two_files_of_one_recording_are_an_error(tmp_path):
    files = [source(tmp_path, "", "A/gt/gt.txt"), source(tmp_path, "", "A/det/det.txt")]
    with pytest.raises(InputError, match=r"holds recording 'A', as A/gt/gt\.txt does"):
        read(files, ReadOptions())


def test_results_find_the_recording_of_the_truth_in_their_path(tmp_path):
    file = source(tmp_path, "1,1,1,1,9,9,1\n", "MOT16-02/tracker/x.txt")
    options = ReadOptions(role="detections", recordings=("MOT16-01", "MOT16-02"))
    assert read([file], options).boxes["recording"].tolist() == ["MOT16-02"]


@pytest.mark.parametrize(
    "text", ["1,-1,1.5,2,3,4,0.5,-1,-1,-1\n", "1,1,1,1,9,9,1", "\ufeff1,1,,1,9,9,1\n"]
)
def test_own_rows_are_recognised(text):
    assert recognise("gt.txt", text, "truth")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1,2,3,4,5,0.5\n",
        "frame,id,x,y,w,h,score\n1,1,1,1,9,9,1\n",
        "1.5,1,1,1,9,9,1\n",
        "0 1 Car 0 0 0 1 2 3 4 1 1 1 1 1 1 1\n",
        "0,1,2,3,4,5,6,7,8,9,10,11,12,13,14\n",
        '{"images": []}',
    ],
)
def test_rows_of_other_formats_are_not_claimed(text):
    assert not recognise("gt.txt", text, "truth")
    assert FORMAT.name == "mot"


@pytest.mark.realdata
def test_the_real_recordings_have_the_flags_and_lengths_of_their_files(realdata):
    files = [
        SourceFile(p, p.parent.parent.name) for p in sorted(realdata.glob("mot15/*/gt/gt.txt"))
    ]
    reading = read(files, ReadOptions())
    lengths = reading.images.groupby("recording").size().to_dict()
    assert lengths == {
        "ETH-Sunnyday": 354, "PETS09-S2L1": 795, "TUD-Campus": 71, "TUD-Stadtmitte": 179,
    }  # fmt: skip
    # awk -F, '$7 == 0' gt.txt | wc -l
    flags = reading.boxes.groupby("recording")["ignore"].sum().to_dict()
    assert flags == {
        "ETH-Sunnyday": 43, "PETS09-S2L1": 174, "TUD-Campus": 0, "TUD-Stadtmitte": 0,
    }  # fmt: skip


def test_scores_in_the_truth_look_like_swapped_files(tmp_path):
    rows = "1,-1,1,1,5,5,0.83\n2,-1,1,1,5,5,1\n"
    reading = read([source(tmp_path, rows)], ReadOptions())
    (finding,) = reading.findings
    assert (finding.code, finding.count, finding.example) == (
        "truth-with-scores",
        1,
        "line 1: 0.83",
    )
    assert "swapped" in finding.advice


def test_whole_numbers_in_column_7_of_the_truth_are_not_reported(tmp_path):
    rows = "1,1,1,1,5,5,1\n2,1,1,1,5,5,0\n3,1,1,1,5,5,-1\n"
    assert read([source(tmp_path, rows)], ReadOptions()).findings == ()
