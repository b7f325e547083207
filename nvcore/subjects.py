"""The subjects: further questions about the same comparison. The core names them here alone.

The core compares two systems. A subject asks more of that comparison (was there time left, would
the driver have seen the pedestrian) and lives in one package, ``nvcore/<name>/``, whose
``SUBJECT`` says what it adds to each list of the core: settings, steps of `nvcore.comparison`,
measures, columns, findings, figures, points of the verdict, sections of the reports, commands and
public names; its pages are in ``ui/<name>/``. Wherever the core lists such things it lists its own
and then what is `contributed`. CONTRIBUTING has the recipe.

What a subject adds is named by strings and loaded when it is first asked for, so that
``import nvcore`` and ``nvcore --help`` need not wait for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any, Final, Protocol, TypeVar

SUBJECTS: Final[tuple[str, ...]] = (
    "nvcore.time_left",
    "nvcore.detectors",
    "nvcore.driver",
    "nvcore.alerts",
    "nvcore.ratings",
    "nvcore.fleet",
)
"""The packages of the subjects, in the order in which what they add is listed."""


@dataclass(frozen=True)
class Subject:
    """What a subject adds, each by a reference: ``"module:name"`` within its package.

    Attributes
    ----------
    name
        Of its package; `nvcore.comparison.Result.of` knows it by this name.
    needs
        Names of the subjects that it builds on, all listed before it; it imports no other.
    settings
        Class whose fields become those of `nvcore.params.Params`.
    results
        Stages of these settings whose results are shown (`nvcore.stages.Stage`).
    steps
        Steps of the comparison (`nvcore.scoring.step.ScoringStep`).
    view
        Class (or function) of what `Result.of` returns; it is made of the result.
    miss_weights
        By what the weight of missing each pedestrian is multiplied (`nvcore.scoring.MissWeights`).
    restrict
        Function that makes only some encounters count: from what the steps made and which
        encounters these are (bool, shape (n_encounters,)) to what is made otherwise.
    measures
        Entries of `nvcore.measures.table.MEASURES`.
    counts
        Kinds of encounters that measures are shares of, by name (`nvcore.measures.table.counted`).
    doubts
        Function that says why no claim can rest on a measure of a result
        (`nvcore.measures.table.doubt_of`).
    columns, entries
        Columns of the CSV files (`nvcore.tables.added.Columns`) and keys of ``summary.json``
        (`nvcore.tables.summary_entry.SummaryEntry`).
    findings, caveats
        Checks of the audit (`nvcore.auditing.Checks`), and what their findings mean for the verdict
        (`nvcore.findings.Caveats`).
    figures
        Figures of `nvcore.api.figures.Figures`, by name.
    lanes
        What stands in and above the lanes of the timeline (`nvcore.figures.over_time.lanes.Lanes`).
    points
        Points of the verdict (`nvcore.report.verdict.PointOf`).
    sections
        Sections of the report (`nvcore.report.section.SectionOf`).
    remarks
        What is said beside the numbers in both (`nvcore.report.remarks.Remarks`).
    rules
        What is known of rules of the gate (`nvcore.report.gate.added.RulesOf`).
    recording_keys, system_keys, session_tables
        Classes whose fields become keys of a ``[[recording]]`` and of a ``[[system]]`` of a session
        file (`nvcore.inputs.session.RecordingEntry`, `nvcore.inputs.session.SystemSource`), and
        class whose fields become its tables.
    inputs
        Files that it reads beside those of truth and systems (`nvcore.inputs.added.Input`).
    commands
        Commands of ``nvcore``.
    models
        What ``nvcore models`` lists and describes (`nvcore.cli.models.Models`).
    formats
        What each kind of its model files is, by the format that it names (`nvcore.output.arrays`).
    names
        Public names of ``nvcore``, by reference.
    extras
        Extras of pyproject.toml that it needs, and how the packages of each are imported. The extra
        that is named as the subject comes with the dashboard if the subject has pages.
    ui
        Module of the dashboard with its ``PAGES`` and what else `ui.subjects.contributed` lists.
    """

    name: str
    needs: tuple[str, ...] = ()
    settings: str = ""
    results: str = ""
    steps: str = ""
    view: str = ""
    miss_weights: str = ""
    restrict: str = ""
    measures: str = ""
    counts: str = ""
    doubts: str = ""
    columns: str = ""
    entries: str = ""
    findings: str = ""
    caveats: str = ""
    figures: str = ""
    lanes: str = ""
    points: str = ""
    sections: str = ""
    remarks: str = ""
    rules: str = ""
    recording_keys: str = ""
    system_keys: str = ""
    session_tables: str = ""
    inputs: str = ""
    commands: str = ""
    models: str = ""
    formats: Mapping[str, str] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    extras: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    ui: str = ""


@cache
def subjects() -> dict[str, tuple[str, Subject]]:
    """Package and `Subject` of every subject, by its name."""
    known = {package: import_module(package).SUBJECT for package in SUBJECTS}
    return {subject.name: (package, subject) for package, subject in known.items()}


def resolve(package: str, reference: str) -> Any:
    """What a reference such as ``"measures:MEASURES"`` names in a package."""
    module, _, name = reference.partition(":")
    return getattr(import_module(f"{package}.{module}"), name)


@cache
def contributed(kind: str) -> tuple[Any, ...]:
    """What each subject adds to a list of the core, of those that add to it.

    Parameters
    ----------
    kind
        An attribute of `Subject` that is a reference: ``"measures"``.
    """
    return tuple(
        resolve(package, reference)
        for package, subject in subjects().values()
        if (reference := getattr(subject, kind))
    )


@cache
def public_names() -> dict[str, tuple[str, str]]:
    """Package and reference of every public name of ``nvcore`` that is a subject's."""
    return {
        name: (package, reference)
        for package, subject in subjects().values()
        for name, reference in subject.names.items()
    }


class Placed(Protocol):
    """Something that has its place in a list."""

    @property
    def key(self) -> str:
        """By which others find it."""

    @property
    def after(self) -> str:
        """Key of what it follows; empty: it stands where the list puts it, a subject's last."""


P = TypeVar("P", bound=Placed)


def in_place(own: Sequence[P], added: Iterable[P]) -> tuple[P, ...]:
    """The core's own entries of a list with those that subjects add, each after what it follows."""
    entries, waiting = list(own), list(added)
    while waiting:
        keys = [known.key for known in entries]
        # first those that follow what is there; others may follow one of these
        entry = next((entry for entry in waiting if entry.after in keys), waiting[0])
        waiting.remove(entry)
        place = keys.index(entry.after) + 1 if entry.after in keys else len(entries)
        # after those that were placed there before
        while place < len(entries) and entry.after and entries[place].after == entry.after:
            place += 1
        entries.insert(place, entry)
    return tuple(entries)
