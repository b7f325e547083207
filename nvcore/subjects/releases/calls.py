"""The call of Python users: `nvcore.what_changed`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pandas as pd

from nvcore.api.calls import compare
from nvcore.api.comparison import Comparison
from nvcore.api.inputs import load
from nvcore.common.arguments import PathLike
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import write_run
from nvcore.common.wording import one_line
from nvcore.dataset import Dataset
from nvcore.inputs.session import Session
from nvcore.report.gate import parse_rules
from nvcore.report.section import worded
from nvcore.report.terminal import block_lines
from nvcore.settings.defaults import DELIVERED, OperatingPoint
from nvcore.subjects.releases.section import cases_table, tests_table, versions_table
from nvcore.subjects.releases.versions import latest_versions, measures_of_versions
from nvcore.tables.encounters.changes import Change, changes_table, count_changes

FILES: Final = ("changes.csv", "significance.csv")
"""Files that `Changes.write` writes."""


@dataclass(frozen=True, eq=False, repr=False)
class Changes:
    """What a new version changed, as returned by `nvcore.what_changed`. ``print`` shows it.

    Attributes
    ----------
    comparison
        Comparison of the old version (X) and the new one (Y). Its `evidence` has the paired tests.
    cases
        One row per encounter and false-alert episode, as in ``changes.csv`` (docs/report.md).
    counts
        Number of cases of each kind.
    measures
        Measures of every version, with the rules of the gate
        (`nvcore.subjects.releases.versions.measures_of_versions`).
    """

    comparison: Comparison
    cases: pd.DataFrame
    counts: Mapping[Change, int]
    measures: pd.DataFrame

    def write(self, folder: str | Path) -> None:
        """Write `FILES` into a folder.

        Raises
        ------
        InputError
            If the folder cannot be written to, or holds the run of another command.
        """
        tables = zip(FILES, (self.cases, self.comparison.evidence()), strict=True)
        write_run(Path(folder), [(name, to_csv_bytes(table)) for name, table in tables], FILES)

    def __str__(self) -> str:
        result = self.comparison.result
        old, new = map(one_line, result.names)
        counts = ", ".join(f"{n:,} {kind}" for kind, n in self.counts.items())
        lines = [f"{old} (old) and {new} (new): {counts}"]
        tests = tests_table(result, self.comparison.evidence())
        for block in (cases_table(self.cases), tests, versions_table(self.measures)):
            lines += ["", *block_lines(worded([block], result.objects))]
        return "\n".join(line.rstrip() for line in lines)


def what_changed(
    source: PathLike | Session | Dataset | Comparison,
    old: str | None = None,
    new: str | None = None,
    *,
    rules: str | Iterable[str] | None = None,
    **settings: Any,
) -> Changes:
    """Tell what a new version of a system changed on the same recordings, case by case.

    Parameters
    ----------
    source
        A session file, a session, a dataset made by `load`, or a comparison.
    old, new
        Names of two systems. None: the last two versions that the session declares
        (``version_of``), or X and Y if it declares none.
    rules
        Rules of the gate, such as ``"lamr_y <= 10%"``. None: those of the session.
    settings
        Settings of `load`, such as ``alpha=0.8``.

    Raises
    ------
    InputError
        If an input cannot be used, or it is not clear which versions to compare.
    ParameterError
        If a setting or a rule cannot be used.

    Examples
    --------
    >>> changes = what_changed("night.toml", "NIR", "NIR 2")  # doctest: +SKIP
    >>> changes.cases[changes.cases["kind"] == "newly missed"]  # doctest: +SKIP
    """
    dataset = load(source.dataset if isinstance(source, Comparison) else source, **settings)
    if old is None and new is None:
        old, new = latest_versions(dataset)
    if rules is None:
        rules = dataset.settings.rules if isinstance(dataset.settings, Session) else ()
    is_delivered = dataset.settings.operating_point == DELIVERED
    point: OperatingPoint = "delivered" if is_delivered else "as-set"
    comparison = compare(load(dataset, name_x=old, name_y=new, operating_point=point))
    result, gate_rules = comparison.result, parse_rules(rules)
    return Changes(
        comparison,
        changes_table(result),
        count_changes(result),
        measures_of_versions(result, gate_rules),
    )
