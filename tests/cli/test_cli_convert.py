"""nvcore convert and nvcore sample."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from inputs import FACTS, drive, mot_layout, nvcore, write
from places import DATA, ROOT, SAMPLE

TRUTH = DATA / "csv" / "truth.csv"
"""Of the recordings urban and rural."""


def convert(source: Path, target: Path, to: str, *more: object, exit_code: int = 0) -> str:
    """What ``nvcore convert`` says; all of it goes to standard error."""
    result = nvcore("convert", source, target, "--to", to, *more)
    assert result.exit_code == exit_code, result.output
    assert result.stdout == ""
    return result.stderr


@pytest.mark.parametrize("to", ["csv", "parquet", "coco", "mot"])
def test_truth_converts_to_each_format_and_back(tmp_path: Path, to: str):
    target = tmp_path / f"A.{'json' if to == 'coco' else 'csv'}"
    source = DATA / "kitti_tracking" / "0016.txt"
    assert f"written to {target}: 4 boxes" in convert(source, target, to, "--size", "1224x370")
    convert(target, tmp_path / "again.csv", "csv")
    rows = (tmp_path / "again.csv").read_text().splitlines()
    assert len(rows) == 5
    assert "100,150,20,50" in rows[2]


@pytest.mark.parametrize(
    ("name", "start"),
    [("a.csv", b"recording,frame"), ("a.parquet", b"PAR1"), ("a.json", b'{"videos"'),
     ("a.txt", b"0,-1,535.9"), ("a.csv.gz", b"\x1f\x8b\x08"), ("a.json.zst", b"\x28\xb5\x2f\xfd"),
     ("a.txt.xz", b"\xfd7zXZ"), ("a.CSV.BZ2", b"BZh9")],
)  # fmt: skip
def test_the_name_of_the_output_tells_its_format_and_how_it_is_packed(
    tmp_path: Path, name: str, start: bytes
):
    source, target = DATA / "kitti_tracking" / "0016.txt", tmp_path / name
    result = nvcore("convert", source, target, "--size", "1224x370")
    assert result.exit_code == 0, result.output
    assert target.read_bytes()[: len(start)] == start
    again = nvcore("convert", target, tmp_path / "again.csv")
    assert again.exit_code == 0, again.output
    assert "100,150,20,50" in (tmp_path / "again.csv").read_text()


def test_a_name_that_tells_no_format_asks_for_it(tmp_path: Path):
    result = nvcore("convert", DATA / "kitti_tracking" / "0016.txt", tmp_path / "out.gz")
    assert result.exit_code == 2
    assert "the name does not tell the format to write" in result.stderr
    assert "name it: csv, parquet, coco, mot" in result.stderr


def test_results_that_name_pictures_by_number_need_the_truth(tmp_path: Path):
    source = DATA / "kaist_results" / "MBNet_result.txt"
    arguments = (source, tmp_path / "out.json", "coco", "--role", "detections")
    convert(*arguments, exit_code=2)
    convert(*arguments, "--truth", DATA / "coco" / "kaist.json")
    # picture number 1 is the image of id 0, number 3 that of id 2
    written = json.loads((tmp_path / "out.json").read_text())
    assert [record["image_id"] for record in written] == [0, 2, 2]


def test_the_conversion_and_oddities_of_the_input_are_told(tmp_path: Path):
    mot = DATA / "mot" / "MOT16-02" / "gt" / "gt.txt"
    assert "pixels from 1-based to 0-based" in convert(mot, tmp_path / "a.csv", "csv")
    odd = write(tmp_path / "I00019.txt", "% bbGt version=3", "person 1 2 20 50 0 0 0 0 0 0 45")
    assert "warning truth: " in convert(odd, tmp_path / "b.csv", "csv")


# what is asked before something is lost


@pytest.mark.parametrize("name", ["fir.csv", "A/det/det.txt"])
def test_an_input_with_scores_needs_a_role(tmp_path: Path, name: str):
    mot_layout(drive(tmp_path))
    target = tmp_path / "a.json"
    text = convert(tmp_path / name, target, "coco", exit_code=2)
    assert "this has scores, as detections have" in text
    assert text.endswith(". Give --role detections, or give --role truth.\n")
    assert not target.exists()


def test_scores_are_left_out_where_the_role_is_truth(tmp_path: Path):
    source, target = drive(tmp_path) / "fir.csv", tmp_path / "a.csv"
    assert "score column, which is left unused" in convert(source, target, "csv", "--role", "truth")
    assert "score" not in target.read_text()


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("no.csv", None, "no.csv: there is no such file or folder"),
        ("gt.txt", "1,1,1,1,9,9,1,1,1\n" * 30 + "1.5,1,1,1,9,9,1,1,1",
         "line 31: expected a whole number as frame, found 1.5"),
        ("r.json", '[{"image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5}]',
         "r.json: this holds detections, not ground truth. Give --role detections."),
    ],
)  # fmt: skip
def test_what_is_wrong_with_the_input_is_told(
    tmp_path: Path, name: str, text: str | None, words: str
):
    if text is not None:
        (tmp_path / name).write_text(text)
    assert words in convert(tmp_path / name, tmp_path / "out.csv", "csv", exit_code=2)


def test_an_output_that_exists_is_kept_unless_forced(tmp_path: Path):
    target = write(tmp_path / "a.csv", "mine")
    message = "a.csv: exists; give another file to write. Give --force."
    assert message in convert(TRUTH, target, "csv", exit_code=2)
    assert target.read_text() == "mine\n"
    convert(TRUTH, target, "csv", "--force")
    assert target.read_text() != "mine\n"


@pytest.mark.parametrize("is_link", [False, True])
def test_the_input_is_never_written_over(tmp_path: Path, is_link: bool):
    target = source = drive(tmp_path) / "truth.csv"
    before = source.read_bytes()
    if is_link:
        target = tmp_path / "link.csv"
        target.hardlink_to(source)
    message = "is the input; give another file to write"
    assert message in convert(source, target, "csv", "--force", exit_code=2)
    assert source.read_bytes() == before


def test_one_file_that_exists_keeps_all_from_being_written(tmp_path: Path):
    out = tmp_path / "out"
    mine = write(out / "rural.txt", "mine")
    convert(TRUTH, out, "mot", exit_code=2)
    assert [path.name for path in out.iterdir()] == ["rural.txt"]
    mine.unlink()
    assert "2 files in" in convert(TRUTH, out, "mot")
    assert {path.name for path in out.iterdir()} == {"urban.txt", "rural.txt"}


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
    text = convert(kaist(tmp_path), tmp_path / "out", to)
    assert f"9 of 11 evaluated frames have no box, and {to} cannot list frames" in text
    assert "by itself, 3 frames are evaluated\nGive --frames-out PATH.\n" in text


def test_single_frames_that_come_back_with_those_between_are_counted(tmp_path: Path):
    scenes = write(tmp_path / "gt.txt", "00003.ppm;1;2;9;9;1\n00009.ppm;1;2;9;9;2\n")
    write(tmp_path / "scenes.txt", "00003.ppm\n00009.ppm\n")
    text = convert(scenes, tmp_path / "a.csv", "csv", "--objects", "speed sign")
    assert "the 2 evaluated frames do not follow one another, and csv cannot list frames" in text
    assert "by itself, 7 frames are evaluated" in text


def test_frames_that_would_be_told_again_need_no_warning(tmp_path: Path):
    text = convert(drive(tmp_path) / "truth.csv", tmp_path / "a", "mot")
    assert "warning" not in text.replace("frame 1", "")


def test_frame_lists_that_differ_are_a_folder_with_a_part_of_a_session_file(tmp_path: Path):
    lists = tmp_path / "lists"
    text = convert(kaist(tmp_path), tmp_path / "a.csv", "csv", "--frames-out", lists)
    assert "write the list too" not in text
    assert "copy recordings.toml there into a session file" in text
    assert (lists / "A.txt").read_text() == "0\n1\n2\n3\n4\n"
    write(lists / "fir.csv", "frame,x,y,w,h,score,recording", "1,1,2,30,60,0.5,A")
    session = write(
        lists / "session.toml", '[truth]\npath = "../a.csv"',
        '[defaults]\nsize = "640x480"\nfps = 20', (lists / "recordings.toml").read_text(),
        '[[system]]\npath = "fir.csv"',
    )  # fmt: skip
    assert "evaluated frames of 2 recordings: as the session says (11 in all)" in (
        nvcore("check", session).stdout
    )


def test_one_frame_list_of_all_recordings_is_a_file_for_the_flag_frames(tmp_path: Path):
    source, frames = mot_layout(tmp_path / "in"), tmp_path / "frames.txt"
    text = convert(source, tmp_path / "a.csv", "csv", "--frames-out", frames)
    assert f"give it as --frames {frames}" in text
    assert "2 of 10 evaluated frames have no box" in text
    again = nvcore("check", "--truth", tmp_path / "a.csv", "--x", source, "--name-x", "X", *FACTS,
                   "--frames", frames)  # fmt: skip
    assert "(10 in all)" in again.stdout, again.output


@pytest.mark.parametrize(("to", "exit_code"), [("csv", 0), ("coco", 2)])
def test_frame_numbers_that_are_times_are_told_and_only_a_frame_list_fails(
    tmp_path: Path, to: str, exit_code: int
):
    rows = [f"{frame},1,2,30,60" for frame in (1, 10**12)]
    source = write(tmp_path / "a.csv", "frame,x,y,w,h", *rows)
    text = convert(source, tmp_path / "b", to, "--size", "640x480", exit_code=exit_code)
    assert "the truth reaches from frame 1 to 1000000000000" in text
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
    source = write(drive(tmp_path) / "empty.csv", "frame,x,y,w,h").with_name(name)
    frames = tmp_path / "frames.txt"
    if name == "truth.csv":
        write(frames, "mine")
    more = (*more, "--frames-out", frames)
    assert words in convert(source, tmp_path / "a.csv", "csv", *more, exit_code=2)
    assert not frames.exists() or frames.read_text() == "mine\n"


def test_coco_lists_frames_without_boxes_between_annotated_ones(tmp_path: Path):
    rows = [f"{frame},1,2,30,60" for frame in (3, 6)]
    convert(write(tmp_path / "a.csv", "frame,x,y,w,h", *rows), tmp_path / "a.json", "coco")
    images = json.loads((tmp_path / "a.json").read_text())["images"]
    assert [(image["id"], image["frame_index"]) for image in images] == [
        (1, 3),
        (2, 4),
        (3, 5),
        (4, 6),
    ]


def test_a_given_size_is_written_to_coco_which_needs_it(tmp_path: Path):
    arguments = (drive(tmp_path) / "truth.csv", tmp_path / "a.json", "coco")
    text = convert(*arguments)
    assert "the image size of 2 of 2 recordings is not known" in text
    assert "\nGive --size WIDTHxHEIGHT.\n" in text
    assert "warning" not in convert(*arguments, "--size", "640x480", "--force")
    document = json.loads((tmp_path / "a.json").read_text())
    entries = [*document["images"], *document["videos"]]
    assert {(entry["width"], entry["height"]) for entry in entries} == {(640, 480)}


def test_a_given_size_that_contradicts_the_data_is_told_and_not_written(tmp_path: Path):
    source, target = mot_layout(tmp_path / "in"), tmp_path / "a.json"
    assert "another size than the given one for 2 of 2 recordings; theirs is written" in (
        convert(source, target, "coco", "--size", "10x10")
    )
    assert {image["width"] for image in json.loads(target.read_text())["images"]} == {640}


@pytest.mark.parametrize(
    "arguments", [("convert", TRUTH, "file/a.csv", "--to", "csv"), ("sample", "file/s")]
)
def test_an_output_that_cannot_be_written_gives_exit_code_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple
):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "file", "")
    result = nvcore(*arguments)
    assert result.exit_code == 2
    assert "cannot be written" in result.stderr


def test_sample_copies_every_file_and_over_older_ones(tmp_path: Path):
    target = tmp_path / "night" / "s"
    write(target / "truth.csv", "old")
    result = nvcore("sample", target)
    assert (result.exit_code, result.stdout) == (0, "")
    assert result.stderr == f"written to {target}\n"
    assert contents(target) == contents(SAMPLE.parent)


def contents(folder: Path) -> dict[Path, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder): path.read_bytes() for path in files}


def test_sample_does_not_copy_a_folder_onto_itself(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(ROOT)
    result = nvcore("sample")
    assert result.exit_code == 2
    assert "sample_data: is the folder that would be copied; give another one" in result.stderr
