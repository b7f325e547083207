"""Alerts in the verdict, in the report and in the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np
import pandas as pd

from nvcore.common.wording import aligned, number, one_line
from nvcore.comparison.compare import Result
from nvcore.metrics.encounter_classes import classes_of
from nvcore.notes import say
from nvcore.report.section import Block, Chart, Paragraphs, Section, SectionOf, about, table, worded
from nvcore.report.sections.encounters import by_class
from nvcore.report.terminal import block_lines
from nvcore.report.verdict import PointOf
from nvcore.subjects.alerts.episodes import ALERT_TEXT, AlertKind
from nvcore.subjects.alerts.in_time import DRIVER_WORDS
from nvcore.subjects.alerts.measures import MEASURES
from nvcore.subjects.alerts.notes import alert_notes, doubt_of_kind, in_time_by_kind
from nvcore.subjects.alerts.speeding import ROWS
from nvcore.subjects.alerts.steps import AlertsView, alerts_in
from nvcore.subjects.time_left.notes import urgent
from nvcore.tables.scorecard import score_rows

if TYPE_CHECKING:
    import plotly.graph_objects as go


MOST_SHOWN: Final = 8
"""Maximum number of printed points of each curve."""

POINTS: Final = (PointOf("Alerts", alert_notes, after="The driver"),)


def render_alerts(view: AlertsView) -> str:
    """Return remarks, measures, and selected points of the threshold curves as text."""
    result, own = view.result, {measure.key for measure in MEASURES}
    sentences = [say(fact, result.objects) for fact in alert_notes(result)]
    if (of_urgent := urgent(result)) is not None:  # the speed: all else depends on it
        sentences.append(say(of_urgent, result.objects))
    sentences += [say(fact, result.objects) for fact in in_time_by_kind(result)]
    rows = [
        ("  " * row.level + row.label, number(row.x, row.form), number(row.y, row.form))
        for row in score_rows(result)
        if row.key in own
    ]
    coded = filter(None, [by_class(result)] if classes_of(result.dataset).coded else [])
    curve = [("", "score from", "unwanted", "alerted", "in time"), *_curve(view)]
    lines = [
        *(f"{letter.upper()}: {one_line(system.name)}" for letter, system in result.sides),
        "",
        *sentences,
        *block_lines(worded(coded, result.objects)),
        "",
        *aligned([("", "X", "Y"), *rows]),
        *_speeding(view),
        "",
        "over the score threshold, the rest of the policy as it is:",
        *aligned([row if view.has_urgency else row[:-1] for row in curve]),
    ]
    return "\n".join(line.rstrip() for line in lines)


def _speeding(view: AlertsView) -> Iterator[str]:
    """Yield lines about alerts of excessive speed of both systems, if there are any."""
    if view.speeding is None:
        return
    yield ""
    yield f"speed alerts, above the limit for {view.result.params.speeding_after_s:g} s:"
    x, y = view.speeding.summary().to_dict("records")
    rows = [
        (words.format(true=x["true"]), *(number(row[name], form) for row in (x, y)))
        for name, (words, form) in ROWS.items()
    ]
    yield from aligned([("", "X", "Y"), *rows])


def _curve(view: AlertsView) -> Iterator[tuple[str, ...]]:
    curve = view.curve
    for letter, _ in view.result.sides:
        own = curve[curve["system"] == letter]
        points = own[own["of"] == "policy"]
        shown = np.unique(np.linspace(0, len(points) - 1, MOST_SHOWN).round().astype(int))
        others = own[own["of"] != "policy"]
        for row in pd.concat([points.iloc[shown], others]).to_dict("records"):
            name = letter.upper() if row["of"] == "policy" else f"{letter.upper()}, {row['of']}"
            yield (
                name,
                "every box" if np.isneginf(row["threshold"]) else number(row["threshold"], ".4g"),
                str(row["unwanted"]),
                str(row["alerted"]),
                str(row["in_time"]),
            )


def _section(result: Result) -> Section:
    """Return the report section on both systems' alerts by kind, with the trade-off curve."""
    has_urgency = alerts_in(result).has_urgency

    def trade_off() -> go.Figure:
        from nvcore.subjects.alerts.figures import alert_trade_off

        return alert_trade_off(result, theme=result.scheme("light"))

    counts = [alerts_in(result).count(system) for _, system in result.sides]
    rows = [
        (
            kind.value,
            *(number(count[kind], "d") for count in counts),
            result.objects.say(ALERT_TEXT[kind]),
        )
        for kind in AlertKind
    ]
    in_words = "Urgent encounters alerted in time over unwanted alerts per hour, X and Y"
    in_time = (Chart("alert-trade-off", trade_off, in_words), *_in_time(result))
    blocks: tuple[Block, ...] = (
        Paragraphs(tuple(alert_notes(result))),
        table(
            "Alerts by what they were worth", ("Alerts", "X", "Y", "Meaning"), rows, right=(1, 2)
        ),
        *(in_time if has_urgency else ()),
    )
    introduction = about("alerts.section", result, has_urgency=has_urgency)
    return Section("alerts", "Alerts", introduction, blocks)


def _in_time(result: Result) -> tuple[Block, ...]:
    """Return blocks on reactions in time to alerts, or none if no encounter is urgent."""
    judged = alerts_in(result).in_time_for_drivers
    if judged.chances.empty:
        return ()

    def shares_in_time() -> go.Figure:
        from nvcore.subjects.alerts.figures import alerts_in_time

        return alerts_in_time(result, theme=result.scheme("light"))

    kinds = list(dict.fromkeys(judged.table["kind"]))
    notes = (*in_time_by_kind(result), *(doubt_of_kind(judged, kind) for kind in kinds))
    words = {name: result.objects.say(words) for name, words in DRIVER_WORDS.items()}
    rows = [
        (kind, words[driver], *(number(share, ".0f") for share in shares))
        for kind in kinds
        for driver, *shares in judged.of_hundred(kind).itertuples()
    ]
    head = ("Alert", "The driver", "Of 100", "X and Y in time", "Only X", "Only Y", "Neither")
    return (
        Chart("alerts-in-time", shares_in_time, "Shares in time by kind of alert, X and Y"),
        Paragraphs(notes),
        table("Of 100 urgent encounters (ours)", head, rows, right=range(2, 7)),
    )


SECTIONS: Final = (
    SectionOf("alerts", _section, applies=lambda result: alerts_in(result).is_asked),
)
