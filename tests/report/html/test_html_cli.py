"""``nvcore report``: its file, its exit codes, what it refuses."""

from __future__ import annotations

from pathlib import Path

import pytest
from inputs import drive, flags, nvcore


def test_it_writes_one_file_with_the_parameters_given_and_nothing_else(tmp_path: Path):
    drive(tmp_path)
    out = tmp_path / "out" / "report.html"
    given = flags(tmp_path, "--alpha", 0.75, "--threshold-x", 0.85, "--protocol", "near")
    given = (*given, "--question", "Which is safer?", "--author", "Ann", "--date", "2026-05-01")
    result = nvcore("report", *given, "--out", out)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("Audit: ")
    assert "written to" in result.stderr
    assert [path.name for path in out.parent.iterdir()] == ["report.html"]
    content = out.read_text(encoding="utf-8")
    assert "fir (X) and nir (Y) compared" in content
    assert "Which is safer?" in content
    assert "Ann, 2026-05-01" in content
    assert "<td>alpha</td><td>0.75, changed</td>" in content
    assert "fir, detections with a score of 0.85 or more" in content
    assert "Protocol near:" in content
    assert "Not computed for these 40 frames" not in content


def test_the_audit_decides_on_the_exit_code(tmp_path: Path):
    drive(tmp_path)
    nvcore("compare", *flags(tmp_path), "--out", tmp_path / "before")
    with (tmp_path / "nir.csv").open("a") as stream:
        stream.write("rural,5,500,200,40,100,0.65\n")
    out = ("--no-stability", "--out", tmp_path / "r.html")
    session = ("report", tmp_path / "before" / "session.toml", *out)
    assert nvcore(*session).exit_code == 0
    assert nvcore(*session, "--strict").exit_code == 1
    assert "has changed since the session file" in (tmp_path / "r.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--y", "nir.csv", "--out", "truth.csv"), "ends in .html"),
        (("--y", "nir.csv", "--protocol", "strictest"), "'strictest' is not one of"),
        ((), "give a session file, or --truth, --x and --y"),
    ],
)
def test_what_it_refuses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments, message):
    drive(tmp_path)
    monkeypatch.chdir(tmp_path)
    before = (tmp_path / "truth.csv").read_bytes()
    result = nvcore("report", "--truth", "truth.csv", "--x", "fir.csv", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert (tmp_path / "truth.csv").read_bytes() == before
    assert not (tmp_path / "report.html").exists()
