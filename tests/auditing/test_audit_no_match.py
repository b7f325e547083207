"""Systems that match nobody: an error that says what was tried, unless it is meant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from field_files import session_of, written
from field_scene import PERSON, detections, truth
from inputs import nvcore

from nvcore.auditing import audit
from nvcore.common.findings import Finding, Remedy, Severity, Step
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source
from nvcore.inputs.session.changes import applied
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.settings.params import Params


def blind(folder, *names: str) -> Session:
    """The scene, these systems with their boxes above everybody's heads."""
    session = session_of(folder)
    rng = np.random.default_rng(0)
    for name in names:
        table = detections(name)
        table = table.assign(x=rng.uniform(0, 600, len(table)), y=2.0, h=40.0)
        written(folder, name, table, "sizes")
    return session


def no_match(session: Session, params: Params | None = None) -> list[Finding]:
    return [finding for finding in audit(load(session), params) if finding.code == "no-match"]


def test_two_systems_that_match_nobody_are_an_error_that_says_what_was_tried(tmp_path):
    (finding,) = no_match(blind(tmp_path, "x", "y"))
    assert (finding.severity, finding.subject, finding.count) == (Severity.ERROR, "truth", 110)
    tried = ["as they are", "meaning of a box", "frame rate", "another size", "frame number"]
    places = [finding.message.index(f"{what}") for what in tried]
    assert places == sorted(places)
    assert "as they are 0 and 0" in finding.message
    assert Step(Remedy.ACCEPT, "no-match") in finding.steps


def test_one_blind_system_of_two_is_a_warning(tmp_path):
    (finding,) = no_match(blind(tmp_path, "x"))
    assert (finding.severity, finding.subject) == (Severity.WARNING, "x")
    assert Remedy.ACCEPT not in [step.remedy for step in finding.steps]


def test_one_blind_system_alone_is_an_error(tmp_path):
    session = blind(tmp_path, "x")
    (finding,) = no_match(replace(session, systems=session.systems[:1]))
    assert (finding.severity, finding.subject) == (Severity.ERROR, "x")


def test_systems_that_match_somebody_are_not_mentioned(tmp_path):
    assert no_match(session_of(tmp_path)) == []


def test_a_system_that_detects_in_few_frames_is_not_mentioned(tmp_path):
    session = blind(tmp_path, "x", "y")
    for name in "xy":
        table = pd.read_csv(tmp_path / f"{name}.csv").query("frame < 10")
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    assert no_match(session) == []


def test_a_rule_of_matching_that_nobody_can_meet_is_told_from_wrong_files(tmp_path):
    (finding,) = no_match(session_of(tmp_path), Params(iou=1.0))
    assert "as they are 64 and 102." in finding.message
    assert (finding.severity, finding.steps) == (Severity.WARNING, ())


def test_where_nothing_matches_by_the_settings_no_other_cause_is_named(tmp_path):
    session = session_of(tmp_path)
    for name in ("x", "y"):  # beside their own boxes, both have those of two people not annotated
        own = detections(name)
        far = detections("x").assign(x=1.5 * detections("x")["x"] + 20, w=16, h=40)
        written(tmp_path, name, pd.concat([own, far]), "sizes")
    found = [finding.code for finding in audit(load(session), Params(iou=1.0))]
    assert "no-match" in found
    assert "agreed-by-both-alone" not in found


def test_where_a_cause_is_found_it_is_reported_instead(tmp_path):
    session = session_of(tmp_path, x="corners", y="corners")
    assert no_match(session) == []
    errors = [finding for finding in audit(load(session)) if finding.severity is Severity.ERROR]
    assert {(finding.subject, finding.code) for finding in errors} >= {
        ("x", "box-layout"),
        ("y", "box-layout"),
    }


def test_classes_that_were_left_out_are_the_first_cause_and_have_a_way_on(tmp_path):
    session = session_of(tmp_path)
    people = truth().assign(name=lambda t: t["name"].where(t["name"] != PERSON, "dummy"))
    people = people.assign(name=people["name"].where(people["name"] != "bicycle", PERSON))
    people.rename(columns={"name": "class"}).to_csv(tmp_path / "truth.csv", index=False)
    (finding,) = no_match(replace(session, truth=Source("truth.csv")))
    assert "Left out as other classes: truth dummy (110), car (80)." in finding.message
    assert finding.message.index("dummy") < finding.message.index("as they are")
    assert Step(Remedy.CLASSES, "", "truth") in finding.steps


def test_what_is_meant_is_a_warning(tmp_path):
    session = blind(tmp_path, "x", "y")
    (finding,) = no_match(session)
    meant = applied(session, finding.steps[-1], ["x", "y"])
    assert meant is not None
    assert [finding.severity for finding in no_match(meant)] == [Severity.WARNING]


def test_a_session_file_keeps_what_is_meant(tmp_path):
    session = replace(blind(tmp_path, "x", "y"), accept=("no-match",))
    file = tmp_path / "session.toml"
    file.write_text(write_session(session, version="1", fingerprint=""))
    assert read_session(file).accept == ("no-match",)


@pytest.mark.parametrize(("more", "code"), [((), 1), (("--accept", "no-match"), 0)])
def test_the_exit_code_is_1_unless_it_is_meant(tmp_path, more, code):
    blind(tmp_path, "x", "y")
    files = [f"--{name}={tmp_path / name}.csv" for name in ("truth", "x", "y")]
    result = nvcore("compare", *files, "--size", "640x480", "--fps", 10, *more)
    assert result.exit_code == code
    assert ("--accept no-match" in result.output) == (not more)
