"""Paths and conversions on the terminal: they can be pasted and are short; reports stay alike."""

from __future__ import annotations

from pathlib import Path

import pytest
from inputs import FACTS, drive, flags, mot_layout, nvcore, write
from places import DATA

from nvcore.inputs.files.find import paths_to_show
from nvcore.inputs.session import Source


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder where the command runs; the recordings are in "a/b/drive" below it."""
    drive(tmp_path / "a" / "b" / "drive")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("command", [["compare", "--full"], ["check"]], ids=" ".join)
def test_a_file_below_the_current_folder_is_shown_by_its_whole_path(
    folder: Path, command: list[str]
):
    result = nvcore(*command, *flags(folder / "a" / "b" / "drive"))
    assert "truth: a/b/drive/truth.csv (csv; " in result.stdout


def test_a_file_elsewhere_is_shown_as_it_was_given(folder: Path, monkeypatch: pytest.MonkeyPatch):
    (folder / "here").mkdir()
    monkeypatch.chdir(folder / "here")
    given = Path("../a/b/drive")
    assert "truth: ../a/b/drive/truth.csv (" in nvcore("check", *flags(given)).stdout
    absolute = folder / "a" / "b" / "drive"
    assert f"truth: {absolute.as_posix()}/truth.csv (" in nvcore("check", *flags(absolute)).stdout


@pytest.mark.parametrize("command", ["compare", "check", "convert"])
def test_an_error_about_a_file_names_its_path(folder: Path, command: str):
    write(Path("a/b/drive/truth.csv"), "frame,x,y,w,h", "0,1,1,5,tall")
    arguments = flags(Path("a/b/drive"))
    if command == "convert":
        arguments = ["a/b/drive/truth.csv", "new.csv", "--to", "csv"]
    result = nvcore(command, *arguments)
    assert result.exit_code == 2
    assert "Error: a/b/drive/truth.csv, line 2: expected a number" in result.stderr


def test_a_finding_on_the_terminal_names_the_path_and_in_the_report_the_name(folder: Path):
    mot_layout(folder / "w" / "in")
    for name in ("A", "B"):
        with (folder / "w" / "in" / name / "gt" / "gt.txt").open("a") as stream:
            stream.write("0,1,11,21,30,60,1,1,1\n")
    source = "w/in/*/det/det.txt"
    result = nvcore("compare", "--truth", "w/in/*/gt/gt.txt", "--x", source, "--y", source,
                    "--full", "--out", "report")  # fmt: skip
    assert "first: w/in/A/gt/gt.txt, line 5: frame 0" in result.stdout
    report = Path("report/findings.csv").read_text()
    assert ",A/gt/gt.txt," in report
    assert "w/in/A" not in report


def test_a_name_that_two_files_have_and_a_source_that_is_not_there_have_no_path(tmp_path: Path):
    for name in ("p", "q"):
        mot_layout(tmp_path / name, ("A",))
    sources = [(Source(("p/*/gt/gt.txt", "q/*/gt/gt.txt")), "truth")]
    assert paths_to_show(tmp_path, sources) == {}
    sources = [(Source(("no.csv",)), "truth"), (Source((".",), format="vbb"), "detections")]
    assert paths_to_show(tmp_path, sources) == {}


@pytest.mark.parametrize("command", ["check", "compare", "gate"])
def test_a_finding_names_the_path_where_two_inputs_have_files_of_one_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
):
    monkeypatch.chdir(tmp_path)
    boxes = [f"{frame},{100 + frame},200,40,100" for frame in range(5)]
    for name, row in (("truth", boxes[0]), ("x", "77,1,1,40,100"), ("y", boxes[0])):
        write(tmp_path / name / "0015.csv", "frame,x,y,w,h", *boxes, row)
    given = ["--truth", "truth", "--x", "x", "--y", "y", *FACTS]
    more = {"compare": ["--full"], "gate": ["--rule", "frames == 5"]}.get(command, [])
    lines = nvcore(command, *given, *more).stdout.splitlines()
    assert any("first: x/0015.csv" in line for line in lines)
    assert any("first: truth/0015.csv" in line for line in lines)
    if command != "gate":
        for name in ("truth", "x", "y"):
            assert any(line.startswith(f"{name}: {name}/0015.csv (csv; ") for line in lines)


def test_an_error_names_the_input_where_two_have_files_of_one_name(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, more in (("truth", ""), ("x", "oops\n")):
        (tmp_path / name).mkdir()
        lines = "frame,x,y,w,h\n1,5,5,10,20\n2,5,5,10,20\n" + more
        (tmp_path / name / "0015.csv").write_text(lines)
    result = nvcore("check", "--truth", "truth", "--x", "x", *FACTS)
    assert result.exit_code == 2
    assert "Error: x/0015.csv, line 4: " in result.stderr


def test_a_mot_folder_without_det_names_the_pattern_for_its_detections(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mot_layout(tmp_path / "in")
    for name in ("A", "B"):
        (tmp_path / "in" / name / "det").rename(tmp_path / "in" / name / "det_frcnn")
    result = nvcore("check", "--truth", "in", "--x", "in")
    assert result.exit_code == 2
    assert "holds ground truth (*/gt/gt.txt) and no detections" in result.stderr
    assert "'in/*/det_frcnn/det.txt'" in result.stderr


def test_compare_in_full_cuts_a_long_conversion_between_facts_and_check_shows_all(tmp_path: Path):
    truth, x = DATA / "coco" / "kaist.json", DATA / "coco" / "results.json"
    arguments = ("--truth", truth, "--x", x, *FACTS)
    (whole,) = [line for line in nvcore("check", *arguments).stdout.splitlines()
                if line.startswith("truth: ")]  # fmt: skip
    (cut,) = [line for line in nvcore("compare", *arguments, "--full", "--y", x, "--name-y", "Y")
              .stdout.splitlines() if line.startswith("truth: ")]  # fmt: skip
    start, _, more = cut.partition("; ... (in full: nvcore check)")
    assert more == ")"
    assert whole.startswith(start + "; ")
    assert whole.endswith("evaluated frames from the image list)")
