from __future__ import annotations

from pathlib import Path

import pytest
from reader_files import golden, only_finding, rows, source

from nvcore.common.errors import FormatError, InputError
from nvcore.dataset.schema import NO_TRACK
from nvcore.inputs.readers import csv
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile


def read_golden(name: str, **options: object) -> Reading:
    return csv.read(golden("csv", name), ReadOptions(**options))


@pytest.fixture
def read_text(tmp_path: Path):
    def read_one(text: str | bytes, name: str = "drive.csv", **options: object) -> Reading:
        return csv.read([source(tmp_path, text, name)], ReadOptions(**options))

    return read_one


def test_all_columns_are_read():
    reading = read_golden("truth.csv")
    columns = "recording frame x y w h track ignore occlusion line distance_m"
    assert rows(reading.boxes, columns) == [
        ["urban", 9, 282, 205, 20, 43, 1, False, 0, 2, 31.5],
        ["urban", 9, 241.5, 205, 37, 42, -1, True, 2, 3, None],
        ["urban", 29, 392, 208, 19, 44, 1, False, -1, 4, 28],
        ["rural", 0, 10, 20, 5, 12, 7, False, 1, 5, None],
    ]
    assert reading.recordings["name"].tolist() == ["urban", "rural"]


def test_a_distance_of_zero_or_less_is_unknown_with_a_note(read_text):
    reading = read_text("frame,x,y,w,h,distance_m\n1,2,3,4,5,-1\n2,2,3,4,5,0\n3,2,3,4,5,0.5\n")
    assert rows(reading.boxes, "distance_m") == [[None], [None], [0.5]]
    (finding,) = (note for note in reading.findings if note.code == "unknown-distance")
    assert finding.count == 2


def test_without_recording_column_the_file_is_the_recording(read_text):
    reading = read_text("frame,x,y,w,h\n1,2,3,4,5\n", name="night/gt.csv")
    assert rows(reading.boxes, "recording") == rows(reading.recordings, "name") == [["night"]]


def test_a_file_with_a_header_only_is_a_recording_without_boxes(read_text):
    reading = read_text("frame,x,y,w,h,score\n", role="detections")
    assert reading.boxes.empty
    assert reading.recordings["name"].tolist() == ["drive"]


@pytest.mark.parametrize(
    "header",
    [
        "video_frame,x,y,w,h",
        "frame_id,left,top,width,height",
        "Frame Number,BB Left,BB-Top,bb.width,bb_height",
        'frame;"x";y;w;h',
        " frame\tx\ty\tw\th ",
        "\ufeffframe,x,y,w,h\r",
    ],
)
def test_columns_have_synonyms_and_delimiters_are_told(read_text, header):
    delimiter = max(",;\t", key=header.count)
    boxes = read_text(header + "\n" + delimiter.join(["7", "1", "2", "3", "4"]) + "\n").boxes
    assert rows(boxes, "frame x y w h") == [[7, 1, 2, 3, 4]]


def test_score_synonym_is_read_for_detections(read_text):
    boxes = read_text("frame,x,y,w,h,Confidence\n1,2,3,4,5,0.25\n", role="detections").boxes
    assert boxes["score"].tolist() == [0.25]


@pytest.mark.parametrize(
    ("columns", "values", "scores", "n_findings"),
    [
        ("score,conf", ["1,0.5", "1,0.75"], [0.5, 0.75], 1),
        ("conf,score", ["0.5,1", "0.75,1"], [0.5, 0.75], 1),
        ("score,prob", [",0.5", ",0.75"], [0.5, 0.75], 1),
        ("score,conf", ["0.25,1", "0.5,1"], [0.25, 0.5], 0),
        ("score,conf", ["0.25,0.5", "0.5,0.75"], [0.25, 0.5], 0),
        ("score,conf", ["1,high", "1,low"], [1, 1], 0),
    ],
)
def test_of_two_columns_of_scores_the_one_that_varies_is_taken(
    read_text, columns, values, scores, n_findings
):
    lines = [f"frame,x,y,w,h,{columns}", *(f"{i},2,3,4,5,{text}" for i, text in enumerate(values))]
    reading = read_text("\n".join(lines), role="detections")
    assert reading.boxes["score"].tolist() == scores
    assert len(reading.findings) == n_findings
    unused = {*columns.split(",")} - {"score"} if not n_findings else {"score"}
    assert f"columns left unused: {unused.pop()}" in reading.conversion
    if n_findings:
        finding = only_finding(reading, "constant-score-column")
        assert finding.message.startswith("The column score is the same throughout, while ")
    truth = read_text("\n".join(lines))
    assert [finding.code for finding in truth.findings] == ["truth-with-scores"]


def test_pictures_name_tells_recording_and_frame_and_corners_become_sizes():
    reading = read_golden("corners.csv")
    assert rows(reading.boxes, "recording frame x y w h ignore") == [
        ["set06/V000", 19, 10.5, 20, 5, 12, False],
        ["set06/V000", 39, 100, 200, 30, 60, True],
    ]
    for fact in (
        "columns left unused: width, height",
        "decimal commas",
        "corners to width and height",
        "recordings and frame numbers from the pictures' names",
        "person counted; cyclist ignored; car left out",
    ):
        assert fact in reading.conversion


def test_classes_option_names_what_counts():
    boxes = read_golden("corners.csv", classes=("cyclist",)).boxes
    assert boxes["ignore"].tolist() == [True, False]
    with pytest.raises(FormatError, match="no class 'tram'; the classes are person, cyclist, car"):
        read_golden("corners.csv", classes=("tram",))


def test_detections_of_a_cyclist_are_left_out():
    assert len(read_golden("corners.csv", role="detections").boxes) == 1


def test_extra_columns_are_told_and_left_unused(read_text):
    reading = read_text("frame,image_name,x,y,w,h,speed\n1,a7.png,2,3,4,5,9\n")
    assert "columns left unused: image_name, speed" in reading.conversion
    assert reading.boxes["frame"].tolist() == [1]


@pytest.mark.parametrize(
    ("base", "frame", "fact"),
    [
        (None, 1, "frame numbers as they are"),
        (0, 1, ""),
        (1, 0, "frame numbers from 1-based to 0-based"),
    ],
)
def test_a_declared_base_of_one_makes_the_first_frame_zero(read_text, base, frame, fact):
    reading = read_text("frame,x,y,w,h\n1,2,3,4,5\n", frame_base=base)
    assert reading.boxes["frame"].tolist() == [frame]
    assert fact in reading.conversion


def test_a_frame_below_the_declared_base_is_an_error(read_text):
    with pytest.raises(FormatError, match="line 3: expected frame numbers from 1 on"):
        read_text("frame,x,y,w,h\n1,2,3,4,5\n0,2,3,4,5\n", frame_base=1)


def test_text_track_ids_are_numbered_after_the_largest_number_of_their_recording(read_text):
    rows = ["b,ped_7", "a,3", "a,ped_7", "a,ped_2", "a,ped_7", "a,", "b,ped_9", "a,0"]
    lines = [f"1,2,3,4,5,{row}" for row in rows]
    reading = read_text("frame,x,y,w,h,recording,id\n" + "\n".join(lines) + "\n")
    assert reading.boxes["track"].tolist() == [0, 3, 4, 5, 4, NO_TRACK, 1, 0]
    assert "numbered by first appearance" in reading.conversion


@pytest.mark.parametrize(
    ("text", "columns", "expected"),
    [
        # too large for a float: they stay different
        (
            "frame,x,y,w,h,id\n1,2,3,4,5,9007199254740993\n1,2,3,4,5,9007199254740992\n",
            "track",
            [[0], [1]],
        ),
        ("frame,x,y,w,h,id\n1,2,3,4,5,-1\n1,2,3,4,5,0\n1,2,3,4,5,2.0\n", "track", [[-1], [0], [2]]),
        ("frame,x,y,w,h\n1,,3,nan,5\n", "x w", [[None, None]]),
        ("frame,x,y,w,h\n\n1,2,3,4,5\n\n2,2,3,4,5\n", "line", [[3], [5]]),
        # an apostrophe against spreadsheets is taken off
        (
            "frame,x,y,w,h,recording\n1,2,3,4,5,'=cmd\n1,2,3,4,5,'a'\n",
            "recording",
            [["=cmd"], ["'a'"]],
        ),
    ],
)
def test_odd_fields_are_read(read_text, text, columns, expected):
    assert rows(read_text(text).boxes, columns) == expected


def test_odd_occlusion_levels_are_reported(read_text):
    reading = read_text("frame,x,y,w,h,occlusion\n1,2,3,4,5,3\n")
    finding = only_finding(reading, "unknown-occlusion")
    assert (finding.count, finding.example) == (1, "line 2: 3")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (" \n", "drive.csv: the file is empty; expected a header line"),
        ("frame,x,y,w\n", "line 1: .*found frame, x, y, w; missing: h"),
        ("x,y,w,h\n", "missing: frame"),
        ("frame,w,h\n", "missing: x, y"),
        ("1,2,3,4,5\n", "expected a header line"),
        ("frame,x,y,w,h\n1,2,3,4,5\n1,2,3,4\n", "line 3: expected 5 fields .* found 4"),
        ("frame,x,y,w,h\n\n1,2,wide,4,5\n", "line 3: expected a number as y, found 'wide'"),
        ("frame,x,y,w,h\n1,1_0,3,4,5\n", "line 2: expected a number as x, found '1_0'"),
        ("frame,x,y,w,h\n1.5,2,3,4,5\n", "line 2: expected a whole number as frame, found 1.5"),
        ("frame,x,y,w,h\n,2,3,4,5\n", "line 2: expected a whole number as frame"),
        ("frame,x,y,w,h,ignore\n1,2,3,4,5,maybe\n", "line 2: expected 0, 1, true or false"),
        ("frame,x,y,w,h,recording\n1,2,3,4,5,\n", "line 2: expected the name of a recording"),
        ("file,x,y,w,h\nI7.png,2,3,4,5\nleft.png,2,3,4,5\n", "line 3: expected a frame number"),
        ('frame,x,y,w,h\n1,2,3,4,"5\n', "drive.csv"),
        ("x" * 200_000 + "\n", "expected a header line"),
        (b"frame,x,y,w,h\n\xff\xfe\n", "line 2: expected UTF-8 text"),
    ],
)
def test_a_fault_is_named_with_its_line(read_text, text, message):
    with pytest.raises(FormatError, match=message):
        read_text(text)


def test_files_with_a_recording_column_may_share_recordings():
    (file,) = golden("csv", "truth.csv")
    sources = [SourceFile(file.path, name) for name in ("a/one.csv", "b/two.csv")]
    reading = csv.read(sources, ReadOptions())
    assert reading.boxes["file"].tolist() == [0] * 4 + [1] * 4
    assert reading.recordings["name"].tolist() == ["urban", "rural"]


def test_files_are_recordings_of_their_names(tmp_path):
    text = "frame,x,y,w,h\n1,2,3,4,5\n"
    files = [source(tmp_path, text, f"{name}.csv") for name in ("urban", "rural")]
    assert csv.read(files, ReadOptions()).boxes["recording"].tolist() == ["urban", "rural"]
    with pytest.raises(InputError, match="one file per recording"):
        csv.read([source(tmp_path, text, "a/gt.csv")] * 2, ReadOptions())


def test_classes_are_sorted_over_all_files_not_file_by_file(tmp_path):
    files = [
        source(tmp_path, f"frame,x,y,w,h,class\n1,2,3,4,5,{kind}\n", f"{kind}.csv")
        for kind in ("person", "cyclist")
    ]
    reading = csv.read(files, ReadOptions())
    assert reading.boxes["ignore"].tolist() == [False, True]
    assert "person counted; cyclist ignored" in reading.conversion


def test_a_single_class_of_lookalikes_does_not_count(read_text):
    text = "frame,x,y,w,h,class\n1,2,3,4,5,crowd\n"
    with pytest.raises(FormatError, match=r"no category is called person.*found crowd; name the"):
        read_text(text)
    assert "class 7 throughout: counted" in read_text(text.replace("crowd", "7")).conversion


def test_a_score_column_in_the_truth_looks_like_swapped_files(read_text):
    text = "frame,x,y,w,h,score\n1,2,3,4,5,0.5\n"
    only_finding(read_text(text), "truth-with-scores")
    assert read_text(text, role="detections").findings == ()


@pytest.mark.parametrize(
    ("column", "role", "meant"),
    [
        ("Detectabilty", "truth", "detectability"),
        ("scores", "detections", "score"),
        ("scores", "truth", None),  # the truth needs none
        ("detectabilty", "detections", None),
        ("speed", "truth", None),
    ],
)
def test_a_column_whose_name_is_nearly_that_of_a_missing_one_is_named(
    read_text, column: str, role: str, meant: str | None
):
    text = f"frame,x,y,w,h,{column}\n1,2,3,4,5,0.5\n"
    reading = read_text(text, role=role)
    assert f"columns left unused: {column}" in reading.conversion
    if meant is None:
        assert not reading.findings
    else:
        finding = only_finding(reading, "misspelt-column")
        assert f"The column {column} is left unused; {meant}, which it may be" in finding.message


def test_an_unused_column_beside_the_one_it_resembles_is_no_finding(read_text):
    text = "frame,x,y,w,h,score,scores\n1,2,3,4,5,0.5,0.4\n"
    assert not read_text(text, role="detections").findings


ATTRIBUTES = """frame,x,y,w,h,track,attributes
1,2,3,4,5,1,child
2,2,3,4,5,1,
3,2,3,4,5,1,NA
4,2,3,4,5,1,child;dog
"""


def test_attributes_of_the_truth_are_kept_with_file_and_line(read_text):
    reading = read_text(ATTRIBUTES)
    assert "attributes as classes of encounters" in reading.conversion
    assert rows(reading.attributes, "file line attributes") == [
        [0, 2, "child"],
        [0, 5, "child;dog"],
    ]
    assert reading.attributes["attributes"].cat.categories.tolist() == ["child", "child;dog"]
    assert read_text("frame,x,y,w,h\n1,2,3,4,5\n").attributes is None


def test_attributes_of_detections_are_left_unused(read_text):
    reading = read_text(ATTRIBUTES, role="detections")
    assert reading.attributes is None
    assert "columns left unused: attributes" in reading.conversion


def test_attributes_of_several_files_are_joined(tmp_path: Path):
    first = source(tmp_path, ATTRIBUTES, "a.csv")
    plain = source(tmp_path, "frame,x,y,w,h\n1,2,3,4,5\n", "b.csv")
    last = source(tmp_path, "frame,x,y,w,h,attribute\n7,2,3,4,5,pram\n", "c.csv")
    reading = csv.read([first, plain, last], ReadOptions())
    assert rows(reading.attributes, "file line attributes")[-1] == [2, 2, "pram"]
    assert len(reading.attributes) == 3


@pytest.mark.parametrize(("fault", "words"), [("1,x,1,9,9", "a number as x"), ("1,1", "5 fields")])
def test_a_fault_behind_many_lines_is_named_by_its_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str, words: str
):
    monkeypatch.setattr("nvcore.inputs.readers.parse.text._ODD_BLOCK", 100)
    rows = [f"{row},1,1,9,9" for row in range(50)]
    file = source(tmp_path, "\n".join(["frame,x,y,w,h", *rows, fault, *rows]), "a.csv")
    with pytest.raises(FormatError, match=rf"a\.csv, line 52: expected {words}"):
        csv.read([file], ReadOptions())
