"""The sidebar's figure of what a miss would cost, folded away until it is wanted."""

from __future__ import annotations

import streamlit as st

from nvcore.errors import ParameterError
from nvcore.figures.cost_map import cost_plot
from nvcore.wording import capitalised
from ui.session import state
from ui.session.drawing import cost_map_of
from ui.widgets.charts import draw_chart
from ui.widgets.text import plain


def draw() -> None:
    """What missing a pedestrian would cost over the picture of the current recording."""
    place = st.expander("What a miss costs, by place", key="cost_map", on_change="rerun")
    if not place.open:  # folded, it costs neither server nor browser time
        return
    recording = state.recording()
    try:
        cost = cost_map_of(recording)
    except ParameterError:  # the sidebar says it below
        return
    with place:
        draw_chart(
            cost_plot(cost, theme=state.theme(), objects=state.opened().dataset.objects),
            "cost_plot",
            help=state.say(
                "k × border of {a_one} with the {feet} there, 0 to 1, in {where}. {cost}. "
                "Over the picture: Timeline, key c.",
                where=plain(state.recording_names()[recording]),
                cost=plain(capitalised(state.say(cost.text))),
            ),
        )
