"""Driver page: how detectable the chosen pedestrian is from frame to frame."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison import Result
from nvcore.figures.driver.course import detectability_course_plot
from nvcore.tables.encounters.driver import detectability_course
from ui.session import state
from ui.session.chosen import choose_encounter, name_of
from ui.shell.navigate import open_row
from ui.widgets.charts import clicked_chart
from ui.widgets.text import plain


def draw(result: Result, encounter: int) -> None:
    """Detectability over time; a click opens the frame in the Timeline."""
    recording, _, track = name_of(result, encounter).rpartition(":")
    st.subheader(f"{state.words('Pedestrian')} {track} of {plain(recording)}")
    figure = detectability_course_plot(
        detectability_course(result, encounter),
        threshold=result.params.driver_threshold,
        theme=state.theme(),
    )
    row = clicked_chart(figure, f"driver_course_{encounter}", clicks="driver_course")
    st.caption("Click a mark to open its frame in the Timeline.")
    if row is not None:
        choose_encounter(result, encounter)
        open_row(int(row))
