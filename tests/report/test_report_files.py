"""The files of a report."""

from __future__ import annotations

import csv
import io
import json
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from inputs import drive, session_of, write

from nvcore.common.errors import InputError
from nvcore.common.findings import Finding, Severity
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import LOCK, MANIFEST, manifest
from nvcore.comparison.compare import Result, compare
from nvcore.inputs.load import load
from nvcore.inputs.session import Session
from nvcore.report.files import export_files, report_zip, summary_json, write_report

FILES = [
    "frames.csv", "encounters.csv", "events.csv", "intervals.csv", "recordings.csv",
    "significance.csv", "subgroups.csv", "findings.csv", "finding_entries.csv", "summary.json",
    "session.toml",
]  # fmt: skip
HOSTILE = Finding(Severity.NOTE, "odd", "=cmd", 1, "@SUM(A1)", "Look.", "-a.csv")


def analysed(session: Session) -> Result:
    return compare(load(session))


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return session_of(drive(tmp_path_factory.mktemp("drive")))


@pytest.fixture(scope="module")
def result(session: Session) -> Result:
    return analysed(session)


@pytest.fixture(scope="module")
def contents(result: Result, session: Session) -> dict[str, bytes]:
    return {name: make() for name, make in export_files(result, session, (HOSTILE,)).items()}


def rows(content: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(content.decode(), newline="")))


def test_folder_and_zip_hold_the_same_files_and_name_each_as_they_write(
    result: Result, session: Session, contents: dict[str, bytes], tmp_path: Path
):
    steps: list[str] = []

    def progress(_share: float, step: str) -> None:
        steps.append(step)

    folder = tmp_path / "new" / "folder"
    write_report(result, session, folder, (HOSTILE,), progress=progress)
    packed = report_zip(result, session, (HOSTILE,), progress=progress)
    assert steps == [f"writing {name}" for name in FILES] * 2
    written = {path.name: path.read_bytes() for path in folder.iterdir() if path.name != LOCK}
    assert written == contents | {MANIFEST: manifest(contents.items())}
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert archive.namelist() == [*FILES, MANIFEST]
        assert {name: archive.read(name) for name in archive.namelist()} == written
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert {entry.external_attr >> 16 for entry in archive.infolist()} == {0o644}


def test_the_same_input_gives_the_same_bytes(session: Session, contents: dict[str, bytes]):
    again = export_files(analysed(session), session, (HOSTILE,))
    assert {name: make() for name, make in again.items()} == contents


def test_missing_cells_are_empty_and_truth_values_1_and_0(contents: dict[str, bytes]):
    encounters = {row["recording"]: row for row in rows(contents["encounters.csv"])}
    never = encounters["rural"]
    assert never["miss_class_y"] == "never"
    assert (never["lag_s_y"], never["lead_time_s"], never["occluded_share"]) == ("", "", "")
    assert never["lag_s_x"] == "0"
    assert {row["detected_x"] for row in encounters.values()} == {"1"}
    assert [encounters[name]["detected_y"] for name in ("urban", "rural")] == ["1", "0"]


def test_what_a_spreadsheet_would_compute_is_neutralised(
    tmp_path: Path, contents: dict[str, bytes]
):
    drive(tmp_path)
    for name in ("truth", "fir", "nir"):
        text = (tmp_path / f"{name}.csv").read_text().replace("urban", "=1+1")
        (tmp_path / f"{name}.csv").write_text(text)
    session = session_of(tmp_path)
    files = export_files(analysed(session), session)
    for name in ("frames.csv", "encounters.csv", "recordings.csv"):
        content = files[name]()
        assert {row["recording"] for row in rows(content)} == {"'=1+1", "rural"}
        assert b"\n=" not in content
    (row,) = rows(contents["findings.csv"])
    assert (row["subject"], row["message"], row["file"]) == ("'=cmd", "'@SUM(A1)", "'-a.csv")


def test_every_report_carries_parameters_version_fingerprint_and_systems(
    result: Result, contents: dict[str, bytes]
):
    summary = json.loads(contents["summary.json"])
    assert summary["fingerprint"] == result.dataset.fingerprint
    assert summary["version"]
    assert summary["parameters"]["alpha"] == 0.9
    session = tomllib.loads(contents["session.toml"].decode())
    assert session["written"]["fingerprint"] == result.dataset.fingerprint
    assert set(session["written"]["sha256"]) == {"truth", "fir", "nir"}
    assert [system["name"] for system in session["system"]] == ["fir", "nir"]
    assert (summary["x"]["name"], summary["y"]["name"]) == ("fir", "nir")


def test_names_of_any_language_are_kept(tmp_path: Path):
    drive(tmp_path)
    (tmp_path / "fir.csv").rename(tmp_path / "wärme 夜.csv")
    session = session_of(tmp_path, "truth.csv", "wärme 夜.csv", "nir.csv")
    assert json.loads(summary_json(analysed(session)))["x"]["name"] == "wärme 夜"


def test_a_folder_that_cannot_be_made_is_an_input_error(
    result: Result, session: Session, tmp_path: Path
):
    write(tmp_path / "report", "a file")
    with pytest.raises(InputError, match=r"report: cannot be written \(File exists\)"):
        write_report(result, session, tmp_path / "report")


def test_tables_as_parquet_hold_what_the_csv_files_hold(
    result: Result, session: Session, contents: dict[str, bytes], tmp_path: Path
):
    write_report(result, session, tmp_path, (HOSTILE,), tables="parquet", matches=True)
    written = {path.name for path in tmp_path.iterdir()} - {LOCK, MANIFEST}
    tables = [name.removesuffix(".csv") for name in FILES if name.endswith(".csv")]
    assert written == {
        *(f"{name}.parquet" for name in (*tables, "matches")), "summary.json", "session.toml"
    }  # fmt: skip
    for name in tables:
        ours = pd.read_parquet(tmp_path / f"{name}.parquet", dtype_backend="numpy_nullable")
        assert to_csv_bytes(ours.replace([np.inf, -np.inf], np.nan)).decode().replace("'", "") == (
            contents[f"{name}.csv"].decode().replace("'", "")
        ), name
    assert (tmp_path / "summary.json").read_bytes() == contents["summary.json"]


def test_the_other_form_of_the_tables_goes_when_a_report_is_written_anew(
    result: Result, session: Session, tmp_path: Path
):
    write_report(result, session, tmp_path, tables="parquet", matches=True)
    write_report(result, session, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*FILES, LOCK, MANIFEST}
