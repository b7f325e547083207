"""From paths to files, and what a system is called."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from inputs import mot_layout, write

from nvcore.errors import InputError, UnknownFormatError
from nvcore.inputs.files import digest, find_files, system_name, system_names
from nvcore.inputs.session import Source

DETECTION = "frame,x,y,w,h,score\n1,1,1,5,10,0.5"


def names(folder: Path, *paths: str, role: str = "truth", **options: object) -> list[str]:
    files, _ = find_files(Source(paths, **options), folder, role)  # type: ignore[arg-type]
    return [file.name for file in files]


def test_a_folder_in_mot_layout_gives_its_truth_files(tmp_path: Path):
    found = names(mot_layout(tmp_path / "mot"), ".")
    assert found == ["A/gt/gt.txt", "B/gt/gt.txt"]


def test_a_folder_in_mot_layout_gives_its_detection_files(tmp_path: Path):
    found = names(mot_layout(tmp_path), ".", role="detections")
    assert found == ["A/det/det.txt", "B/det/det.txt"]


def test_one_recording_of_mot_layout_is_a_folder_too(tmp_path: Path):
    mot_layout(tmp_path)
    assert names(tmp_path, "B") == ["B/gt/gt.txt"]


def test_mot_layout_is_seen_where_the_format_is_named(tmp_path: Path):
    assert names(mot_layout(tmp_path), ".", format="mot") == ["A/gt/gt.txt", "B/gt/gt.txt"]


def test_a_glob_gives_its_files_in_order(tmp_path: Path):
    mot_layout(tmp_path)
    assert names(tmp_path, "*/det/det.txt", role="detections") == [
        "A/det/det.txt", "B/det/det.txt",
    ]  # fmt: skip


def test_a_glob_works_below_a_folder_with_brackets_in_its_name(tmp_path: Path):
    folder = mot_layout(tmp_path / "drive[1]")
    assert names(folder, "*/gt/gt.txt") == ["A/gt/gt.txt", "B/gt/gt.txt"]


def test_a_file_with_brackets_in_its_name_is_a_file(tmp_path: Path):
    write(tmp_path / "rec[1].csv", DETECTION)
    assert names(tmp_path, "rec[1].csv", role="detections")[0].endswith("/rec[1].csv")


def test_a_list_of_paths_gives_all_of_them_once(tmp_path: Path):
    mot_layout(tmp_path)
    found = names(tmp_path, "B/gt/gt.txt", "A/gt/gt.txt", "*/gt/gt.txt")
    assert found == ["B/gt/gt.txt", "A/gt/gt.txt"]


def test_names_in_a_folder_are_relative_to_it(tmp_path: Path):
    write(tmp_path / "out" / "set06" / "V000" / "I00019.txt", "% bbGt version=3")
    assert names(tmp_path, "out") == ["set06/V000/I00019.txt"]


def test_readme_and_hidden_files_are_passed_over(tmp_path: Path):
    write(tmp_path / "a.csv", DETECTION)
    write(tmp_path / "README.txt", "about these files")
    write(tmp_path / ".cache" / "b.csv", DETECTION)
    write(tmp_path / ".b.csv", DETECTION)
    assert names(tmp_path, ".", role="detections") == ["a.csv"]


def test_a_named_format_takes_only_its_endings(tmp_path: Path):
    write(tmp_path / "a.csv", DETECTION)
    write(tmp_path / "b.json", "[]")
    assert names(tmp_path, ".", role="detections", format="coco-results") == ["b.json"]


def test_files_of_other_endings_beside_the_detected_format_are_left_aside(tmp_path: Path):
    write(tmp_path / "a.xml", "<annotation><object/></annotation>")
    write(tmp_path / "list.txt", "a")
    assert names(tmp_path, ".") == ["a.xml"]


def test_a_file_that_was_named_is_read_whatever_its_ending(tmp_path: Path):
    write(tmp_path / "a.csv", DETECTION)
    write(tmp_path / "b.res", DETECTION)
    found = names(tmp_path, "a.csv", "b.res", role="detections")
    assert [name.rpartition("/")[2] for name in found] == ["a.csv", "b.res"]


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege there")
def test_a_link_is_shown_by_its_own_name(tmp_path: Path):
    # data stores such as DVC keep the content under a hash and link to it
    write(tmp_path / "store" / "0a3f", DETECTION)
    link = tmp_path / "drives" / "urban.csv"
    link.parent.mkdir()
    link.symlink_to(tmp_path / "store" / "0a3f")
    assert names(tmp_path, "drives/urban.csv", role="detections")[0].endswith("drives/urban.csv")


def test_a_missing_file_is_named(tmp_path: Path):
    with pytest.raises(InputError, match=r"no\.csv: there is no such file or folder"):
        names(tmp_path, "no.csv")


def test_a_pattern_that_matches_nothing_is_named(tmp_path: Path):
    with pytest.raises(InputError, match=r"\*\.csv: no file matches this pattern"):
        names(tmp_path, "*.csv")


def test_an_empty_folder_says_which_endings_are_looked_for(tmp_path: Path):
    with pytest.raises(InputError, match=r"no file that could be truth \(endings: \.txt, \.csv"):
        names(tmp_path, ".")


def test_a_name_longer_than_the_system_allows_is_an_input_error(tmp_path: Path):
    with pytest.raises(InputError, match="cannot be opened"):
        names(tmp_path, "a" * 5000)


@pytest.mark.skipif(sys.platform != "linux", reason="file names of any bytes")
def test_a_file_name_that_is_not_utf8_is_refused(tmp_path: Path):
    path = os.fsdecode(os.fsencode(tmp_path) + b"/det\xff.csv")
    Path(path).write_text(DETECTION)
    with pytest.raises(InputError, match=r"not UTF-8: .*det\\udcff\.csv'; rename it"):
        names(tmp_path, path, role="detections")


def test_a_format_that_holds_no_truth_is_refused_as_truth(tmp_path: Path):
    write(tmp_path / "a.json", "[]")
    with pytest.raises(InputError, match="files hold no truth"):
        names(tmp_path, "a.json", format="coco-results")


def test_an_unknown_format_lists_the_known_ones(tmp_path: Path):
    with pytest.raises(UnknownFormatError, match="no format 'mott'; the formats are bbgt, coco"):
        names(tmp_path, "a.json", format="mott")


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("MBNet_result.txt", "MBNet_result"),
        ("out/det_frcnn/det.txt", "det_frcnn"),
        ("mot15/*/res_devkit/*.txt", "res_devkit"),
        ("rrc_ped/0016.txt", "rrc_ped"),
        ("../detections/FIR.csv", "FIR"),
        ("det.txt", "det"),
    ],
)
def test_a_system_is_named_by_the_part_of_its_path_that_tells_most(path: str, expected: str):
    assert system_name(Source((path,)), ["0016", "0017"]) == expected


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


def test_a_digest_is_the_sha256_of_the_bytes(tmp_path: Path):
    (tmp_path / "a.csv").write_bytes(b"abc")
    files, _ = find_files(Source(("a.csv",), format="csv"), tmp_path, "truth")
    # FIPS 180-2, appendix B.1
    assert digest(files) == ["ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"]


def test_a_file_that_vanishes_before_the_digest_is_an_input_error(tmp_path: Path):
    write(tmp_path / "a.csv", DETECTION)
    files, _ = find_files(Source(("a.csv",), format="csv"), tmp_path, "truth")
    (tmp_path / "a.csv").unlink()
    with pytest.raises(InputError, match=r"a\.csv: cannot be opened \(No such file"):
        digest(files)


def test_a_seqinfo_named_beside_its_truth_is_no_annotation(tmp_path: Path) -> None:
    (tmp_path / "gt.txt").write_text("1,1,10,10,20,40,1,1,1\n")
    (tmp_path / "seqinfo.ini").write_text("[Sequence]\nname=A\nimWidth=100\nimHeight=100\n")
    files, _ = find_files(Source(("gt.txt", "seqinfo.ini")), tmp_path, "truth")
    assert [file.path.name for file in files] == ["gt.txt"]


@pytest.mark.parametrize("role", ["truth", "detections"])
def test_a_list_of_frames_says_where_it_belongs(tmp_path: Path, role: str):
    write(tmp_path / "frames.txt", "9\n29\n49\n")
    with pytest.raises(InputError, match=r"list of evaluated frames.*--frames"):
        names(tmp_path, "frames.txt", role=role)


def test_a_long_list_of_frames_is_known_by_its_beginning(tmp_path: Path):
    write(tmp_path / "frames.txt", "".join(f"{frame}\n" for frame in range(10_000)))
    with pytest.raises(InputError, match="list of evaluated frames"):
        names(tmp_path, "frames.txt")
