"""nvcore convert and nvcore sample."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import pytest
from inputs import FACTS, drive, mot_layout, nvcore, write
from places import DATA

import nvcore.sample as nvcore_sample
from nvcore.cli import _Steps


@pytest.mark.parametrize("to", ["csv", "coco", "mot"])
def test_truth_converts_to_each_format_and_back(tmp_path: Path, to: str):
    target = tmp_path / f"A.{'json' if to == 'coco' else 'csv'}"
    result = nvcore("convert", DATA / "kitti_tracking" / "0016.txt", target, "--to", to,
                    "--size", "1224x370")  # fmt: skip
    assert result.exit_code == 0, result.output
    assert f"written to {target}: 4 boxes" in result.stderr
    again = nvcore("convert", target, tmp_path / "again.csv", "--to", "csv")
    assert again.exit_code == 0, again.output
    rows = (tmp_path / "again.csv").read_text().splitlines()
    assert len(rows) == 5
    assert "100,150,20,50" in rows[2]


def test_results_that_name_pictures_by_number_need_the_truth(tmp_path: Path):
    source = DATA / "kaist_results" / "MBNet_result.txt"
    arguments = (source, tmp_path / "out.json", "--to", "coco", "--role", "detections")
    assert nvcore("convert", *arguments).exit_code == 2
    result = nvcore("convert", *arguments, "--truth", DATA / "coco" / "kaist.json")
    assert result.exit_code == 0, result.output
    # picture number 1 is the image of id 0, number 3 that of id 2
    written = json.loads((tmp_path / "out.json").read_text())
    assert [one["image_id"] for one in written] == [0, 2, 2]


def test_the_conversion_and_oddities_of_the_input_are_told(tmp_path: Path):
    result = nvcore("convert", DATA / "mot" / "MOT16-02" / "gt" / "gt.txt", tmp_path / "a.csv",
                    "--to", "csv")  # fmt: skip
    assert "pixels from 1-based to 0-based" in result.stderr
    assert result.stdout == ""
    source = write(tmp_path / "I00019.txt", "% bbGt version=3", "person 1 2 20 50 0 0 0 0 0 0 45")
    result = nvcore("convert", source, tmp_path / "b.csv", "--to", "csv")
    assert result.exit_code == 0, result.output
    assert "warning truth: " in result.stderr


# what is asked before something is lost


@pytest.mark.parametrize("name", ["fir.csv", "det.txt"])
def test_an_input_with_scores_needs_a_role(tmp_path: Path, name: str):
    mot_layout(tmp_path)
    source = drive(tmp_path) / name if name == "fir.csv" else tmp_path / "A" / "det" / name
    result = nvcore("convert", source, tmp_path / "a.json", "--to", "coco")
    assert result.exit_code == 2
    assert "this has scores, as detections have; give --role detections" in result.stderr
    assert not (tmp_path / "a.json").exists()


def test_scores_are_left_out_where_the_role_is_truth(tmp_path: Path):
    folder = drive(tmp_path)
    result = nvcore("convert", folder / "fir.csv", tmp_path / "a.csv", "--to", "csv",
                    "--role", "truth")  # fmt: skip
    assert result.exit_code == 0, result.output
    assert "score" not in (tmp_path / "a.csv").read_text()
    assert "score column, which is left unused" in result.stderr


@pytest.mark.parametrize(
    ("name", "lines", "words"),
    [
        ("no.csv", None, "no.csv: there is no such file or folder"),
        ("gt.txt", ["1,1,1,1,9,9,1,1,1"] * 30 + ["1.5,1,1,1,9,9,1,1,1"],
         "line 31: expected a whole number as frame, found 1.5"),
        ("a.txt", [], "the file is empty; expected ground truth"),
        ("r.json", ['[{"image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5}]'],
         "r.json: this holds detections; give --role detections"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_the_input_is_told(
    tmp_path: Path, name: str, lines: list[str] | None, words: str
):
    if lines is not None:
        (tmp_path / name).write_text("\n".join(lines))
    result = nvcore("convert", tmp_path / name, tmp_path / "out.csv", "--to", "csv")
    assert result.exit_code == 2
    assert words in result.stderr


def test_an_output_that_exists_is_kept_unless_forced(tmp_path: Path):
    target = write(tmp_path / "a.csv", "mine")
    arguments = ("convert", DATA / "csv" / "truth.csv", target, "--to", "csv")
    result = nvcore(*arguments)
    assert result.exit_code == 2
    assert "a.csv: exists; give another file to write, or --force" in result.stderr
    assert target.read_text() == "mine\n"
    assert nvcore(*arguments, "--force").exit_code == 0
    assert target.read_text() != "mine\n"


@pytest.mark.parametrize("is_link", [False, True])
def test_the_input_is_never_written_over(tmp_path: Path, is_link: bool):
    source = drive(tmp_path) / "truth.csv"
    before = source.read_bytes()
    target = source
    if is_link:
        target = tmp_path / "link.csv"
        target.hardlink_to(source)
    result = nvcore("convert", source, target, "--to", "csv", "--force")
    assert result.exit_code == 2
    assert "is the input; give another file to write" in result.stderr
    assert source.read_bytes() == before


def test_one_file_that_exists_keeps_all_from_being_written(tmp_path: Path):
    arguments = ("convert", DATA / "csv" / "truth.csv", tmp_path / "out", "--to", "mot")
    mine = write(tmp_path / "out" / "rural.txt", "mine")
    assert nvcore(*arguments).exit_code == 2
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["rural.txt"]
    mine.unlink()
    assert "2 files in" in nvcore(*arguments).stderr
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"urban.txt", "rural.txt"}


# evaluated frames and sizes


def kaist(folder: Path) -> Path:
    """COCO truth of recordings A and B with frames 0 to 4; there are boxes in A's frames 1, 3."""
    images = [
        {"id": 5 * video + frame, "video_id": video, "frame_index": frame, "file_name": "a.png"}
        for video in (0, 1)
        for frame in range(5 + video)
    ]
    box = {"category_id": 1, "bbox": [1, 2, 30, 60]}
    document = {
        "videos": [{"id": 0, "name": "A"}, {"id": 1, "name": "B"}],
        "images": images,
        "annotations": [{"id": 1, "image_id": 1, **box}, {"id": 2, "image_id": 3, **box}],
        "categories": [{"id": 1, "name": "person"}],
    }
    return write(folder / "kaist.json", json.dumps(document))


@pytest.mark.parametrize("to", ["csv", "mot"])
def test_frames_that_the_format_cannot_list_are_counted(tmp_path: Path, to: str):
    result = nvcore("convert", kaist(tmp_path), tmp_path / "out", "--to", to)
    assert result.exit_code == 0, result.output
    assert f"9 of 11 evaluated frames have no box, and {to} cannot list frames" in result.stderr
    assert "by itself, 3 frames are evaluated; write the list too, with --frames-out" in (
        result.stderr
    )


def test_frame_lists_that_differ_are_a_folder_with_a_part_of_a_session_file(tmp_path: Path):
    result = nvcore("convert", kaist(tmp_path), tmp_path / "a.csv", "--to", "csv",
                    "--frames-out", tmp_path / "lists")  # fmt: skip
    assert "write the list too" not in result.stderr
    assert "copy recordings.toml there into a session file" in result.stderr
    assert (tmp_path / "lists" / "A.txt").read_text() == "0\n1\n2\n3\n4\n"
    write(tmp_path / "lists" / "fir.csv", "frame,x,y,w,h,score,recording", "1,1,2,30,60,0.5,A")
    names = (tmp_path / "lists" / "recordings.toml").read_text()
    session = write(
        tmp_path / "lists" / "session.toml", '[truth]\npath = "../a.csv"',
        '[defaults]\nsize = "640x480"\nfps = 20', names, '[[system]]\npath = "fir.csv"',
    )  # fmt: skip
    assert "evaluated frames of 2 recordings: as the session says (11 in all)" in (
        nvcore("check", session).stdout
    )


def test_one_frame_list_of_all_recordings_is_a_file_for_the_flag_frames(tmp_path: Path):
    source, frames = mot_layout(tmp_path / "in"), tmp_path / "frames.txt"
    result = nvcore("convert", source, tmp_path / "a.csv", "--to", "csv", "--frames-out", frames)
    assert f"give it as --frames {frames}" in result.stderr
    assert "2 of 10 evaluated frames have no box" in result.stderr
    again = nvcore("check", "--truth", tmp_path / "a.csv", "--x", source, "--name-x", "X", *FACTS,
                   "--frames", frames)  # fmt: skip
    assert "(10 in all)" in again.stdout, again.output


@pytest.mark.parametrize(("to", "exit_code"), [("csv", 0), ("coco", 2)])
def test_frame_numbers_that_are_times_are_told_and_only_a_frame_list_fails(
    tmp_path: Path, to: str, exit_code: int
):
    rows = [f"{frame},1,2,30,60" for frame in (1, 10**12)]
    source = write(tmp_path / "a.csv", "frame,x,y,w,h", *rows)
    result = nvcore("convert", source, tmp_path / "b", "--to", to, "--size", "640x480")
    assert result.exit_code == exit_code
    assert "the truth reaches from frame 1 to 1000000000000" in result.stderr
    assert (tmp_path / "b").exists() == (to == "csv")


@pytest.mark.parametrize(
    ("name", "more", "words"),
    [
        ("empty.csv", (), "there is no frame to list: the ground truth holds no box"),
        ("fir.csv", ("--role", "detections"), "--frames-out is for ground truth"),
        ("truth.csv", (), "frames.txt: exists"),
    ],
)
def test_a_frame_list_that_cannot_be_written_is_told(
    tmp_path: Path, name: str, more: tuple[str, ...], words: str
):
    write(drive(tmp_path) / "empty.csv", "frame,x,y,w,h")
    frames = tmp_path / "frames.txt"
    if name == "truth.csv":
        write(frames, "mine")
    result = nvcore("convert", tmp_path / name, tmp_path / "a.csv", "--to", "csv", *more,
                    "--frames-out", frames)  # fmt: skip
    assert result.exit_code == 2
    assert words in result.stderr
    assert not frames.exists() or frames.read_text() == "mine\n"


def test_frames_that_would_be_told_again_need_no_warning(tmp_path: Path):
    result = nvcore("convert", drive(tmp_path) / "truth.csv", tmp_path / "a", "--to", "mot")
    assert result.exit_code == 0
    assert "warning" not in result.stderr.replace("frame 1", "")


def test_coco_lists_frames_without_boxes_between_annotated_ones(tmp_path: Path):
    rows = [f"{frame},1,2,30,60" for frame in (3, 6)]
    source = write(tmp_path / "a.csv", "frame,x,y,w,h", *rows)
    nvcore("convert", source, tmp_path / "a.json", "--to", "coco")
    images = json.loads((tmp_path / "a.json").read_text())["images"]
    assert [(one["id"], one["frame_index"]) for one in images] == [(1, 3), (2, 4), (3, 5), (4, 6)]


def test_a_given_size_is_written_to_coco_which_needs_it(tmp_path: Path):
    arguments = ("convert", drive(tmp_path) / "truth.csv", tmp_path / "a.json", "--to", "coco")
    result = nvcore(*arguments)
    assert "the image size of 2 of 2 recordings is not known" in result.stderr
    assert "give --size WIDTHxHEIGHT" in result.stderr
    result = nvcore(*arguments, "--size", "640x480", "--force")
    assert "warning" not in result.stderr
    document = json.loads((tmp_path / "a.json").read_text())
    entries = [*document["images"], *document["videos"]]
    assert {(one["width"], one["height"]) for one in entries} == {(640, 480)}


def test_a_given_size_that_contradicts_the_data_is_told_and_not_written(tmp_path: Path):
    result = nvcore("convert", mot_layout(tmp_path / "in"), tmp_path / "a.json", "--to", "coco",
                    "--size", "10x10")  # fmt: skip
    assert "another size than --size for 2 of 2 recordings; theirs is written" in result.stderr
    images = json.loads((tmp_path / "a.json").read_text())["images"]
    assert {one["width"] for one in images} == {640}


@pytest.mark.parametrize(
    "arguments", [("convert", DATA / "csv" / "truth.csv", "file/a.csv", "--to", "csv"),
                  ("sample", "file/s")],
)  # fmt: skip
def test_an_output_that_cannot_be_written_gives_exit_code_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple
):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "file", "")
    result = nvcore(*arguments)
    assert result.exit_code == 2
    assert "cannot be written" in result.stderr


def test_sample_tells_its_progress_and_where_it_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def generate(folder: Path, *, progress) -> None:
        progress(0.25, "urban")
        progress(1.0, "")
        write(folder / "truth.csv", "frame")

    monkeypatch.setattr(nvcore_sample, "generate", generate)
    result = nvcore("sample", tmp_path / "s")
    assert result.stderr == f" 25% urban\nwritten to {tmp_path / 's'}\n"
    assert (tmp_path / "s" / "truth.csv").exists()


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("patience_s", "is_shown"), [(-1.0, True), (3600.0, False)])
def test_the_progress_bar_appears_only_when_the_work_takes_long(
    monkeypatch: pytest.MonkeyPatch, patience_s: float, is_shown: bool
):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(_Steps, "PATIENCE_S", patience_s)
    with _Steps(2) as steps:
        steps(0.0, "reading fir")
        steps.begin("analysing")
    assert ("analysing" in terminal.getvalue()) == is_shown


def test_the_progress_bar_is_finished_when_an_error_ends_the_work(
    monkeypatch: pytest.MonkeyPatch,
):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(_Steps, "PATIENCE_S", -1.0)
    steps = _Steps(5)

    def work() -> None:
        with steps:
            steps(0.0, "reading fir")
            raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        work()
    assert terminal.getvalue().endswith("\n")
    assert steps.bar.finished
