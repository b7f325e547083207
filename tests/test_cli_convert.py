"""nvcore convert and nvcore sample."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from inputs import DATA, nvcore, write

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


def test_several_recordings_become_a_folder_of_mot_files(tmp_path: Path):
    result = nvcore("convert", DATA / "csv" / "truth.csv", tmp_path / "out", "--to", "mot")
    assert result.exit_code == 0, result.output
    files = {path.stem for path in (tmp_path / "out").iterdir()}
    assert files == {"urban", "rural"}
    assert "2 files in" in result.stderr


def test_results_that_name_pictures_by_number_need_the_truth(tmp_path: Path):
    source = DATA / "kaist_results" / "MBNet_result.txt"
    arguments = (source, tmp_path / "out.json", "--to", "coco", "--role", "detections")
    assert nvcore("convert", *arguments).exit_code == 2
    result = nvcore("convert", *arguments, "--truth", DATA / "coco" / "kaist.json")
    assert result.exit_code == 0, result.output
    # picture number 1 is the image of id 0, number 3 that of id 2
    written = json.loads((tmp_path / "out.json").read_text())
    assert [one["image_id"] for one in written] == [0, 2, 2]


def test_the_conversion_is_told_in_words(tmp_path: Path):
    result = nvcore("convert", DATA / "mot" / "MOT16-02" / "gt" / "gt.txt", tmp_path / "a.csv",
                    "--to", "csv")  # fmt: skip
    assert "pixels from 1-based to 0-based" in result.stderr
    assert result.stdout == ""


def test_oddities_of_the_input_are_told(tmp_path: Path):
    source = write(tmp_path / "I00019.txt", "% bbGt version=3", "person 1 2 20 50 0 0 0 0 0 0 45")
    result = nvcore("convert", source, tmp_path / "a.csv", "--to", "csv")
    assert result.exit_code == 0, result.output
    assert "warning truth: " in result.stderr


def test_an_input_that_is_not_there_gives_exit_code_2(tmp_path: Path):
    result = nvcore("convert", tmp_path / "no.csv", tmp_path / "a.csv", "--to", "csv")
    assert result.exit_code == 2
    assert "no.csv: there is no such file or folder" in result.stderr


def test_an_output_that_cannot_be_written_gives_exit_code_2(tmp_path: Path):
    write(tmp_path / "file", "")
    result = nvcore("convert", DATA / "csv" / "truth.csv", tmp_path / "file" / "a.csv",
                    "--to", "csv")  # fmt: skip
    assert result.exit_code == 2
    assert "cannot be written" in result.stderr


def test_sample_tells_its_progress_and_where_it_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def generate(folder: Path, *, progress) -> None:
        progress("urban", 0.25)
        progress("", 1.0)
        write(folder / "truth.csv", "frame")

    monkeypatch.setattr(nvcore_sample, "generate", generate)
    result = nvcore("sample", tmp_path / "s")
    assert result.stderr == f" 25% urban\nwritten to {tmp_path / 's'}\n"
    assert (tmp_path / "s" / "truth.csv").exists()


def test_sample_into_a_folder_that_cannot_be_made_gives_exit_code_2(tmp_path: Path):
    write(tmp_path / "file", "")
    result = nvcore("sample", tmp_path / "file" / "s")
    assert result.exit_code == 2
    assert "cannot be written" in result.stderr


class Terminal:
    """A stream that says it is a terminal and keeps what is written."""

    def __init__(self) -> None:
        self.text = ""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        self.text += text
        return len(text)

    def flush(self) -> None:
        """Nothing is held back."""


@pytest.mark.parametrize(("patience_s", "is_shown"), [(-1.0, True), (3600.0, False)])
def test_the_progress_bar_appears_only_when_the_work_takes_long(
    monkeypatch: pytest.MonkeyPatch, patience_s: float, is_shown: bool
):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(_Steps, "PATIENCE_S", patience_s)
    with _Steps(2) as steps:
        steps("reading fir")
        steps("analysing")
    assert ("analysing" in terminal.text) == is_shown


def test_the_progress_bar_is_finished_when_an_error_ends_the_work(
    monkeypatch: pytest.MonkeyPatch,
):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(_Steps, "PATIENCE_S", -1.0)
    steps = _Steps(5)

    def work() -> None:
        with steps:
            steps("reading fir")
            raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        work()
    assert terminal.text.endswith("\n")
    assert steps.bar.finished
