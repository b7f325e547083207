"""Four summary tiles: pedestrians found, time missed, false alerts, and the worst miss."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import pandas as pd

from nvcore.common.wording import difference, duration_text, minus, number
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import doubt_of, inference_of, measure_of, shown_as
from nvcore.comparison.measures.values import duration_of_recordings
from nvcore.evidence.bootstrap import MIN_UNITS
from nvcore.evidence.claims import Basis, Support, find_claims, values_of
from nvcore.evidence.companions import Companions, is_unsure
from nvcore.evidence.operating_points import are_unequal
from nvcore.evidence.units import MIN_RECORDINGS, WHOLE, count_whole
from nvcore.notes import Note

REACH: Final = 1.12
"""Half the length of a difference's axis, as a multiple of the largest value on it."""
MOST_DECIMALS: Final = 3
"""Maximum number of decimals of an interval beyond those of its measure."""


@dataclass(frozen=True)
class Tile:
    """Contents of a tile: one measure of both systems in short.

    Attributes
    ----------
    key, title, unit
        Key of the measure, its plain description, and its name with unit.
    x, y, difference
        Values and X - Y as text.
    interval
        Interval of the difference. None: the place stays empty.
    bar
        Low end, difference, and high end on an axis from 0 (Y is better) to 1 (X is better), 0.5
        being no difference. None without interval.
    better
        System with the better value here, ``x`` or ``y``. Empty: neither.
    winner
        System for which the difference is claimed to be more than chance. Empty: no claim.
    chip
        The claim, or the reason for making none.
    form
        Format of the values.
    is_doubtful
        True if neither value is called better.
    """

    key: str
    title: str
    unit: str
    x: str
    y: str
    difference: str
    interval: Note | None
    bar: tuple[float, float, float] | None
    better: str
    winner: str
    chip: Note
    form: str
    is_doubtful: bool


@dataclass(frozen=True)
class _Kind:
    """Measure of a tile, and key of the evidence that decides whether a difference is claimed."""

    key: str
    judged: str
    title: str
    unit: str
    form: str


KINDS: Final = (
    _Kind(
        "encounters_detected",
        "encounters_detected_by_unit",
        "{Many} found",
        "encounters detected, of {n_near:,}",
        "d",
    ),
    _Kind(
        "severity_s_per_encounter",
        "severity_s_per_encounter",
        "Time missed",
        "severity per encounter (of {n_near:,}), s",
        ".2f",
    ),
    _Kind(
        "false_alert_episodes_per_hour",
        "false_alert_episodes_per_hour",
        "False-alert episodes",
        "runs of false alarms per hour, from {episodes} in {duration}",
        ".0f",
    ),
    _Kind("worst_severity_s", "", "Worst miss", "severity of one encounter, s", ".1f"),
)


def tiles(
    result: Result,
    evidence: pd.DataFrame | None,
    companions: Companions | None,
    *,
    is_being_tested: bool = False,
) -> tuple[Tile, ...]:
    """Return the four tiles, moving those that are 0 for both systems to the end.

    Parameters
    ----------
    evidence, companions
        See `nvcore.report.verdict.verdict`.
    is_being_tested
        True if a measure without evidence is still being tested.
    """
    support, rows = Support(Basis.NONE), {}
    if not are_unequal(result):
        support = find_claims(result, evidence, companions)
        of_evidence = [] if evidence is None else evidence.to_dict("records")
        rows = {row["figure"]: row for row in of_evidence}
    four = (
        _tile(kind, result, rows.get(kind.judged), support, is_being_tested=is_being_tested)
        for kind in KINDS
    )
    return tuple(sorted(four, key=lambda tile: values_of(tile.key, result) == (0, 0)))


def _tile(
    kind: _Kind,
    shown: Result,
    row: Mapping[Hashable, Any] | None,
    support: Support,
    *,
    is_being_tested: bool,
) -> Tile:
    x, y = values_of(kind.key, shown)
    is_count = kind.form == "d"
    form = ".0f" if is_count else kind.form
    times = shown.venn.n_near if is_count else 1.0  # a share of encounters as their number
    unit = kind.unit
    if kind.key == kind.judged:
        factor, per = shown_as(kind.key, shown)
        if factor != 1:
            x, y, times, unit = factor * x, factor * y, factor, f"runs of false alarms{per}"
    text_x, text_y = (number(value, form) for value in (x, y))
    measure = measure_of(kind.key)
    is_lower = measure.better == "lower"
    is_doubtful = bool(doubt_of(shown, measure))
    is_even = text_x == text_y or x == y or is_doubtful
    better = "" if is_even else "x" if (x < y) == is_lower else "y"
    ends: tuple[float, float, float] | None = None
    interval = _no_interval(row)
    if row is not None and math.isfinite(row["low"]):
        low, middle, high = (times * float(row[name]) for name in ("low", "difference", "high"))
        form_of_ends = ".1f" if is_count else kind.form
        interval = Note("verdict.interval", ends=_interval_text(low, high, form_of_ends))
        ends = _bar(low, middle, high, is_lower=is_lower)
    winner = next((claim.winner for claim in support.claims if claim.key == kind.judged), "")
    return Tile(
        key=kind.key,
        title=shown.objects.say(kind.title),
        unit=unit.format(
            n_near=shown.venn.n_near,
            episodes=" and ".join(
                f"{system.false_alarm_summary.episodes:,}" for _, system in shown.sides
            ),
            duration=duration_text(float(duration_of_recordings(shown).sum())),
        ),
        x=text_x,
        y=text_y,
        difference=minus(difference(x, y, form)),
        interval=interval,
        bar=ends,
        better=better,
        winner=winner,
        chip=Note("verdict.chip_better", winner=winner)
        if winner
        else _chip(kind, shown, row, support, is_being_tested=is_being_tested),
        form=form,
        is_doubtful=is_doubtful,
    )


def _no_interval(row: Mapping[Hashable, Any] | None) -> Note:
    if row is None or not math.isfinite(row["difference"]) or is_unsure(row):  # a chip says it
        return Note("verdict.no_interval")
    if row["n"] >= MIN_UNITS:
        return Note("verdict.no_interval", is_same=row["difference"] == 0)
    noun = "time block" if row["unit"] not in WHOLE else str(row["unit"]).removesuffix("s")
    return Note("verdict.no_interval", n=int(row["n"]), n_needed=MIN_UNITS, noun=noun)


def _interval_text(low: float, high: float, form: str) -> str:
    """Return "low to high" with enough decimals to tell both ends apart and from a false 0."""
    decimals = int(form[1:-1])
    if not decimals and high - low < 10:
        decimals = 1
    for more in range(MOST_DECIMALS + 1):
        shown = [difference(end, 0, f".{decimals + more}{form[-1]}") for end in (low, high)]
        is_zero = any(not text.strip("+-.0 p") for text in shown)
        if shown[0] != shown[1] and not (low * high > 0 and is_zero):
            break
    return minus(" to ".join(shown))


def _bar(low: float, middle: float, high: float, *, is_lower: bool) -> tuple[float, float, float]:
    reach = REACH * max(abs(low), abs(middle), abs(high)) or 1.0
    sign = -1 if is_lower else 1
    ends = sorted(0.5 + 0.5 * sign * end / reach for end in (low, high))
    return ends[0], 0.5 + 0.5 * sign * middle / reach, ends[1]


def _chip(
    kind: _Kind,
    shown: Result,
    row: Mapping[Hashable, Any] | None,
    support: Support,
    *,
    is_being_tested: bool,
) -> Note:
    """Return the reason why a tile claims no difference."""
    if support.basis is Basis.NONE:
        return Note("verdict.chip_unequal")
    if not kind.judged:
        return Note("verdict.chip_single")
    if shown.is_short and inference_of(kind.judged).needs_tracks:
        return Note("verdict.chip_short")
    if row is None:
        return Note("verdict.chip_testing") if is_being_tested else Note("verdict.chip_untested")
    if kind.judged in support.withheld:
        return Note("verdict.chip_withheld", reason=support.withheld[kind.judged])
    if row["unit"] not in WHOLE:
        n, noun = count_whole(shown.dataset)
        return Note("verdict.chip_few", n=n, n_needed=MIN_RECORDINGS, noun=noun)
    if is_unsure(row):
        return Note("verdict.chip_unsure")
    is_same = float(row["x"]) == float(row["y"])
    return Note("verdict.chip_same") if is_same else Note("verdict.chip_not_shown")
