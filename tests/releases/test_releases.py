"""Versions of a system in a session: which they are, their measures, and the command."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from builders import make_dataset
from inputs import drive, nvcore, session_of, write

import nvcore as nv
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, SystemSource
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.subjects.releases.versions import latest_versions, version_lines
from nvcore.tables.encounters.changes import Change

RULES = ("newly_missed == 0", "encounters_detected_y >= 2")


def night(folder: Path, **of: str | None) -> Session:
    """FIR, NIR, and FIR's detections once more as NIR 2; `of` says of what each is a version."""
    files = {"FIR": "fir.csv", "NIR": "nir.csv", "NIR 2": "fir.csv"}
    systems = (
        SystemSource((file,), name=name, version_of=of.get(name.replace(" ", "_")))
        for name, file in files.items()
    )
    return session_of(drive(folder), "truth.csv", *systems, rules=RULES)


@pytest.fixture
def session(tmp_path: Path) -> Session:
    return night(tmp_path, NIR_2="NIR")


def lines_of(tmp_path: Path, **of: str) -> tuple[tuple[str, ...], ...]:
    return version_lines(load(night(tmp_path, **of)))


def test_systems_of_one_name_are_versions_in_the_order_of_the_session(tmp_path: Path):
    assert lines_of(tmp_path) == ()
    assert lines_of(tmp_path, NIR_2="NIR") == (("NIR", "NIR 2"),)
    assert lines_of(tmp_path, NIR="night eye", NIR_2="night eye") == (("NIR", "NIR 2"),)
    assert lines_of(tmp_path, NIR="FIR", NIR_2="NIR") == (("FIR", "NIR", "NIR 2"),)
    assert lines_of(tmp_path, NIR="NIR 2", NIR_2="NIR") == ()  # of one another: no line begins


def test_a_session_file_says_so_and_keeps_it_through_writing_and_renaming(session: Session):
    file = session.folder / "night.toml"
    file.write_text(write_session(session, version="", fingerprint=""), encoding="utf-8")
    again = read_session(file)
    assert [system.version_of for system in again.systems] == [None, None, "NIR"]
    assert again.rules == RULES
    renamed = load(again).renamed({"NIR": "Near"}, {})
    assert version_lines(renamed) == (("Near", "NIR 2"),)


def test_the_last_two_versions_are_compared_unless_named(tmp_path: Path, session: Session):
    assert latest_versions(load(session)) == ("NIR", "NIR 2")
    assert latest_versions(load(night(tmp_path))) == ("FIR", "NIR")  # without versions: X and Y
    named = nv.what_changed(session, "FIR", "NIR")
    assert named.comparison.result.names == ("FIR", "NIR")
    assert nv.what_changed(session, new="NIR").comparison.result.names == ("FIR", "NIR")
    with pytest.raises(nv.NvcoreError, match="there is no system 'NIR 3'"):
        nv.what_changed(session, "NIR", "NIR 3")
    more = (*session.systems, replace(session.systems[0], name="FIR 2", version_of="FIR"))
    with pytest.raises(nv.NvcoreError, match="of FIR, FIR 2; NIR, NIR 2"):
        nv.what_changed(replace(session, systems=more))


def test_what_changed_has_cases_tests_and_measures_of_all_versions(session: Session):
    changes = nv.what_changed(session)
    assert changes.comparison.result.names == ("NIR", "NIR 2")
    assert changes.counts == {kind: int(kind in (Change.FIXED, Change.GONE)) for kind in Change} | {
        Change.UNCHANGED: 1
    }
    measures = changes.measures.set_index(["measure", "version"])
    assert np.isnan(measures.loc[("newly_missed", "NIR"), "value"])
    assert pd.isna(measures.loc[("newly_missed", "NIR"), "is_met"])
    assert measures["value"].tolist()[1:] == [0, 1, 2]
    assert measures["is_met"].tolist()[1:] == [True, False, True]
    moved = replace(session, operating_point="equal-alarms")
    assert nv.what_changed(moved).comparison.result.as_set is None  # a release is as it is set
    leading = nv.what_changed(changes.comparison, rules=())
    assert leading.measures["rule"].isna().all()
    assert re.search(r"Measure +NIR +NIR 2\n +mean_similarity_y", str(leading))
    assert "alerts" not in str(leading)  # they are off


def test_each_version_has_the_threshold_of_its_own(session: Session):
    systems = (*session.systems[:2], replace(session.systems[2], threshold=0.95))
    of_none = nv.what_changed(replace(session, systems=systems)).measures
    detected = of_none[of_none["measure"] == "encounters_detected_y"]["value"]
    assert detected.tolist() == [1, 0]


def test_a_wrong_rule_is_refused_by_its_place(session: Session):
    with pytest.raises(nv.NvcoreError, match=r"rule 1: .*there is no measure 'lmr_y'"):
        nv.what_changed(session, rules="lmr_y < 1")


def test_the_command_prints_the_changes_and_writes_the_files(session: Session, tmp_path: Path):
    file, out = tmp_path / "night.toml", tmp_path / "out"
    file.write_text(write_session(session, version="", fingerprint=""), encoding="utf-8")
    ran = nvcore("changed", file, "--out", out)
    assert ran.exit_code == 0, ran.output
    assert ran.stdout.startswith(
        "NIR (old) and NIR 2 (new): 0 newly missed, 0 newly false, 1 fixed"
    )
    assert "fixed  rural" in ran.stdout
    assert re.search(r"encounters_detected_y >= 2 +1 ! +2\n", ran.stdout)
    cases = pd.read_csv(out / "changes.csv")
    assert sorted(cases["kind"]) == ["fixed", "gone", "unchanged"]
    assert (out / "significance.csv").exists()
    refused = nvcore("changed", file, "--old", "NIR", "--new", "NIR 3")
    assert refused.exit_code == 2
    assert "there is no system 'NIR 3'" in refused.stderr


def test_the_gate_takes_the_rules_of_the_session(session: Session, tmp_path: Path):
    file = write(tmp_path / "night.toml", "")
    file.write_text(write_session(session, version="", fingerprint=""), encoding="utf-8")
    both = "--name-x", "NIR", "--name-y", "NIR 2"
    passed = nvcore("gate", file, *both)
    assert passed.exit_code == 0, passed.output
    assert "passed  newly_missed == 0  (newly_missed is 0)" in passed.stdout
    assert "newly_missed" not in nvcore("gate", file, *both, "--rule", "frames == 40").stdout
    bad = replace(session, rules=("lmr_y < 1",))
    file.write_text(write_session(bad, version="", fingerprint=""), encoding="utf-8")
    assert f"{file}: [gate]: 'lmr_y < 1': there is no measure" in nvcore("gate", file).stderr


def test_a_dataset_from_tables_has_no_versions():
    assert version_lines(make_dataset(n_frames=2)) == ()
