"""Alerts page: how often the driver reacts to alerts in time, overall and per 100 encounters."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.subjects.alerts.figures import alerts_in_time
from nvcore.subjects.alerts.in_time import DRIVER_WORDS
from nvcore.subjects.alerts.notes import doubt_of_kind, in_time_by_kind
from nvcore.subjects.alerts.steps import alerts_in
from ui.session import state
from ui.session.results import comparison_key
from ui.widgets.charts import draw_chart, kept_figure
from ui.widgets.choices import choose_side_by_side
from ui.widgets.html import MeasureRow, measures_html
from ui.widgets.text import docs_link, number, plain


def draw(result: Result) -> None:
    """Draw the shares in time by kind of alert, then a table per 100 urgent encounters.

    Nothing is drawn for speed signs, which are never urgent.
    """
    if not alerts_in(result).has_urgency:
        return
    st.header("In time for the driver")
    judged = alerts_in(result).in_time_for_drivers
    if judged.chances.empty:
        st.info(state.say("{Nobody} is urgent at this speed: there is no last chance to miss."))
        return
    for fact in in_time_by_kind(result):
        st.markdown(plain(state.say(fact)))
    link = docs_link("in time", "in-time-for-the-driver", doc="alerts")
    theme = state.theme()
    figure = kept_figure(
        "alerts_in_time",
        (comparison_key(result), theme),
        lambda: alerts_in_time(result, theme=theme),
    )
    draw_chart(
        figure,
        "alerts_in_time",
        help="Reaction times are drawn from a lognormal distribution with mean and SD of the "
        "source's eleven persons. All kinds are judged on the same urgent encounters. Thick: other "
        "drivers on these recordings; thin: another study as large, with other drivers and "
        f"recordings ({link}).",
    )
    st.subheader("Of 100 urgent encounters")
    kinds = [*dict.fromkeys(judged.table["kind"])]
    kind = choose_side_by_side("Kind of alert", kinds, "alerts_reaction", default=kinds[0])
    table = judged.of_hundred(kind)
    rows = [
        MeasureRow(state.say(DRIVER_WORDS[name]), tuple(number(share, ".0f") for share in shares))
        for name, *shares in table.itertuples()
    ]
    head = ("of 100", "X and Y in time", "only X", "only Y", "neither")
    st.html(measures_html(rows, key="alerts-hundred", head=head, first="The driver"))
    st.markdown(plain(state.say(doubt_of_kind(judged, kind))))
    st.caption(
        state.say(
            "The table is ours, not the source's: who has seen the {one} is taken to need no "
            "alert, and every driver is taken to answer every alert. Rounded: a row may be one off."
        )
    )
