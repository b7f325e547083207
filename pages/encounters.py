"""Encounters: one row for each pedestrian that was met, how X and Y did, and why."""

import streamlit as st

from nvcore.tables import encounters_table
from ui import encounters_figures, encounters_filters, encounters_list, state
from ui.caution import draw_caution
from ui.empty import one_system_only
from ui.text import docs_link


@st.fragment
def draw_filtered() -> None:
    """What the filters choose; a filter draws nothing but this again."""
    result = state.result()
    kept = encounters_filters.draw(encounters_table(result))
    encounters_list.draw(result, kept)
    encounters_figures.draw_classes(result, kept)


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
    encounters_figures.draw_exclusivity(result)
    encounters_figures.draw_fusion(result)
