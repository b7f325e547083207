"""What the command line proposes where something is missing or called by another name."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from inputs import flags, mot_layout, nvcore, write
from PIL import Image
from places import DATA, SAMPLE

from nvcore.common.errors import UnknownFormatError
from nvcore.inputs.readers import format_named
from nvcore.inputs.session.proposals import looks_like


@pytest.mark.parametrize(
    ("command", "given", "advice"),
    [
        ("check", "A/gt/gt.txt", "MOTChallenge: use --truth A/gt/gt.txt, with the detections as "
         "--x FILE\n"),
        ("compare", ".", "MOTChallenge: use --truth ., with the detections as --x FILE and "
         "--y FILE\n"),
        ("gate", "results.json", "COCO results: use --x results.json, with the ground truth as "
         "--truth FILE\n"),
    ],
)  # fmt: skip
def test_annotations_in_place_of_a_session_say_by_which_flag_they_are_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, given: str, advice: str
):
    monkeypatch.chdir(mot_layout(tmp_path))
    if given == "results.json":
        shutil.copy(DATA / "coco" / "results.json", given)
    more = ("--rule", "saliency_x < 1") if command == "gate" else ()
    result = nvcore(command, given, *more)
    assert result.exit_code == 2
    assert f"{given} is no session file (TOML): it looks like {advice}" in result.stderr


def test_another_file_in_place_of_a_session_is_named_by_its_kind(tmp_path: Path):
    shutil.copy(SAMPLE.parent / "odd_pose.mp4", tmp_path / "a.toml")
    result = nvcore("check", tmp_path / "a.toml")
    assert result.exit_code == 2
    assert "is no session file (TOML): it is an MP4 video" in result.stderr


def test_a_session_with_a_slip_keeps_its_own_error(tmp_path: Path):
    result = nvcore("check", write(tmp_path / "session.toml", "[truth]", "path = truth.csv"))
    assert "session.toml: is not TOML: Invalid value (at line 2" in result.stderr


def test_what_may_be_both_looks_like_ground_truth_and_a_folder_of_nothing_like_nothing(
    tmp_path: Path,
):
    file_format, role = looks_like(DATA / "mot" / "MOT16-02" / "det" / "det.txt")
    assert (file_format.name, role) == ("mot", "truth")
    assert looks_like(tmp_path) is None
    assert looks_like(write(tmp_path / "empty.txt", "")) is None


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("COCO_result", "did you mean 'coco-results'. The formats are bbgt "),
        ("kitty-tracking", "did you mean 'kitti-tracking'. The formats are bbgt "),
        ("sqlite", "; the formats are bbgt .*, mot .MOTChallenge., .*, voc .Pascal VOC., "),
    ],
)
def test_an_unknown_format_lists_all_with_their_titles(name: str, told: str):
    with pytest.raises(UnknownFormatError, match=told):
        format_named(name)


def test_a_missing_size_proposes_that_of_kitti():
    truth, x = DATA / "kitti_tracking" / "0016.txt", DATA / "kitti_detections" / "ab3dmot.txt"
    result = nvcore("check", "--truth", truth, "--x", x, "--fps", 10)
    assert result.exit_code == 2
    assert ". Give --size WIDTHxHEIGHT. Usual in KITTI: " in result.stderr
    assert " Usual in KITTI: --size 1242x375 (some of its recordings have " in result.stderr
    result = nvcore("check", "--truth", truth, "--x", x, "--size", "1242x375")
    assert result.stderr.endswith(". Usual in KITTI: --fps 10\n")


@pytest.mark.parametrize("command", ["check", "compare"])
def test_a_missing_size_and_rate_propose_those_of_the_recordings_video(folder: Path, command: str):
    video = SAMPLE.parent / "odd_pose.mp4"
    table = write(folder / "table.csv", "recording,pictures", f"urban,{video}", "rural,no.mp4")
    files = [part for part in flags(folder) if part not in ("--size", "640x480", "--fps", "20")]
    result = nvcore(command, *files, "--recordings", table)
    assert result.exit_code == 2
    assert f". The pictures {video} have --size 640x480 and --fps 20\n" in result.stderr
    # what it proposes is enough
    assert nvcore(command, *flags(folder)).exit_code == 0


def test_still_pictures_propose_their_size_and_no_rate(folder: Path):
    stills = folder / "stills"
    stills.mkdir()
    Image.new("L", (640, 512)).save(stills / "000001.png")
    table = write(folder / "table.csv", "recording,pictures", f"urban,{stills}")
    files = [part for part in flags(folder) if part not in ("--size", "640x480", "--fps", "20")]
    result = nvcore("check", *files, "--recordings", table)
    assert result.exit_code == 2
    assert f". The pictures {stills} have --size 640x512\n" in result.stderr
