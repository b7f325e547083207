"""``nvcore report``: its file, its exit codes, what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from inputs import drive, flags, mot_layout, nvcore


def test_it_writes_one_file_and_nothing_else(tmp_path: Path):
    drive(tmp_path)
    out = tmp_path / "out" / "report.html"
    result = nvcore("report", *flags(tmp_path), "--out", out)
    assert result.exit_code == 0, result.output
    assert [path.name for path in out.parent.iterdir()] == ["report.html"]
    assert "fir (X) and nir (Y) compared" in out.read_text(encoding="utf-8")
    assert result.stdout.startswith("Audit: ")
    assert "written to" in result.stderr


def test_parameters_and_thresholds_are_those_given(tmp_path: Path):
    drive(tmp_path)
    out = tmp_path / "r.html"
    nvcore("report", *flags(tmp_path, "--alpha", 0.75, "--threshold-x", 0.85), "--out", out)
    content = out.read_text(encoding="utf-8")
    assert '<td>alpha</td><td class="right">0.75</td>' in content
    assert "fir, detections with a score of 0.85 or more" in content


def test_errors_of_the_audit_give_exit_code_1_and_a_file(tmp_path: Path):
    drive(tmp_path)
    with (tmp_path / "truth.csv").open("a") as stream:
        stream.write("urban,3,300,200,40,100,1\n")  # the track a second time in this frame
    out = tmp_path / "r.html"
    code = nvcore("report", *flags(tmp_path), "--out", out).exit_code
    told = json.loads(nvcore("compare", *flags(tmp_path), "--json").stdout)
    assert code == nvcore("compare", *flags(tmp_path)).exit_code == 1
    assert f"{told['x']['encounters_detected']}" in out.read_text(encoding="utf-8")


def test_warnings_count_with_strict(tmp_path: Path):
    drive(tmp_path)
    nvcore("compare", *flags(tmp_path), "--out", tmp_path / "before")
    with (tmp_path / "nir.csv").open("a") as stream:
        stream.write("rural,5,500,200,40,100,0.65\n")
    arguments = ("report", tmp_path / "before" / "session.toml", "--out", tmp_path / "r.html")
    assert nvcore(*arguments).exit_code == 0
    assert nvcore(*arguments, "--strict").exit_code == 1
    assert "has changed since the session file" in (tmp_path / "r.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--out", "truth.csv"), "ends in .html"),
        (("--protocol", "strictest"), "'strictest' is not one of"),
        (("--alpha", "2"), "alpha"),
    ],
)
def test_what_it_refuses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, more, message):
    drive(tmp_path)
    monkeypatch.chdir(tmp_path)
    before = (tmp_path / "truth.csv").read_bytes()
    result = nvcore("report", *flags(tmp_path), *more)
    assert result.exit_code == 2
    assert message in result.stderr
    assert (tmp_path / "truth.csv").read_bytes() == before
    assert not (tmp_path / "report.html").exists()


def test_a_system_that_is_missing_is_bad_input(tmp_path: Path):
    drive(tmp_path)
    assert nvcore("report", "--truth", tmp_path / "truth.csv").exit_code == 2


def test_a_system_without_scores_has_points_in_place_of_curves(tmp_path: Path):
    drive(tmp_path)
    for name in ("fir", "nir"):
        path = tmp_path / f"{name}.csv"
        lines = path.read_text().splitlines()
        path.write_text("\n".join(line.rpartition(",")[0] for line in lines) + "\n")
    out = tmp_path / "r.html"
    assert nvcore("report", *flags(tmp_path), "--out", out).exit_code == 0
    assert "has no averages and no areas" in out.read_text(encoding="utf-8")


def test_several_recordings_from_a_folder_are_listed(tmp_path: Path):
    folder = mot_layout(tmp_path / "mot")
    files = ["--truth", folder / "*" / "gt" / "gt.txt", "--x", folder / "*" / "det" / "det.txt"]
    out = tmp_path / "r.html"
    result = nvcore("report", *files, "--y", folder / "*" / "det" / "det.txt", "--out", out)
    assert result.exit_code in (0, 1), result.output
    content = out.read_text(encoding="utf-8")
    assert content.count("gt/gt.txt</td>") == 2


@pytest.mark.realdata
def test_the_report_of_a_real_drive_has_the_figures_of_compare(realdata: Path, tmp_path: Path):
    folder = realdata / "kaist"
    arguments = [
        "--truth", folder / "KAIST_annotation.json", "--x", folder / "results" / "MLPD_result.txt",
        "--y", folder / "results" / "MBNet_result.txt", "--fps", 20,
    ]  # fmt: skip
    out = tmp_path / "r.html"
    told = nvcore("report", *arguments, "--protocol", "kaist-reasonable", "--out", out)
    assert told.exit_code in (0, 1), told.output
    content = out.read_text(encoding="utf-8")
    # the published log-average miss rates
    row = content[content.index("<td>log-average miss rate</td>") :][:120]
    assert "7.58%" in row
    assert "8.13%" in row
    assert len(content) < 5_000_000
