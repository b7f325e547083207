"""Section about alerts: how many of each kind, and what the score threshold would change."""

from __future__ import annotations

from typing import Final

from nvcore.alerts.episodes import ALERT_TEXT, AlertKind
from nvcore.alerts.figures.in_time import alerts_in_time
from nvcore.alerts.figures.trade_off import alert_trade_off
from nvcore.alerts.in_time import DRIVER_WORDS
from nvcore.alerts.notes import alert_notes, doubt_of_kind, in_time_by_kind
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.notes import say
from nvcore.report.html.blocks import (
    Block,
    Chart,
    Intro,
    Section,
    SectionOf,
    Sentences,
    table,
)
from nvcore.wording import number

_IN_TIME: Final = (
    " In time is one that begins before the last chance to brake, which has the reaction time in "
    "it."
)
_COULD: Final = "An alert in time could have been heeded; whether it would have been is not known. "


def _section(result: Result) -> Section:
    """The alerts of both systems by kind, and the trade-off curve."""
    sentences = tuple(say(fact, result.objects) for fact in alert_notes(result))
    figure = alert_trade_off(result, theme=result.scheme("light"))
    in_words = "Urgent encounters alerted in time over unwanted alerts per hour, X and Y"
    in_time = (Chart("alert-trade-off", figure, in_words), *_in_time(result))
    counts = [alerts_in(result).count(system) for _, system in result.sides]
    rows = [
        (
            kind.value,
            *(number(count[kind], "d") for count in counts),
            result.objects.say(ALERT_TEXT[kind]),
        )
        for kind in AlertKind
    ]
    head = ("Alerts", "X", "Y", "Meaning")
    blocks = (
        Sentences(sentences),
        table("Alerts by what they were worth", head, rows, right=(1, 2)),
        *(in_time if alerts_in(result).has_urgency else ()),
    )
    return Section("alerts", "Alerts", _introduction(result), blocks)


def _introduction(result: Result) -> Intro:
    params, has_urgency = result.params, alerts_in(result).has_urgency
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
        "that matches {anybody}." + _IN_TIME * has_urgency,
        best="All urgent {many} alerted in time, no alert unwanted."
        if has_urgency
        else "No alert unwanted.",
        limits=_COULD * has_urgency + "Where it is not known whether the driver sees the {one}, "
        "redundant alerts are not told from needed ones, and unwanted ones are at least so many.",
    )


def _in_time(result: Result) -> tuple[Block, ...]:
    """In how many urgent encounters drivers react in time; empty: nobody is urgent."""
    judged = alerts_in(result).in_time_for_drivers
    if judged.chances.empty:
        return ()
    figure = alerts_in_time(result, theme=result.scheme("light"))
    kinds = list(dict.fromkeys(judged.table["kind"]))
    facts = (*in_time_by_kind(result), *(doubt_of_kind(judged, kind) for kind in kinds))
    say_driver = {name: result.objects.say(words) for name, words in DRIVER_WORDS.items()}
    rows = [
        (kind, say_driver[driver], *(number(share, ".0f") for share in shares))
        for kind in kinds
        for driver, *shares in judged.of_hundred(kind).itertuples()
    ]
    head = ("Alert", "The driver", "Of 100", "X and Y in time", "Only X", "Only Y", "Neither")
    return (
        Chart("alerts-in-time", figure, "Shares in time by kind of alert, X and Y"),
        Sentences(tuple(say(fact, result.objects) for fact in facts)),
        table("Of 100 urgent encounters (ours)", head, rows, right=(2, 3, 4, 5, 6)),
    )


SECTIONS: Final = (
    SectionOf("alerts", _section, applies=lambda result: alerts_in(result).is_asked),
)
"""Sections of the HTML report."""
