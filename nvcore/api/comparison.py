"""Comparison for Python users: numbers, tables, figures, sentences and files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import pandas as pd

from nvcore.auditing import audit, picture_findings
from nvcore.common.arguments import method_with
from nvcore.common.arguments.plan import PlanArguments
from nvcore.common.arguments.report import HtmlArguments
from nvcore.common.errors import InputError, ParameterError
from nvcore.common.extras import needs
from nvcore.common.findings import Finding, worst_first
from nvcore.common.wording import ARROWS, count_text, difference, number, one_line
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import MeasureTable
from nvcore.evidence.claims import Claim
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.graded import Graded
from nvcore.evidence.looks import add_look
from nvcore.evidence.measures import Judged
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.operating_points import at_operating_point
from nvcore.evidence.planning import Plan, plan_recordings
from nvcore.evidence.table import evidence_table
from nvcore.evidence.units import find_units
from nvcore.inputs.session import Session
from nvcore.inputs.session.toml_text import parse_toml
from nvcore.notes import Note
from nvcore.report.brief import render_brief
from nvcore.report.files import REPORT_FILES, SESSION_FILE, TABLE_FORMATS, TableFormat, write_report
from nvcore.report.plan import verdict_plan
from nvcore.report.protect_inputs import files_read, refuse_to_replace
from nvcore.report.verdict import Verdict, verdict
from nvcore.tables.boxes.matches import matches_table
from nvcore.tables.result import (
    encounters_table,
    events_table,
    frames_table,
    intervals_table,
    recordings_table,
)
from nvcore.tables.scorecard import score_rows
from nvcore.tables.summary import summary

if TYPE_CHECKING:
    from nvcore.api.figures import Figures

T = TypeVar("T")


def _from_result(read: Callable[[Result], T]) -> cached_property[T]:
    """Declare an attribute of a comparison that is computed from its result on first use."""
    return cached_property(lambda comparison: read(comparison.result))


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Comparison of two systems, as returned by `nvcore.compare`.

    ``print`` shows the scorecard. A notebook shows a table. Tables have the columns of the report's
    files (docs/report.md).

    Attributes
    ----------
    result
        The library's result, with all arrays.
    dataset, params, x, y, venn, exclusivity, boxes, duration_s, lead_time_s, fusion
        See `nvcore.comparison.compare.Result`.
    protocol
        Selection of the pedestrians that the detection measures count.
    frames
        One row per listed frame: counts, distances and similarity of X and Y.
    encounters
        One row per encounter: category and results of X and Y.
    events
        One row per saliency event of either system.
    intervals
        One row per low-similarity interval of either system.
    recordings
        One row per recording: aggregates of X and Y.
    matches
        One row per box of truth, X and Y: its match, and whether it counts.
    summary
        All aggregates, as in ``summary.json``. Undefined values are None.
    """

    result: Result

    dataset = _from_result(lambda result: result.dataset)
    params = _from_result(lambda result: result.params)
    x = _from_result(lambda result: result.x)
    y = _from_result(lambda result: result.y)
    venn = _from_result(lambda result: result.venn)
    exclusivity = _from_result(lambda result: result.exclusivity)
    boxes = _from_result(lambda result: result.boxes)
    duration_s = _from_result(lambda result: result.duration_s)
    lead_time_s = _from_result(lambda result: result.lead_time_s)
    fusion = _from_result(lambda result: result.fusion)
    protocol = _from_result(lambda result: result.dataset.settings.protocol)
    frames = _from_result(frames_table)
    encounters = _from_result(encounters_table)
    events = _from_result(events_table)
    intervals = _from_result(intervals_table)
    recordings = _from_result(recordings_table)
    matches = _from_result(matches_table)
    summary = _from_result(summary)

    def of(self, subject: str) -> Any:
        """Return a subject's view of the comparison: ``comparison.of("time_left").over_speed``."""
        return self.result.of(subject)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Audit findings about the input files and the session's pictures, worst first."""
        return worst_first([*self.input_findings, *picture_findings(self.dataset)])

    @cached_property
    def figures(self) -> Figures:
        """Plotly figures, such as ``figures.venn()``. They need the extra ``report``."""
        with needs("report", "figures need"):
            from nvcore.api.figures import Figures

        return Figures(self.result)

    def evidence(self) -> pd.DataFrame:
        """Return one row per measure of the verdict: difference, 95 % interval, p, effect."""
        return self._evidence.copy()

    def verdict(self) -> tuple[str, ...]:
        """Return the verdict as sentences, claims first."""
        return self._verdict.sentences

    @property
    def claims(self) -> tuple[Claim, ...]:
        """Differences that the verdict finds significant, each with measure, winner and p-value."""
        return self._verdict.claims

    @property
    def how_sure(self) -> Graded:
        """Probability that Y misses fewer encounters in a typical recording, and its numbers."""
        graded = self._companions.graded
        assert graded is not None
        return graded

    @method_with(PlanArguments)
    def plan(self, asked: PlanArguments) -> Plan:
        """Plan how many recordings like these would show a difference, or non-inferiority.

        If X and Y have unequal false alarms, the plan is for equal false alarms.

        Raises
        ------
        ParameterError
            If a study cannot be planned for this measure, or a value is outside its range.
        """
        result = at_operating_point(self.result, "equal-alarms")
        return plan_recordings(result, asked, protocol=self.protocol)

    def write(
        self, folder: str | Path, *, tables: TableFormat = "csv", matches: bool = False
    ) -> None:
        """Write the tables, ``summary.json`` and ``session.toml`` into a folder.

        Parameters
        ----------
        tables
            Format of the tables: ``"csv"`` or ``"parquet"``.
        matches
            True to also write ``matches.parquet``: `matches`, a row for each box.

        Raises
        ------
        InputError
            If the folder cannot be written to, or an input or the user's session file would be
            replaced.
        """
        folder = Path(folder)
        if tables not in TABLE_FORMATS:
            raise ParameterError(f"tables: expected csv or parquet, got {tables!r}")
        self._protect_inputs([folder / name for name in REPORT_FILES if name != SESSION_FILE])
        _protect_session(folder / SESSION_FILE)
        kinds: dict[str, Any] = {"tables": tables, "matches": matches}
        write_report(self.result, self.dataset.settings, folder, self.findings, **kinds)

    @method_with(HtmlArguments)
    def write_html(self, arguments: HtmlArguments) -> None:
        """Write the comparison as one self-contained HTML file, using the extra ``report``.

        Parameters
        ----------
        path
            File to write.

        Raises
        ------
        InputError
            If the file cannot be written, or is an input.
        MissingExtraError
            If the extra is not installed.
        """
        with needs("report", "the HTML report needs"):
            from nvcore.report.html import write_html_report

        path = Path(arguments.path)
        self._protect_inputs([path])
        write_html_report(
            self.result,
            self.dataset.settings,
            self.findings,
            path,
            stability=arguments.stability,
            inscription=arguments,
            look=add_look(arguments.looks, self.result, self.protocol),
        )

    @cached_property
    def input_findings(self) -> tuple[Finding, ...]:
        """Findings that can affect numbers: all `findings` except those on pictures."""
        return audit(self.dataset, self.params, x=self.x.name, y=self.y.name)

    @cached_property
    def _evidence(self) -> pd.DataFrame:
        units = find_units(self.result)
        return evidence_table(self.result, self.protocol, units=units, miss_rate=self._miss_rate)

    @cached_property
    def _miss_rate(self) -> Judged:
        return judge_miss_rate(self.result, find_units(self.result), self.protocol)

    @cached_property
    def _companions(self) -> Companions:
        return find_companions(
            self.result, self._evidence, self.protocol, miss_rate=self._miss_rate
        )

    @cached_property
    def _verdict(self) -> Verdict:
        return verdict(
            *(self.result, self.input_findings),
            evidence=self._evidence,
            companions=self._companions,
            plan=self._plan,
        )

    @cached_property
    def _plan(self) -> tuple[Note, ...]:
        return verdict_plan(self.result, self._evidence, self._companions)

    def _protect_inputs(self, outputs: Sequence[Path]) -> None:
        settings = self.dataset.settings
        if isinstance(settings, Session):
            refuse_to_replace(outputs, files_read(settings))

    def __str__(self) -> str:
        return render_brief(self.result, self.input_findings, self._verdict)

    def __repr__(self) -> str:
        means = " and ".join(number(system.summary.mean, ".4f") for _, system in self.result.sides)
        return (
            f"<Comparison of {one_line(self.x.name)} (X) and {one_line(self.y.name)} (Y): "
            f"{count_text(len(self.dataset.recordings), 'recording')}, "
            f"{count_text(len(self.dataset.frames), 'frame')}, "
            f"{count_text(self.venn.n_near, 'encounter')}, mean similarity {means}>"
        )

    def _repr_html_(self) -> str:
        head = ["", *(f"{letter.upper()}: {one_line(s.name)}" for letter, s in self.result.sides)]
        rows = [
            (
                "\u2003" * row.level + row.label + ARROWS[row.better],
                number(row.x, row.form),
                number(row.y, row.form),
                difference(row.x, row.y, row.form),
            )
            for table in (MeasureTable.SCORECARD, MeasureTable.MISS_CLASSES)
            for row in score_rows(self.result, table)
        ]
        table = pd.DataFrame(rows, columns=[*head, "X - Y"]).to_html(index=False, border=0)
        return f"<p>{escape(repr(self)[1:-1])}</p>{table}"


def _protect_session(path: Path) -> None:
    """Raise an error if writing a report would replace a session file written by hand."""
    if not path.is_file():
        return
    try:
        is_ours = "written" in parse_toml(path.read_bytes(), file=path)
    except (OSError, InputError):
        is_ours = False
    if not is_ours:
        raise InputError(
            "is a session file that was written by hand, and would be replaced; write to another "
            "folder",
            file=path,
        )
