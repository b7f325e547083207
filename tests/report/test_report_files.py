"""The files of a report."""

from __future__ import annotations

import csv
import io
import json
import tomllib
import zipfile
from pathlib import Path

import pytest
from inputs import drive, session_of, write

from nvcore.comparison import Result, compare
from nvcore.errors import InputError
from nvcore.findings import Finding, Severity
from nvcore.inputs.load import load
from nvcore.inputs.session import Session
from nvcore.report.files import export_files, report_zip, summary_json, write_report

FILES = [
    "frames.csv", "encounters.csv", "events.csv", "intervals.csv", "recordings.csv",
    "significance.csv", "subgroups.csv", "findings.csv", "summary.json", "session.toml",
]  # fmt: skip


def analysed(session: Session) -> Result:
    return compare(load(session))


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return session_of(drive(tmp_path_factory.mktemp("drive")))


@pytest.fixture(scope="module")
def result(session: Session) -> Result:
    return analysed(session)


def rows(content: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(content.decode(), newline="")))


def test_a_report_is_eight_files(result: Result, session: Session, tmp_path: Path):
    write_report(result, session, tmp_path / "new" / "folder")
    assert {path.name for path in (tmp_path / "new" / "folder").iterdir()} == set(FILES)


def test_progress_names_each_file(result: Result, session: Session, tmp_path: Path):
    told: list[str] = []
    write_report(result, session, tmp_path, progress=lambda _share, what: told.append(what))
    assert told == [f"writing {name}" for name in FILES]


def test_the_same_input_gives_the_same_bytes(result: Result, session: Session):
    again = export_files(analysed(session), session)
    assert {n: make() for n, make in export_files(result, session).items()} == {
        name: make() for name, make in again.items()
    }


def test_missing_cells_are_empty(result: Result, session: Session):
    encounters = rows(export_files(result, session)["encounters.csv"]())
    never = next(row for row in encounters if row["miss_class_y"] == "never")
    assert (never["lag_s_y"], never["lead_time_s"], never["occluded_share"]) == ("", "", "")
    assert never["lag_s_x"] == "0"


def test_truth_values_are_1_and_0(result: Result, session: Session):
    encounters = rows(export_files(result, session)["encounters.csv"]())
    assert {row["detected_x"] for row in encounters} == {"1"}
    assert {row["recording"]: row["detected_y"] for row in encounters} == {
        "urban": "1", "rural": "0",
    }  # fmt: skip


def test_a_recording_named_like_a_formula_is_neutralised(tmp_path: Path):
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


def test_a_finding_s_text_is_neutralised_too(result: Result, session: Session):
    finding = Finding(Severity.NOTE, "odd", "=cmd", 1, "@SUM(A1)", "Look.", "-a.csv")
    (row,) = rows(export_files(result, session, (finding,))["findings.csv"]())
    assert (row["subject"], row["message"], row["file"]) == ("'=cmd", "'@SUM(A1)", "'-a.csv")


def test_every_report_carries_parameters_version_and_fingerprint(result: Result, session: Session):
    all_ = json.loads(summary_json(result))
    assert all_["fingerprint"] == result.dataset.fingerprint
    assert all_["version"]
    assert all_["parameters"]["alpha"] == 0.9
    written = tomllib.loads(export_files(result, session)["session.toml"]().decode())["written"]
    assert written["fingerprint"] == result.dataset.fingerprint
    assert set(written["sha256"]) == {"truth", "fir", "nir"}


def test_the_written_session_names_the_systems(result: Result, session: Session):
    written = tomllib.loads(export_files(result, session)["session.toml"]().decode())
    assert [one["name"] for one in written["system"]] == ["fir", "nir"]


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


def test_a_zip_holds_the_files_of_a_report_byte_for_byte(
    result: Result, session: Session, tmp_path: Path
):
    finding = Finding(Severity.NOTE, "odd", "fir", 1, "Odd.", "Look.", "a.csv")
    write_report(result, session, tmp_path, (finding,))
    with zipfile.ZipFile(io.BytesIO(report_zip(result, session, (finding,)))) as archive:
        assert archive.namelist() == FILES
        for name in FILES:
            assert archive.read(name) == (tmp_path / name).read_bytes(), name


def test_the_same_report_gives_the_same_zip(result: Result, session: Session):
    assert report_zip(result, session) == report_zip(analysed(session), session)


def test_files_of_a_zip_have_a_fixed_time_and_can_be_read(result: Result, session: Session):
    with zipfile.ZipFile(io.BytesIO(report_zip(result, session))) as archive:
        assert {one.date_time for one in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert {one.external_attr >> 16 for one in archive.infolist()} == {0o644}


def test_progress_names_each_file_of_a_zip(result: Result, session: Session):
    told: list[str] = []
    report_zip(result, session, progress=lambda _share, what: told.append(what))
    assert told == [f"writing {name}" for name in FILES]
