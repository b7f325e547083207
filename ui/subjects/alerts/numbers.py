"""Alerts page: how many alerts of each kind an hour, and the trade-off over the score threshold."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.subjects.alerts.figures import alert_trade_off
from nvcore.subjects.alerts.measures import MEASURES
from nvcore.subjects.alerts.steps import alerts_in
from nvcore.tables.scorecard import score_rows
from ui.session import state
from ui.session.results import comparison_key
from ui.subjects.alerts.policy import own_policies
from ui.widgets.charts import clicked_chart, kept_figure
from ui.widgets.html import measures_html, score_row
from ui.widgets.text import docs_link

KEYS = frozenset(measure.key for measure in MEASURES)


def draw(result: Result) -> None:
    """The measures beside the curve."""
    left, right = st.columns([4, 5], gap="large")
    with left:
        rows = [
            score_row(row, is_short=result.is_short)
            for row in score_rows(result)
            if row.key in KEYS
        ]
        st.html(measures_html(rows, key="alerts"))
        st.caption(
            "Whether a difference is more than chance is tested on the Overview "
            f"({docs_link('measures', 'measures', doc='alerts')})."
        )
    if alerts_in(result).has_urgency:
        with right:
            _draw_curve(result)


def _draw_curve(result: Result) -> None:
    theme = state.theme()
    moved = [letter.upper() for letter, _ in result.sides if letter not in own_policies(result)]
    click = "Click a point: {} from that score on."
    click = click.format(f"{moved[0]} alerts" if len(moved) == 1 else "both alert") if moved else ""
    figure = kept_figure(
        "alerts_trade_off",
        (comparison_key(result), theme),
        lambda: alert_trade_off(result, theme=theme),
    )
    threshold = clicked_chart(
        figure,
        "alerts_trade_off",
        help=state.say(
            "Up and left is better: more {many} alerted in time, fewer that the driver could do "
            "without. Each point is the same policy with another score threshold; the large "
            "mark is the one in use. {click}",
            click=click,
        ),
    )
    if threshold is not None and moved:
        state.set_params(alert_score=float(threshold))
        st.rerun()
