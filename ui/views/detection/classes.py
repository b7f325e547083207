"""Detection page: found objects and their predicted classes."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.figures.maps import classes_plot
from nvcore.report.words import classes_read
from nvcore.tables.classes import classes_table, has_classes, names_classes
from ui.session import state
from ui.widgets.charts import draw_chart
from ui.widgets.text import docs_link, plain


def draw(result: Result) -> None:
    """Draw the classes predicted by X and Y, if the truth and any of them name classes."""
    if not has_classes(result):
        return
    st.header("Classes")
    st.caption(
        state.say(
            "Matched {many} by the class that the truth gives them and the one that was read, "
            "at the thresholds of the sidebar. To count only what was read right, let a detection "
            "match {many} of its own class alone (Advanced) "
        )
        + f"({docs_link('Classes', 'classes', doc='objects')})."
    )
    table = classes_table(result)
    for place, (letter, system) in zip(st.columns(2), result.sides, strict=True):
        with place:
            if names_classes(result, system):
                figure = classes_plot(table, letter, system.name, theme=state.theme())
                draw_chart(figure, f"classes_{letter}")
            st.caption(plain(state.say(classes_read(result, table, letter))))
