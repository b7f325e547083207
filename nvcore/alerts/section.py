"""Section about alerts: number of each kind, and the effect of the score threshold."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from nvcore.alerts.episodes import ALERT_TEXT, AlertKind
from nvcore.alerts.in_time import DRIVER_WORDS
from nvcore.alerts.notes import alert_notes, doubt_of_kind, in_time_by_kind
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.report.section import (
    Block,
    Chart,
    Paragraphs,
    Section,
    SectionOf,
    about,
    table,
)
from nvcore.wording import number

if TYPE_CHECKING:
    import plotly.graph_objects as go


def _section(result: Result) -> Section:
    """Return the report section on both systems' alerts by kind, with the trade-off curve."""
    has_urgency = alerts_in(result).has_urgency

    def trade_off() -> go.Figure:
        from nvcore.alerts.figures import alert_trade_off

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
        from nvcore.alerts.figures import alerts_in_time

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
