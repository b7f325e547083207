"""Which recording and which frame a file belongs to."""

from __future__ import annotations

import pytest

from nvcore.errors import InputError
from nvcore.inputs.readers.meaning.names import recording_and_frame_of, recording_of, recordings_of


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


def test_a_known_recording_in_the_path_wins_over_nearer_folders():
    name = "mot15/TUD-Campus/det_frcnn/det.txt"
    assert recording_of(name, known=("TUD-Campus", "PETS")) == "TUD-Campus"


def test_parts_of_the_path_name_a_known_recording_together():
    known = ("set06/V000", "set07/V000")
    assert recording_of("MBNet/set07/V000.txt", known) == "set07/V000"
    assert recording_of("MBNet/set06_V000.txt", known) == "set06/V000"


def test_the_longest_known_recording_at_the_same_place_wins():
    assert recording_of("a/set06/V000.txt", ("V000", "set06/V000")) == "set06/V000"


def test_without_a_known_recording_in_the_path_the_own_name_stays():
    assert recording_of("other/PETS.txt", known=("TUD-Campus",)) == "PETS"


def test_what_the_data_state_wins_over_an_unknown_name():
    names, facts = recordings_of(["a/gt.txt"], ("TUD-Campus", "PETS"), stated=["PETS"])
    assert names == ["PETS"]
    assert facts == []


def test_a_known_recording_in_the_path_wins_over_what_the_data_state():
    names, _ = recordings_of(["PETS.txt"], ("TUD-Campus", "PETS"), stated=["TUD-Campus"])
    assert names == ["PETS"]


def test_the_only_file_is_taken_for_the_only_recording_and_that_is_said():
    names, facts = recordings_of(["system_x.txt"], ("drive",))
    assert names == ["drive"]
    assert facts == ["the only file taken for the only recording, 'drive'"]


def test_the_only_file_is_not_taken_for_a_recording_that_its_data_contradict():
    names, facts = recordings_of(["system_x.txt"], ("drive",), stated=["other"])
    assert (names, facts) == (["other"], [])


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
    known = ("set06/V000", "set07/V000")
    assert recording_and_frame_of("out/yolo/set07/V000/I00019.txt", known) == ("set07/V000", 19)
    assert recording_and_frame_of("yolo/set06_V000_I00019.txt", known) == ("set06/V000", 19)
