"""What a subject adds stands beside the core's own, though no line of the core names it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from importlib import import_module
from itertools import chain
from typing import Any, NamedTuple

import pytest
from builders import at, make_dataset
from inputs import drive, nvcore, write
from places import ROOT

import nvcore as nv
from nvcore.auditing import audit
from nvcore.cli.models import Models
from nvcore.common.findings import Caveats, Finding, Severity
from nvcore.common.subject import AddedChecks, Subject, in_place, subjects
from nvcore.notes.caveats import caveats


class Entry(NamedTuple):
    key: str
    after: str = ""


OWN = (Entry("a"), Entry("b"))
FINDING = Finding(Severity.WARNING, "toy-broken", "toy", 1, "The toy is broken.", "Mend it.")
OF_VIEW = Finding(Severity.NOTE, "toy-far", "toy", 1, "The toy is far.", "Fetch it.")


class Toy(Subject):
    name = "toy"

    def checks(self) -> AddedChecks:
        caveats = Caveats(warned={"toy-broken": "a toy is broken"}, lesser={})
        return AddedChecks((lambda _: [FINDING],), (lambda *_: [OF_VIEW],), (caveats,))

    def models(self) -> tuple[Models]:
        models = Models(
            list_all=lambda: "toy: a model of a toy",
            has=lambda model: model == "toy",
            describe=lambda model, settings: f"{model} with {settings}",
        )
        return (models,)


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """One more subject."""
    monkeypatch.setattr("nvcore.subjects.SUBJECTS", (*subjects(), Toy()))
    for function in (subjects, caveats):
        function.cache_clear()
    yield
    monkeypatch.undo()
    for function in (subjects, caveats):
        function.cache_clear()


def test_the_contract_of_imports_says_which_subject_needs_which():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (contract,) = (rule for rule in contracts if rule["name"].startswith("a subject sees no other"))
    needs = {subject.__module__: subject.needs for subject in subjects()}
    assert set(contract["modules"]) == set(needs)
    assert contract["ignore_imports"] == [
        f"{package}.** -> nvcore.subjects.{name}.**" for package in needs for name in needs[package]
    ]


def test_what_a_subject_needs_is_listed_before_it():
    known: list[str] = []
    for subject in subjects():
        assert set(subject.needs) <= set(known)
        known.append(subject.name)


def test_public_names_of_subjects_are_there():
    for module, names in chain(*(subject.names.items() for subject in subjects())):
        assert {*names} <= {*dir(import_module(module))} & {*dir(nv)}


def test_its_checks_are_part_of_the_audit(toy: None):
    box = at(0, 100)
    findings = audit(make_dataset([box], [box]))
    assert {"toy-broken", "toy-far"} < {finding.code for finding in findings}


def test_its_findings_have_their_meaning_for_the_verdict(toy: None):
    assert caveats().warned["toy-broken"] == "a toy is broken"
    assert "same-boxes" in caveats().warned


def test_its_models_are_listed_and_described(toy: None):
    assert "\ntoy: a model of a toy\n" in nvcore("models").stdout
    assert nvcore("models", "toy", "--set", "a=1").stdout == "toy with {'a': '1'}\n"


@pytest.mark.parametrize(
    ("added", "order"),
    [
        ([Entry("c", "a"), Entry("d", "a")], "acdb"),
        ([Entry("c", "a"), Entry("d", "c")], "acdb"),
        ([Entry("d", "c"), Entry("c", "a")], "acdb"),  # what it follows is added later
        ([Entry("c"), Entry("d", "gone")], "abcd"),
    ],
)
def test_what_is_added_stands_after_what_it_follows(added: list[Entry], order: str):
    assert "".join(entry.key for entry in in_place(OWN, added)) == order


@pytest.fixture(scope="module")
def everywhere(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Where a subject with one of each kind appears, in a process in which it has an entry."""
    folder = tmp_path_factory.mktemp("toy")
    detections = drive(folder) / "fir.csv"  # as they are, these are the truth's boxes
    detections.write_text(detections.read_text().replace(",200,", ",203,"))
    session = write(
        folder / "session.toml",
        "[defaults]", 'size = "640x480"', "fps = 20",
        "[truth]", 'path = "truth.csv"',
        "[[system]]", 'path = "fir.csv"',
        "[[system]]", 'path = "nir.csv"',
    )  # fmt: skip
    helpers = (ROOT / "tests" / "helpers", ROOT / "tests" / "ui" / "helpers", ROOT)
    done = subprocess.run(
        [sys.executable, "-m", "toy.everywhere", session, folder / "out"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, helpers))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    known: dict[str, Any] = json.loads(done.stdout)
    return known


def test_its_setting_is_a_flag_a_key_of_the_session_and_a_slider(everywhere: dict[str, Any]):
    assert "--toy-frames" in everywhere["help"]
    assert "toy_frames = 15" in everywhere["session"]
    assert everywhere["summary"]["parameters"]["toy_frames"] == 15
    long_of = [[line for line in page if "long encounters" in line] for page in everywhere["pages"]]
    assert long_of == [["2 long encounters"], ["0 long encounters"]]


def test_its_step_column_measure_figure_and_point_stand_beside_the_cores(
    everywhere: dict[str, Any],
):
    assert everywhere["long"] == [1, 1]
    assert everywhere["summary"]["x"]["toy_detected"] == 2
    assert "long encounters detected" in everywhere["terminal"]
    assert "Toy: 2 are long." in everywhere["terminal"]
    assert everywhere["gate"] == 0
    assert everywhere["figure"] == "Toy"


def test_its_page_opens(everywhere: dict[str, Any]):
    assert everywhere["titles"] == ["Toys"]
