"""Registry of subjects: packages that add further questions to a comparison.

The core compares two systems. A subject adds a question about that comparison (was there time left,
would the driver have seen the pedestrian). It lives in one package, ``nvcore/subjects/<name>/``.
Its ``SUBJECT`` names its additions to the lists of the core: settings, steps of
`nvcore.comparison.compare`, measures, columns, findings, figures, points of the verdict, sections
of the reports, commands and public names. Its pages are in ``ui/subjects/<name>/``. Each list of
the core has its own entries, then the `contributed` ones. The core names subjects only here.
CONTRIBUTING has the recipe.

Additions are named by strings and loaded at first use, so that ``import nvcore`` and
``nvcore --help`` need not wait for them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any, Final, Protocol, TypeVar

SUBJECTS: Final[tuple[str, ...]] = (
    "nvcore.subjects.time_left",
    "nvcore.subjects.detectors",
    "nvcore.subjects.driver",
    "nvcore.subjects.alerts",
    "nvcore.subjects.ratings",
    "nvcore.subjects.fleet",
)
"""Packages of the subjects, in the order in which their additions are listed."""


@dataclass(frozen=True)
class Subject:
    """Additions of a subject, as references ``"module:name"`` within its package.

    Attributes
    ----------
    name
        Name of its package, as used by `nvcore.comparison.compare.Result.of`.
    needs
        Names of the subjects that it builds on, all listed before it. It imports no other subject.
    settings
        Class whose fields become those of `nvcore.settings.params.Params`.
    results
        Stages of these settings whose results are shown (`nvcore.settings.stages.Stage`).
    steps
        Steps of the comparison (`nvcore.comparison.scoring.step.ScoringStep`).
    view
        Class (or function) that makes the return value of `Result.of` from the result.
    miss_weights
        Factors of the weight of missing each pedestrian (`nvcore.comparison.scoring.MissWeights`).
    restrict
        Function that makes only some encounters count. It takes the results of the steps and the
        encounters (bool, shape (n_encounters,)), and returns the changed results.
    measures
        Entries of `nvcore.comparison.measures.table.MEASURES`.
    counts
        Kinds of encounters used as denominators, by name
        (`nvcore.comparison.measures.table.counted`).
    doubts
        Function that returns why no claim can rest on a measure of a result
        (`nvcore.comparison.measures.table.doubt_of`).
    columns, entries
        Columns of the CSV files (`nvcore.tables.column.Columns`) and keys of
        ``summary.json`` (`nvcore.tables.summary.entry.SummaryEntry`).
    findings, caveats
        Checks of the audit (`nvcore.auditing.Checks`), and the effects of their findings on the
        verdict (`nvcore.common.findings.Caveats`).
    figures
        Figures of `nvcore.api.figures.Figures`, by name.
    lanes
        Content in and above the lanes of the timeline (`nvcore.figures.lanes.Lanes`).
    points
        Points of the verdict (`nvcore.report.verdict.PointOf`).
    sections
        Sections of the report (`nvcore.report.section.SectionOf`).
    remarks
        Remarks beside the numbers in the verdict and the report (`nvcore.report.remarks.Remarks`).
    rules
        Contribution to rules of the gate (`nvcore.report.gate.added.RulesOf`).
    recording_keys, system_keys, session_tables
        Classes whose fields become keys of a ``[[recording]]`` and of a ``[[system]]`` of a session
        file (`nvcore.inputs.session.RecordingEntry`, `nvcore.inputs.session.SystemSource`), and
        class whose fields become its tables.
    inputs
        Input files besides those of truth and systems (`nvcore.inputs.session.added.Input`).
    commands
        Commands of ``nvcore``.
    models
        Entries of ``nvcore models`` (`nvcore.cli.models.Models`).
    formats
        Kinds of its model files, by the format named in them (`nvcore.common.output.model_files`).
    names
        Public names of ``nvcore``, by reference.
    extras
        Required extras of pyproject.toml, with the import names of each one's packages. The
        dashboard includes the extra with the subject's name if the subject has pages.
    ui
        Module of the dashboard with its ``PAGES`` and other lists of `ui.subject.contributed`.
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
    """Map each subject's name to its package and its `Subject`."""
    known = {package: import_module(package).SUBJECT for package in SUBJECTS}
    return {subject.name: (package, subject) for package, subject in known.items()}


def resolve(package: str, reference: str) -> Any:
    """Import the object that a reference such as ``"measures:MEASURES"`` names in a package."""
    module, _, name = reference.partition(":")
    return getattr(import_module(f"{package}.{module}"), name)


@cache
def contributed(kind: str) -> tuple[Any, ...]:
    """Return what each subject adds to one of the core's lists, skipping subjects that add nothing.

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
    """Return package and reference of each name that subjects export from ``nvcore``."""
    return {
        name: (package, reference)
        for package, subject in subjects().values()
        for name, reference in subject.names.items()
    }


class Placed(Protocol):
    """List entry whose position depends on another entry."""

    @property
    def key(self) -> str:
        """Key of the entry."""

    @property
    def after(self) -> str:
        """Key of the entry to insert this one behind. Empty: default position (subjects: last)."""


P = TypeVar("P", bound=Placed)


def in_place(own: Sequence[P], added: Iterable[P]) -> tuple[P, ...]:
    """Insert entries of subjects into one of the core's lists, each behind the entry in `after`."""
    entries, waiting = list(own), list(added)
    while waiting:
        keys = [known.key for known in entries]
        # entries that follow the core's first, as others may follow these
        entry = next((entry for entry in waiting if entry.after in keys), waiting[0])
        waiting.remove(entry)
        place = keys.index(entry.after) + 1 if entry.after in keys else len(entries)
        # after those that were placed there before
        while place < len(entries) and entry.after and entries[place].after == entry.after:
            place += 1
        entries.insert(place, entry)
    return tuple(entries)
