"""From paths to files, and what a system is called."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest
from inputs import mot_layout, write

from nvcore.common.errors import InputError
from nvcore.common.findings import Remedy, Step
from nvcore.inputs.files.find import digest, find_files, system_names
from nvcore.inputs.session import Source

DETECTION = "frame,x,y,w,h,score\n1,1,1,5,10,0.5"


def names(folder: Path, *paths: str, role: str = "truth", **options: object) -> list[str]:
    files, _ = find_files(Source(paths, **options), folder, role)  # type: ignore[arg-type]
    return [file.name for file in files]


TRUTHS = ["A/gt/gt.txt", "B/gt/gt.txt"]


@pytest.mark.parametrize(
    ("paths", "options", "expected"),
    [
        (["."], {}, TRUTHS),
        (["."], {"role": "detections"}, ["A/det/det.txt", "B/det/det.txt"]),
        (["."], {"format": "mot"}, TRUTHS),
        (["B"], {}, ["B/gt/gt.txt"]),
        (["*/gt/gt.txt"], {}, TRUTHS),
        (["B/gt/gt.txt", "A/gt/gt.txt", "*/gt/gt.txt"], {}, TRUTHS[::-1]),
    ],
    ids=["folder", "its detections", "format named", "one recording", "glob", "all of them once"],
)
def test_mot_layout_is_found_below_a_folder_with_brackets_in_its_name(
    tmp_path: Path, paths: list[str], options: dict[str, str], expected: list[str]
):
    assert names(mot_layout(tmp_path / "drive[1]"), *paths, **options) == expected


def test_a_file_that_was_named_is_read_whatever_its_ending_and_signs(tmp_path: Path):
    for name in ("rec[1].csv", "b.res"):
        write(tmp_path / name, DETECTION)
    listed = names(tmp_path, "rec[1].csv", "b.res", role="detections")
    assert [name.rpartition("/")[2] for name in listed] == ["rec[1].csv", "b.res"]


@pytest.mark.parametrize(
    ("files", "options", "expected"),
    [
        ({"a/V000/I00019.txt": "% bbGt version=3"}, {}, ["a/V000/I00019.txt"]),
        (
            {"a.csv": DETECTION, "README.txt": "about", ".cache/b.csv": "", ".b.csv": DETECTION},
            {"role": "detections"},
            ["a.csv"],
        ),
        (
            {"a.csv": DETECTION, "b.json": "[]"},
            {"role": "detections", "format": "coco-results"},
            ["b.json"],
        ),
        ({"a.xml": "<annotation><object/></annotation>", "list.txt": "a"}, {}, ["a.xml"]),
        ({"a.csv": "frame,x,y,w,h,score\n7\n"}, {"role": "detections"}, ["a.csv"]),
    ],
    ids=[
        "names relative to it",
        "neither readme nor hidden files",
        "the named format's endings",
        "the detected format's endings",
        "a line of one number makes no list of frames",
    ],
)
def test_a_folder_gives_the_files_that_can_be_read(
    tmp_path: Path, files: dict[str, str], options: dict[str, str], expected: list[str]
):
    for name, text in files.items():
        write(tmp_path / "out" / name, text)
    assert names(tmp_path, "out", **options) == expected


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege there")
def test_a_link_is_shown_by_its_own_name(tmp_path: Path):
    # data stores such as DVC keep the content under a hash and link to it
    write(tmp_path / "store" / "0a3f", DETECTION)
    link = tmp_path / "drives" / "urban.csv"
    link.parent.mkdir()
    link.symlink_to(tmp_path / "store" / "0a3f")
    assert names(tmp_path, "drives/urban.csv", role="detections")[0].endswith("drives/urban.csv")


@pytest.mark.parametrize(
    ("path", "file_format", "words"),
    [
        ("no.csv", None, r"no\.csv: there is no such file or folder"),
        ("*.csv", None, r"\*\.csv: no file matches this pattern"),
        (".", None, r"no file that could be truth \(endings: \.txt, \.csv"),
        ("a" * 5000, None, "cannot be opened"),
        ("a.res", "coco-results", "files hold no truth"),
        ("a.res", "mott", r"no format 'mott'; did you mean 'mot'\? The formats are bbgt "),
    ],
)
def test_what_gives_no_file_is_named(
    tmp_path: Path, path: str, file_format: str | None, words: str
):
    write(tmp_path / "a.res", "[]")
    with pytest.raises(InputError, match=words):
        names(tmp_path, path, format=file_format)


@pytest.mark.skipif(sys.platform != "linux", reason="file names of any bytes")
def test_a_file_name_that_is_not_utf8_is_refused(tmp_path: Path):
    path = os.fsdecode(os.fsencode(tmp_path) + b"/det\xff.csv")
    Path(path).write_text(DETECTION)
    with pytest.raises(InputError, match=r"not UTF-8: .*det\\udcff\.csv'; rename it"):
        names(tmp_path, path, role="detections")


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("MBNet_result.txt", "MBNet"),
        ("out/yolo-predictions/0016.txt", "yolo"),
        ("out/det_frcnn/det.txt", "det_frcnn"),
        ("mot15/*/res_devkit/*.txt", "res_devkit"),
        ("rrc_ped/0016.txt", "rrc_ped"),
        ("../detections/FIR.csv", "FIR"),
        ("det.txt", "det"),
    ],
)
def test_a_system_is_named_by_the_part_of_its_path_that_tells_most(path: str, expected: str):
    assert system_names([Source((path,))], ["0016", "0017"]) == [expected]


@pytest.mark.parametrize(
    ("paths", "expected"),
    [
        (["fir.csv", "nir.csv"], ["fir", "nir"]),
        (["a/out.csv", "b/out.csv"], ["a", "b"]),
        (["a/run/out.csv", "b/run/out.csv"], ["a", "b"]),
        (["rrc/0016.txt", "pointrcnn/0016.txt"], ["rrc", "pointrcnn"]),
        (["out.csv", "out.csv"], ["out", "out"]),
        (["acf/out.csv", "hog/out.csv", "acf/v2.csv"], ["acf", "hog", "v2"]),
        (["acf/out.csv", "acf/out.csv", "x/v2.csv", "y/v2.csv"], ["out", "out", "x", "y"]),
        (["hog.csv", "hog/out.csv", "acf/out.csv"], ["hog", "out", "out"]),
        ([], []),
    ],
)
def test_systems_are_named_by_what_tells_them_apart(paths: list[str], expected: list[str]):
    assert system_names([Source((path,)) for path in paths], ["0016"]) == expected


def test_a_digest_is_the_sha256_of_the_bytes_and_a_file_that_vanishes_an_input_error(
    tmp_path: Path,
):
    path = tmp_path / "a.csv"
    path.write_bytes(b"abc")
    files, _ = find_files(Source(("a.csv",), format="csv"), tmp_path, "truth")
    # FIPS 180-2, appendix B.1
    assert digest(files) == ["ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"]
    path.unlink()
    with pytest.raises(InputError, match=r"a\.csv: cannot be opened \(No such file"):
        digest(files)


def test_a_seqinfo_named_beside_its_truth_is_no_annotation(tmp_path: Path) -> None:
    (tmp_path / "gt.txt").write_text("1,1,10,10,20,40,1,1,1\n")
    (tmp_path / "seqinfo.ini").write_text("[Sequence]\nname=A\nimWidth=100\nimHeight=100\n")
    for names_given in (("gt.txt", "seqinfo.ini"), ("seqinfo.ini", "gt.txt")):
        files, _ = find_files(Source(names_given), tmp_path, "truth")
        assert [file.path.name for file in files] == ["gt.txt"]


@pytest.mark.parametrize("n", [3, 10_000])
@pytest.mark.parametrize("role", ["truth", "detections"])
def test_a_list_of_frames_says_where_it_belongs(tmp_path: Path, role: str, n: int):
    write(tmp_path / "frames.txt", *(str(frame) for frame in range(n)))
    with pytest.raises(InputError, match="list of evaluated frames") as raised:
        names(tmp_path, "frames.txt", role=role)
    assert raised.value.steps == (Step(Remedy.FRAME_LIST),)


def refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a folder one that may not be looked into, also for root."""
    scandir = os.scandir

    def deny(path: str) -> object:
        if Path(os.fsdecode(path)) == folder:
            raise PermissionError(13, "Permission denied", str(folder))
        return scandir(path)

    monkeypatch.setattr(os, "scandir", deny)
    listdir = os.listdir

    def deny_list(path: str) -> list[str]:
        if Path(path) == folder:
            raise PermissionError(13, "Permission denied", str(folder))
        return listdir(path)

    monkeypatch.setattr(os, "listdir", deny_list)


@pytest.mark.parametrize(
    ("denied", "path", "named"),
    [("drives/A", "drives", "drives/A"), ("drives", "drives", "drives"),
     ("drives", "drives/*.csv", "drives")],
    ids=["a folder in it", "the folder itself", "the folder of a pattern"],
)  # fmt: skip
def test_a_folder_that_may_not_be_looked_into_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, denied: str, path: str, named: str
):
    write(tmp_path / "drives" / "A" / "a.csv", DETECTION)
    refused(tmp_path / denied, monkeypatch)
    monkeypatch.setattr("glob.glob", lambda *_, **__: [])
    with pytest.raises(InputError, match=rf"^{named}: cannot be opened \(Permission denied\)"):
        names(tmp_path, path, role="detections")


def test_a_recording_that_may_not_be_read_is_not_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    folder = mot_layout(tmp_path / "drives")
    refused(folder / "A", monkeypatch)
    stat = os.stat

    def deny(path: str | Path, **more: bool) -> os.stat_result:
        if folder / "A" in Path(path).parents:
            raise PermissionError(13, "Permission denied", str(path))
        return stat(path, **more)

    monkeypatch.setattr(os, "stat", deny)
    with pytest.raises(InputError, match=r"drives/A.*\(Permission denied\)"):
        names(tmp_path, "drives")


def test_a_path_without_a_file_of_the_format_is_named(tmp_path: Path):
    (tmp_path / "truth.json").write_text(json.dumps({"images": [], "annotations": []}))
    labels = tmp_path / "labels"
    labels.mkdir()
    (labels / "a_000001.txt").write_text("0 0.5 0.5 0.1 0.2\n")
    with pytest.raises(InputError, match="files of one source have one format") as caught:
        find_files(Source(("truth.json", "labels")), tmp_path, "truth")
    assert caught.value.file == "labels"
    files, _ = find_files(Source(("truth.json",)), tmp_path, "truth")
    assert [file.path.name for file in files] == ["truth.json"]
