"""Alerts as text for the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
import pandas as pd

from nvcore.alerts.measures import MEASURES
from nvcore.alerts.said import alert_facts, in_time_by_kind
from nvcore.alerts.speeding import ROWS
from nvcore.alerts.steps import AlertsView
from nvcore.report.terminal import code_lines
from nvcore.sentences import say
from nvcore.tables.scorecard import score_rows
from nvcore.time_left.said import urgent
from nvcore.wording import aligned, number, one_line

MOST_SHOWN: Final = 8
"""Points of each curve that are printed."""
_HEAD: Final = ("", "score from", "unwanted", "alerted", "in time")


def render_alerts(view: AlertsView) -> str:
    """What there is to say, the measures, and the curves in some of their points."""
    result = view.result
    lines = [
        *(f"{letter.upper()}: {one_line(system.name)}" for letter, system in result.sides),
        "",
        *_sentences(view),
        *code_lines(result),
        "",
        *aligned([("", "X", "Y"), *_measures(view)]),
        *_speeding(view),
        "",
        "over the score threshold, the rest of the policy as it is:",
        *aligned([row if view.has_urgency else row[:-1] for row in (_HEAD, *_curve(view))]),
    ]
    return "\n".join(line.rstrip() for line in lines)


def _sentences(view: AlertsView) -> Iterator[str]:
    """What is said before the numbers; who is urgent at which speed, as all else rests on it."""
    result = view.result
    yield from (say(fact, result.objects) for fact in alert_facts(result))
    if (of_urgent := urgent(result)) is not None:
        yield f"{say(of_urgent, result.objects)}."
    yield from (say(fact, result.objects) for fact in in_time_by_kind(result))


def _measures(view: AlertsView) -> Iterator[tuple[str, ...]]:
    own = {measure.key for measure in MEASURES}
    for row in score_rows(view.result):
        if row.key in own:
            values = (number(value, row.form) for value in (row.x, row.y))
            yield "  " * row.level + row.label, *values


def _speeding(view: AlertsView) -> Iterator[str]:
    """The speed alerts of both systems, where there are any."""
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
