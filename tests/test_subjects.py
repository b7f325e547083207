"""What a subject adds stands beside the core's own, though no line of the core names it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import ModuleType
from typing import NamedTuple

import pytest
from builders import at, make_dataset
from inputs import nvcore

from nvcore import subjects
from nvcore.auditing import Checks, audit
from nvcore.cli.models import Models
from nvcore.findings import Caveats, Finding, Severity
from nvcore.report.verdict import caveats
from nvcore.subjects import Subject, in_place


class Entry(NamedTuple):
    key: str
    after: str = ""


OWN = (Entry("a"), Entry("b"))
FINDING = Finding(Severity.WARNING, "toy-broken", "toy", 1, "The toy is broken.", "Mend it.")
OF_VIEW = Finding(Severity.NOTE, "toy-far", "toy", 1, "The toy is far.", "Fetch it.")


@pytest.fixture(autouse=True)
def toy(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A subject of one module."""
    package, parts = ModuleType("toy"), ModuleType("toy.parts")
    package.SUBJECT = Subject(
        name="toy", findings="parts:CHECKS", caveats="parts:CAVEATS", models="parts:MODELS"
    )
    parts.CHECKS = Checks(inputs=(lambda _: [FINDING],), view=(lambda *_: [OF_VIEW],))
    parts.CAVEATS = Caveats(warned={"toy-broken": "a toy is broken"}, lesser={})
    parts.MODELS = Models(
        list_all=lambda: "toy: a model of a toy",
        has=lambda model: model == "toy",
        describe=lambda model, settings: f"{model} with {settings}",
    )
    for module in (package, parts):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(subjects, "SUBJECTS", (*subjects.SUBJECTS, "toy"))
    cached = (subjects.subjects, subjects.contributed, caveats)
    for function in cached:
        function.cache_clear()
    yield
    monkeypatch.undo()
    for function in cached:
        function.cache_clear()


def test_its_checks_are_part_of_the_audit():
    box = at(0, 100)
    findings = audit(make_dataset([box], [box]))
    assert {"toy-broken", "toy-far"} < {finding.code for finding in findings}


def test_its_findings_have_their_meaning_for_the_verdict():
    assert caveats().warned["toy-broken"] == "a toy is broken"
    assert "same-boxes" in caveats().warned


def test_its_models_are_listed_and_described():
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
