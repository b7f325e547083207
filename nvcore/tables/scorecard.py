"""Tables of measures, X beside Y, for the terminal, the dashboard and the reports."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Final, NamedTuple

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Better, Measure, MeasureTable
from nvcore.comparison.measures.table import (
    applies_to,
    doubt_of,
    hides_rate,
    label_words,
    measure_of,
    measures_in,
)
from nvcore.metrics.detection.curve_summary import CurveSummary

LEADING: Final = tuple(
    measure.key for measure in measures_in(MeasureTable.SCORECARD) if measure.leads
)
"""Measures that are shown unless all are requested."""


class ScoreRow(NamedTuple):
    """Values of one measure for X and Y, with label and format.

    Attributes
    ----------
    label
        Name of the measure, with unit and denominator.
    x, y
        Values. NaN is undefined.
    form
        Format specification of the values.
    better
        ``higher`` or ``lower``. Empty: neither.
    is_doubtful
        True if nothing is claimed of it for any values (`measures.table.doubt_of`).
    level
        0, or 1 for a part of the row above.
    needs_tracks
        True if it and its parts mean little while most encounters are one frame long.
    key
        Key of the measure.
    """

    label: str
    x: float
    y: float
    form: str
    better: Better
    level: int = 0
    needs_tracks: bool = False
    key: str = ""
    is_doubtful: bool = False

    @property
    def winner(self) -> str:
        """System with the better value as shown, ``x`` or ``y``. Empty if equal or in doubt."""
        if not self.better or self.is_doubtful or math.isnan(self.x) or math.isnan(self.y):
            return ""
        if format(self.x, self.form) == format(self.y, self.form):
            return ""
        return "x" if (self.x > self.y) == (self.better == "higher") else "y"


def pick_rows(result: Result, rows: Sequence[ScoreRow], keys: Collection[str]) -> list[ScoreRow]:
    """Select the rows of `score_rows` with these keys, giving each its full label."""
    words = label_words(result)
    return [
        row._replace(label=result.objects.say(measure_of(row.key).label, **words), level=0)
        for row in rows
        if row.key in keys
    ]


def score_rows(result: Result, table: MeasureTable = MeasureTable.SCORECARD) -> list[ScoreRow]:
    """Return a row for each measure of a table: scorecard, miss classes or false alerts."""
    words = label_words(result)
    rows: list[ScoreRow] = []
    tracked: set[int] = set()  # rows that need tracks, by the row that contains them
    whole = 0
    for measure in measures_in(table):
        if measure.of is None or not applies_to(result, measure):
            continue
        if hides_rate(measure, result.duration_s):
            tracked |= {whole} if _needs_tracks(measure) else set()
            continue  # the number that contains it says as much
        # the table of false alerts has no rows that are parts of others
        part = "" if table is MeasureTable.FALSE_ALERTS else measure.part
        x, y = (measure.of(result, system) for _, system in result.sides)
        label = result.objects.say(part or measure.label, **words)
        whole = whole if part else len(rows)
        if table is not MeasureTable.SCORECARD or _needs_tracks(measure):
            tracked.add(whole)
        rows.append(
            ScoreRow(
                label,
                x,
                y,
                measure.form,
                measure.better,
                1 if part else 0,
                key=measure.key,
                is_doubtful=bool(doubt_of(result, measure)),
            )
        )
    whole = 0
    for i, row in enumerate(rows):
        whole = whole if row.level else i
        rows[i] = row._replace(needs_tracks=whole in tracked)
    return rows


def _needs_tracks(measure: Measure) -> bool:
    return measure.inference is not None and measure.inference.needs_tracks


def curve_rows(x: CurveSummary, y: CurveSummary) -> list[ScoreRow]:
    """Return a row for each measure of the detection curves of X and Y."""
    return [
        ScoreRow(measure.label, of(x), of(y), measure.form, measure.better, key=measure.key)
        for measure in measures_in(MeasureTable.DETECTION)
        if (of := measure.of_curve) is not None
    ]
