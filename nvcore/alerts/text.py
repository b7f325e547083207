"""Alerts in the verdict, and the terminal's report on alerts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
import pandas as pd

from nvcore.alerts.measures import MEASURES
from nvcore.alerts.notes import alert_notes, in_time_by_kind
from nvcore.alerts.speeding import ROWS
from nvcore.alerts.steps import AlertsView
from nvcore.metrics.encounter_classes import classes_of
from nvcore.notes import say
from nvcore.report.section import worded
from nvcore.report.sections.encounters import by_class
from nvcore.report.terminal import block_lines
from nvcore.report.verdict import PointOf
from nvcore.tables.scorecard import score_rows
from nvcore.time_left.notes import urgent
from nvcore.wording import aligned, number, one_line

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
