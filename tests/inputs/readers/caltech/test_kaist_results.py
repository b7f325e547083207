"""KAIST results by image number and Caltech detections by frame."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from reader_files import golden, rows, source

from nvcore.common.errors import FormatError, InputError, MissingFactError
from nvcore.common.findings import Severity
from nvcore.inputs.readers.base import Reading, ReadOptions
from nvcore.inputs.readers.caltech import read_results as read

RECORDINGS = ("set06/V000", "set06/V001")
IMAGES = pd.DataFrame(
    {"recording": [RECORDINGS[i] for i in (0, 0, 1)], "frame": [19, 39, 19], "image_id": [0, 1, 2]}
)


def options(**changes: object) -> ReadOptions:
    return ReadOptions(
        **{"role": "detections", "recordings": RECORDINGS, "images": IMAGES, **changes}
    )


def read_golden(name: str, **changes: object) -> Reading:
    return read(golden("kaist_results", name), options(**changes))


def read_text(folder: Path, text: str, name: str = "MBNet_result.txt", **changes: object):
    return read([source(folder, text, name)], options(**changes))


def test_the_image_number_is_the_position_in_the_list_of_the_truth():
    # Image and annotation ids begin at 0 on KAIST
    reading = read_golden("MBNet_result.txt")
    assert rows(reading.boxes, "recording frame line") == [
        ["set06/V000", 19, 1],
        ["set06/V001", 19, 2],
        ["set06/V001", 19, 3],
    ]
    assert rows(reading.boxes[:1], "x y w h score") == [
        [502.33, 212.455, 19.922, 41.648, 0.03658492]
    ]
    assert "1-based position in the truth's image list" in reading.conversion


def test_the_recordings_are_all_of_the_list_with_or_without_detections(tmp_path):
    for text in ("1,1,2,3,4,0.5\n", ""):
        reading = read_text(tmp_path, text)
        assert reading.recordings["name"].tolist() == list(RECORDINGS)
        assert (len(reading.boxes), reading.findings) == (len(text.split()), ())


@pytest.mark.parametrize(
    ("changes", "frames"),
    [({}, [0, 29]), ({"frame_base": 0}, [1, 30]), ({"images": None, "recordings": ()}, [0, 29])],
    ids=["counted from 1", "declared to count from 0", "without truth"],
)
def test_caltech_frames_become_the_numbers_of_the_pictures(changes, frames):
    reading = read_golden("set06/V000.txt", **changes)
    assert rows(reading.boxes, "recording frame") == [["set06/V000", frame] for frame in frames]
    is_moved = "frames from 1-based to 0-based" in reading.conversion
    assert is_moved == (frames == [0, 29])


def test_a_folder_called_like_a_recording_does_not_make_a_result_file_a_recording(tmp_path):
    facts = {"recordings": ("kaist",), "images": IMAGES.assign(recording="kaist")}
    boxes = read_text(tmp_path, "2,1,2,3,4,0.5\n", "kaist/MBNet.txt", **facts).boxes
    assert boxes["frame"].tolist() == [39]


def test_results_by_image_number_without_a_list_ask_for_the_truth():
    with pytest.raises(MissingFactError, match="the truth's image list is needed"):
        read_golden("MBNet_result.txt", images=None)


def test_an_image_number_off_the_list_is_an_error_finding_and_its_row_is_kept_out(tmp_path):
    reading = read_text(tmp_path, "1,1,2,3,4,0.5\n0,1,2,3,4,0.5\n9,1,2,3,4,0.5\n")
    (finding,) = reading.findings
    assert (finding.severity, finding.count) == (Severity.ERROR, 2)
    assert finding.example == "line 2: image number 0"
    assert reading.boxes["line"].tolist() == [1]


def test_a_truth_of_a_part_of_the_set_keeps_the_ids_of_the_whole(tmp_path):
    night = IMAGES.assign(image_id=[1455, 1456, 1457])
    reading = read_text(tmp_path, "1457,1,2,3,4,0.5\n3,1,2,3,4,0.5\n", images=night)
    assert reading.boxes["frame"].tolist() == [39]
    assert "image number = image id + 1" in reading.conversion
    assert reading.findings[0].example == "line 2: image number 3"


def test_two_files_of_one_recording_are_an_error(tmp_path):
    files = [source(tmp_path, "", f"{folder}/set06/V000.txt") for folder in ("a", "b")]
    with pytest.raises(InputError, match="holds recording 'set06/V000', as a/set06"):
        read(files, options())


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,2,3,4,5", "expected 6 fields"),
        ("1.5,2,3,4,5,6", "expected a whole number as image number or frame"),
        ("1,2,3,4,5,high", "expected numbers .*found 'high'"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"MBNet_result\.txt, line 2: {words}"):
        read_text(tmp_path, f"1,1,2,3,4,0.5\n{row}\n")
