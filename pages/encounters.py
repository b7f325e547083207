"""Encounters: one row for each pedestrian that was met, how X and Y did, and why."""

import streamlit as st

from nvcore.comparison import Result
from nvcore.tables.result import encounters_table
from ui.encounters import figures, filters, table
from ui.shell.messages import draw_warnings, needs_comparison
from ui.widgets.text import docs_link


@st.fragment
@needs_comparison
def draw_filtered(result: Result) -> None:
    """What passes the filters; a filter that is moved redraws nothing but this."""
    encounters = filters.draw(encounters_table(result))
    table.draw(result, encounters)
    figures.draw_classes(result, encounters)


@needs_comparison
def draw(result: Result) -> None:
    """The encounters, and what the systems would be together."""
    if not len(result.encounters):
        st.info("The truth has no pedestrians: there is nobody to meet, and nobody to miss.")
        return
    st.caption(
        f"An {docs_link('encounter', 'encounters')} is one pedestrian of one recording, met once. "
        "It counts in its *relevant* frames, those in which the pedestrian is near enough to "
        "matter (k ≥ 0.5); without any it is *distant*. A system *detects* it by matching it in "
        f"enough of them; the {docs_link('miss class', 'miss-classes')} says how it failed, "
        f"the {docs_link('severity', 'severity')} what its failures weigh: seconds of a pedestrian "
        "missed straight ahead and near."
    )
    draw_warnings(result)
    draw_filtered()
    figures.draw_exclusivity(result)
    figures.draw_fusion(result)


st.title("Encounters")
draw()
