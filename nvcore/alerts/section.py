"""Section about alerts: how many of each kind, and what the score threshold would change."""

from __future__ import annotations

from typing import Final

from nvcore.alerts.figures.trade_off import alert_trade_off
from nvcore.alerts.kinds import ALERT_TEXT, AlertKind
from nvcore.alerts.said import alert_facts
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.params import Params
from nvcore.report.html.blocks import Chart, Intro, Section, SectionOf, Sentences, Table, table
from nvcore.sentences import say


def _section(result: Result) -> Section:
    """The alerts of both systems by kind, and the trade-off curve."""
    sentences = tuple(say(fact, result.objects) for fact in alert_facts(result))
    figure = alert_trade_off(result, theme=result.scheme("light"))
    in_words = "Urgent encounters alerted in time over unwanted alerts per hour, X and Y"
    blocks = (Sentences(sentences), _kinds(result), Chart("alert-trade-off", figure, in_words))
    return Section("alerts", "Alerts", _introduction(result.params), blocks)


def _introduction(params: Params) -> Intro:
    distance_m = params.alert_distance_m
    within = "" if distance_m is None else f" or, where it is reported, within {distance_m:g} m"
    return Intro(
        what="Which detections reach the driver as alerts, and which of these were worth it.",
        how="Unless a system has a policy or a log of its own, an alert begins once the boxes of a "
        f"track have had a proximity weight of {params.alert_k:g} or more{within}, and were no "
        f"farther from the middle than {params.alert_corridor:g} of half the width, for "
        f"{params.alert_on_s:g} s. It ends when they have not for {params.alert_off_s:g} s, and "
        f"lasts {params.alert_least_s:g} s at least; the same track is then silent for "
        f"{params.alert_pause_s:g} s. An alert is about the {{one}} {{whom}} its first box matches "
        "that matches {anybody}. In time is one that begins before the last chance to brake, "
        "which has the reaction time in it.",
        best="All urgent {many} alerted in time, no alert unwanted.",
        limits="An alert in time could have been heeded; whether it would have been is not known. "
        "Where it is not known whether the driver sees the {one}, redundant alerts are not told "
        "from needed ones, and the unwanted ones are at least so many.",
    )


def _kinds(result: Result) -> Table:
    view = alerts_in(result)
    counts = [view.count(system) for _, system in result.sides]
    rows = [
        (
            kind.value,
            *(f"{count[kind]:,}" for count in counts),
            result.objects.say(ALERT_TEXT[kind]),
        )
        for kind in AlertKind
    ]
    head = ("Alerts", "X", "Y", "Meaning")
    return table("Alerts by what they were worth", head, rows, right=(1, 2))


SECTIONS: Final = (
    SectionOf("alerts", _section, applies=lambda result: alerts_in(result).is_asked),
)
"""Sections of the HTML report."""
