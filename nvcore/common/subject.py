"""Base class of subjects: packages that add further questions to a comparison.

The core compares two systems. A subject adds a question about that comparison (was there time left,
would the driver have seen the pedestrian). It lives in one package, ``nvcore/subjects/<name>/``,
whose class overrides the methods of `Subject` for what it adds: settings, steps of
`nvcore.comparison.compare`, measures, columns, findings, figures, points of the verdict, sections
of the reports and commands. Its pages are in ``ui/subjects/<name>/``. Each list of the core has its
own entries, then those of the `subjects`. The core names no subject. CONTRIBUTING has the recipe.

Methods import what they return, so that ``import nvcore`` and ``nvcore --help`` need not wait for
it. The imports for type checkers name packages above this one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

if TYPE_CHECKING:
    import numpy as np
    import plotly.graph_objects as go
    from click import Command as Command

    from nvcore.cli.models import Models as Models
    from nvcore.common.findings import Caveats, Finding
    from nvcore.comparison.compare import Result
    from nvcore.comparison.measures.entry import Measure
    from nvcore.comparison.scoring.step import MissWeights, ScoringStep
    from nvcore.dataset import Dataset
    from nvcore.figures.lanes import Lanes
    from nvcore.inputs.session.added import Input as Input
    from nvcore.report.gate.added import RulesOf
    from nvcore.report.remarks import Remarks
    from nvcore.report.section import SectionOf
    from nvcore.report.verdict import PointOf
    from nvcore.settings.params import Params
    from nvcore.settings.stages import Stage, SubjectSettings
    from nvcore.tables.column import Columns
    from nvcore.tables.summary.entry import SummaryEntry


@dataclass(frozen=True)
class AddedSettings:
    """Classes with fields of `Params`, and the stages of these whose results are shown."""

    fields: Sequence[type[SubjectSettings]] = ()
    shown: Sequence[Stage] = ()


@dataclass(frozen=True)
class AddedKeys:
    """Classes with keys of a ``[[recording]]`` and a ``[[system]]``, and tables of a session."""

    recording: Sequence[type] = ()
    system: Sequence[type] = ()
    tables: Sequence[type] = ()


@dataclass(frozen=True)
class AddedScores:
    """Additions to `nvcore.comparison`.

    Attributes
    ----------
    steps
        Steps of the comparison.
    view
        Makes the return value of `Result.of` from the result.
    measures
        Entries of `nvcore.comparison.measures.table.MEASURES`.
    counts
        Kinds of encounters used as denominators, by name: bool, shape (n_encounters,).
    miss_weights
        Factors of the weight of missing each pedestrian.
    restrict
        Makes only some encounters count. It takes the results of the steps and the encounters
        (bool, shape (n_encounters,)), and returns the changed results.
    """

    steps: Sequence[ScoringStep] = ()
    view: Callable[[Result], object] = lambda result: result
    measures: Sequence[Measure] = ()
    counts: Mapping[str, Callable[[Result], np.ndarray]] = field(default_factory=dict)
    miss_weights: Sequence[MissWeights] = ()
    restrict: Callable[[Mapping[str, Any], np.ndarray], Mapping[str, Any]] = lambda made, _: made


@dataclass(frozen=True)
class AddedTables:
    """Columns of the CSV files, and keys of ``summary.json``."""

    columns: Sequence[Columns] = ()
    entries: Sequence[SummaryEntry] = ()


@dataclass(frozen=True)
class AddedChecks:
    """Checks of `audit_inputs` and `audit_view`, and caveats of verdicts by their findings."""

    inputs: Sequence[Callable[[Dataset], Iterable[Finding]]] = ()
    view: Sequence[Callable[[Dataset, Params], Iterable[Finding]]] = ()
    caveats: Sequence[Caveats] = ()


@dataclass(frozen=True)
class AddedFigures:
    """Figures of `nvcore.api.figures.Figures` by name, and content of the timeline's lanes."""

    named: Mapping[str, Callable[..., go.Figure]] = field(default_factory=dict)
    lanes: Sequence[Lanes] = ()


@dataclass(frozen=True)
class AddedReport:
    """Additions to verdict, reports and gate.

    `doubts` return why no claim can rest on a measure of a result, or an empty string.
    """

    points: Sequence[PointOf] = ()
    sections: Sequence[SectionOf] = ()
    doubts: Sequence[Callable[[Result, Measure], str]] = ()
    remarks: Sequence[Remarks] = ()
    rules: Sequence[RulesOf] = ()


class Subject:
    """A question about a comparison. Its methods return what it adds, by default nothing.

    Attributes
    ----------
    name
        Name of its package, as used by `nvcore.comparison.compare.Result.of`.
    needs
        Names of the subjects that it builds on, all listed before it. It imports no other subject.
    names
        Public names of ``nvcore`` by the module that defines them.
    formats
        Kinds of its model files, by the format named in them (`nvcore.common.output.model_files`).
    extras
        Required extras of pyproject.toml, with the import names of each one's packages.
    has_pages
        True if the dashboard has pages of it, and so includes the extra with its name.
    """

    name: str
    needs: tuple[str, ...] = ()
    names: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    formats: ClassVar[Mapping[str, str]] = {}
    extras: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    has_pages = True

    def settings(self) -> AddedSettings:
        """Return its settings."""
        return AddedSettings()

    def session_keys(self) -> AddedKeys:
        """Return its keys of session files."""
        return AddedKeys()

    def inputs(self) -> Sequence[Input]:
        """Return its input files, besides those of truth and systems."""
        return ()

    def scores(self) -> AddedScores:
        """Return its steps and measures, from modules that do not import the list of measures."""
        return AddedScores()

    def tables(self) -> AddedTables:
        """Return its part of the result's files."""
        return AddedTables()

    def checks(self) -> AddedChecks:
        """Return its part of the audit."""
        return AddedChecks()

    def figures(self) -> AddedFigures:
        """Return its figures. They need the extra ``report``."""
        return AddedFigures()

    def report(self) -> AddedReport:
        """Return its part of verdict, reports and gate."""
        return AddedReport()

    def commands(self) -> Sequence[Command]:
        """Return its commands of ``nvcore``, from modules that import little."""
        return ()

    def models(self) -> Sequence[Models]:
        """Return its entries of ``nvcore models``."""
        return ()


@cache
def subjects() -> tuple[Subject, ...]:
    """Return all subjects, in the order in which their additions are listed."""
    known: tuple[Subject, ...] = import_module("nvcore.subjects").SUBJECTS
    return known


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
