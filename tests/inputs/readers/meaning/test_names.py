"""Which recording and which frame a file belongs to."""

from __future__ import annotations

import pytest

from nvcore.common.errors import InputError
from nvcore.inputs.readers.meaning.names import recording_and_frame_of, recording_of, recordings_of

SETS = ("set06/V000", "set07/V000")


@pytest.mark.parametrize(
    ("name", "recording"),
    [
        ("mot15/TUD-Campus/gt/gt.txt", "TUD-Campus"),
        ("gt/TUD-Campus.txt", "TUD-Campus"),
        ("TUD-Campus.txt", "TUD-Campus"),
        ("gt.txt", "gt"),
        ("/gt/gt.txt", "gt"),
        ("../../gt.txt", "gt"),
    ],
)
def test_the_nearest_part_that_is_no_neutral_word_names_the_recording(name, recording):
    assert recording_of(name) == recording


@pytest.mark.parametrize(
    ("name", "known", "recording"),
    [
        # wins over nearer folders
        ("mot15/TUD-Campus/det_frcnn/det.txt", ("TUD-Campus", "PETS"), "TUD-Campus"),
        # parts of the path together
        ("MBNet/set07/V000.txt", SETS, "set07/V000"),
        ("MBNet/set06_V000.txt", SETS, "set06/V000"),
        # the longest at the same place
        ("a/set06/V000.txt", ("V000", "set06/V000"), "set06/V000"),
        # not in the path
        ("other/PETS.txt", ("TUD-Campus",), "PETS"),
    ],
)
def test_a_known_recording_in_the_path_is_taken(name, known, recording):
    assert recording_of(name, known) == recording


ASSUMED = ["the only file taken for the only recording, 'drive'"]


@pytest.mark.parametrize(
    ("name", "known", "stated", "recording", "facts"),
    [
        ("a/gt.txt", ("TUD-Campus", "PETS"), ["PETS"], "PETS", []),
        ("PETS.txt", ("TUD-Campus", "PETS"), ["TUD-Campus"], "PETS", []),
        ("system_x.txt", ("drive",), None, "drive", ASSUMED),
        ("system_x.txt", ("drive",), ["other"], "other", []),
    ],
    ids=[
        "stated beside an unknown name",
        "a known name wins over what is stated",
        "the only file and the only recording",
        "contradicted by the data",
    ],
)
def test_the_recording_is_told_by_name_data_and_number(name, known, stated, recording, facts):
    assert recordings_of([name], known, stated=stated) == ([recording], facts)


def test_two_files_of_one_recording_are_an_error():
    with pytest.raises(InputError, match=r"b/A/gt\.txt: holds recording 'A', as a/A/gt\.txt does"):
        recordings_of(["a/A/gt.txt", "b/A/gt.txt"])


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("set06/V000/I00019.txt", ("set06/V000", 19)),
        ("set06_V000_I00019.txt", ("set06_V000", 19)),
        ("labels/0016_000007.png", ("0016", 7)),
        ("000012.txt", ("recording", 12)),
        ("label_2/000012.txt", ("recording", 12)),
        ("a/frame_0003.txt", ("a", 3)),
        ("a/FRAME-0003.txt", ("a", 3)),
        ("a/video3.txt", ("a/video", 3)),
        ("/../a/f7.txt", ("a", 7)),
    ],
)
def test_the_number_at_the_end_is_the_frame_and_the_rest_the_recording(name, expected):
    assert recording_and_frame_of(name) == expected


@pytest.mark.parametrize("name", ["a/readme.txt", "a/I00019_lwir.txt", "a/" + "9" * 30 + ".txt"])
def test_a_name_without_a_usable_number_has_no_frame(name):
    assert recording_and_frame_of(name) is None


def test_a_frame_finds_its_known_recording_behind_other_folders():
    assert recording_and_frame_of("out/yolo/set07/V000/I00019.txt", SETS) == ("set07/V000", 19)
    assert recording_and_frame_of("yolo/set06_V000_I00019.txt", SETS) == ("set06/V000", 19)
