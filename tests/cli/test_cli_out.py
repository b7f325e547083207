"""``--out`` of each command: what it writes, and that no input is replaced by it."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd
import pytest
from inputs import flags, mot_layout, nvcore, write
from places import SAMPLE

from nvcore.common.output.files import LOCK, MANIFEST
from nvcore.report.files import AUDIT_FILES


def content(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_check_writes_its_findings_whole_and_again(folder: Path):
    write(folder / "fir.csv", "recording,frame,x,y,w,h,score", "urban,999,1,1,9,9,0.5")
    out = folder.parent / "audit"
    for _ in range(2):
        ran = nvcore("check", *flags(folder), "--out", out)
        assert f"written to {out}" in ran.stderr
        assert {path.name for path in out.iterdir()} == {*AUDIT_FILES, MANIFEST, LOCK}
    table = pd.read_csv(out / "findings.csv")
    assert ran.exit_code == int((table["severity"] == "error").any())
    assert len(table) == ran.stdout.count("\n  error") + ran.stdout.count("\n  warning") + (
        ran.stdout.count("\n  note")
    )


def test_check_writes_estimated_horizons_as_a_table_that_recordings_reads(tmp_path: Path):
    lines = SAMPLE.read_text().splitlines()
    sample = write(
        tmp_path / "sample" / "session.toml",
        *(line for line in lines if not line.startswith(("horizon", "pictures"))),
    )
    for name in ("truth.csv", "fir.csv", "nir.csv", "nir2.csv"):
        (sample.parent / name).symlink_to(SAMPLE.parent / name)
    out = tmp_path / "audit"
    ran = nvcore("check", sample, "--out", out)
    table = pd.read_csv(out / "horizons.csv")
    assert table.columns.tolist() == ["recording", "horizon"]
    assert len(table) == 10
    assert ran.stdout.count("boxes of") == 10
    again = nvcore("check", sample, "--recordings", out / "horizons.csv")
    assert again.exit_code == 0, again.output
    assert "horizon, which is not stated" not in again.stdout


def test_check_leaves_the_report_of_a_comparison_whole(folder: Path):
    report = folder.parent / "report"
    assert nvcore("compare", *flags(folder), "--out", report).exit_code == 0
    before = content(report)
    ran = nvcore("check", *flags(folder), "--out", report)
    assert ran.exit_code == 2
    assert "holds encounters.csv, events.csv, frames.csv" in ran.stderr
    assert "of another command (by its SHA256SUMS); give another folder" in ran.stderr
    assert content(report) == before


def test_check_and_gate_write_over_no_input_and_into_no_folder_of_inputs(folder: Path):
    (folder / "truth.csv").rename(folder / "findings.csv")
    given = flags(folder)
    given[given.index(str(folder / "truth.csv"))] = str(folder / "findings.csv")
    before = content(folder)
    ran = nvcore("check", *given, "--out", folder)
    assert ran.exit_code == 2
    assert "findings.csv: is an input, and would be replaced" in ran.stderr
    assert content(folder) == before
    drives = mot_layout(folder.parent / "drives")
    before = content(drives)
    for command in (["check"], ["gate", "--rule", "saliency_x < 9"]):
        ran = nvcore(
            *command, "--truth", drives, "--x", drives, "--y", drives, "--out", drives / "A"
        )
        assert ran.exit_code == 2
        assert "lies in the folder of inputs" in ran.stderr
        assert content(drives) == before


def test_gate_writes_both_of_its_results_into_a_folder(folder: Path):
    out = folder.parent / "ci"
    ran = nvcore("gate", *flags(folder), "--rule", "newly_missed == 0", "--out", out)
    assert ran.exit_code == 1
    assert {path.name for path in out.iterdir()} == {"gate.xml", "gate.md"}
    suite = ElementTree.parse(out / "gate.xml").getroot().find("testsuite")
    assert (suite.attrib["tests"], suite.attrib["failures"]) == ("2", "1")
    assert "1 of 2 rules failed" in (out / "gate.md").read_text()
    # a gate that cannot be run leaves nothing of the run before
    for wrong in (["--alfa", "1"], ["--rule", "no_such < 1"]):
        assert nvcore("gate", *flags(folder), "--out", out, *wrong).exit_code == 2
        assert 'errors="1"' in (out / "gate.xml").read_text()
        assert "1 of 2" not in (out / "gate.md").read_text()


def test_a_file_named_by_itself_goes_before_the_folder(folder: Path):
    ran = nvcore("gate", *flags(folder), "--rule", "encounters == 2", "--out", folder.parent / "ci",
                 "--junit", folder.parent / "own.xml")  # fmt: skip
    assert ran.exit_code == 0, ran.output
    assert (folder.parent / "own.xml").exists()
    assert [path.name for path in (folder.parent / "ci").iterdir()] == ["gate.md"]


def test_plan_writes_what_json_prints(tmp_path: Path):
    out = tmp_path / "new" / "plan.json"
    ran = nvcore(
        "plan",
        SAMPLE,
        "--measure",
        "encounters_detected",
        "--difference",
        "20%",
        "--out",
        out,
        "--json",
    )
    assert ran.exit_code == 0, ran.output
    assert json.loads(out.read_text("utf-8")) == json.loads(ran.stdout)


@pytest.mark.parametrize(
    ("name", "words"),
    [("plan.txt", "expected a file that ends in .json"), ("truth.json", "truth.json: is an input")],
)
def test_a_plan_replaces_no_input(folder: Path, name: str, words: str):
    (folder / "truth.csv").rename(folder / "truth.json")
    given = flags(folder, "--format", "csv")
    given[given.index(str(folder / "truth.csv"))] = str(folder / "truth.json")
    before = content(folder)
    ran = nvcore("plan", *given, "--out", folder / name)
    assert ran.exit_code == 2
    assert words in ran.stderr
    assert content(folder) == before


def test_convert_takes_its_output_in_either_way_and_once(folder: Path):
    truth = folder / "truth.csv"
    assert nvcore("convert", truth, folder / "a.csv", "--to", "csv").exit_code == 0
    assert nvcore("convert", truth, "--to", "csv", "--out", folder / "b.csv").exit_code == 0
    assert (folder / "a.csv").read_bytes() == (folder / "b.csv").read_bytes()
    for more in ([], [folder / "c.csv", "--out", folder / "c.csv"]):
        ran = nvcore("convert", truth, "--to", "csv", *more)
        assert ran.exit_code == 2
        assert "give the file or folder to write once" in ran.stderr
    ran = nvcore("convert", truth, "--to", "csv", "--out", truth, "--force")
    assert ran.exit_code == 2
    assert truth.read_bytes().startswith(b"recording,frame,x,y,w,h,track\n")
