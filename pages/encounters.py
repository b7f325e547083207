"""Encounters: one row for each pedestrian that was met, how X and Y did, and why."""

import streamlit as st

from nvcore.tables.result import encounters_table
from ui.encounters import figures, filters, table
from ui.session import state
from ui.shell.messages import draw_caution, one_system_only
from ui.widgets.text import docs_link


@st.fragment
def draw_filtered() -> None:
    """What the filters choose; a filter draws nothing but this again."""
    result = state.result()
    kept = filters.draw(encounters_table(result))
    table.draw(result, kept)
    figures.draw_classes(result, kept)


st.title("Encounters")
result = state.result()
if result is None:
    one_system_only()
elif not len(result.encounters):
    st.info("The truth has no pedestrians: there is nobody to meet, and nobody to miss.")
else:
    st.caption(
        f"An {docs_link('encounter', 'encounters')} is one pedestrian of one recording, met once. "
        "It counts in its *relevant* frames, those in which the pedestrian is near enough to "
        "matter (k ≥ 0.5); without any it is *distant*. A system *detects* it by matching it in "
        f"enough of them; the {docs_link('miss class', 'miss-classes')} says how it failed."
    )
    draw_caution(result)
    draw_filtered()
    figures.draw_exclusivity(result)
    figures.draw_fusion(result)
