"""Encounters page: who detects the encounters in each class."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.report.sections.encounters import by_class
from ui.session import state
from ui.session.results import comparison_key
from ui.widgets.section import draw_table_of
from ui.widgets.text import docs_link


def draw(result: Result) -> None:
    """Draw a table with a row for each class of encounters."""
    key = comparison_key(result)
    table = state.cached("by_class", key, lambda: by_class(result), most=8)
    if table is None:
        st.caption("No encounter has a class.")
        return
    from_boxes = ""
    if result.dataset.objects.are_pedestrians:
        from_boxes = (
            "; crossing, in road, group and child also from the boxes alone, by rules of ours "
            f"({docs_link('Metrics', 'classes-of-encounters')})"
        )
    draw_table_of(
        table,
        key="by-class",
        explanation="Classes come from the truth's column *attributes*, and from stretches with a "
        f"code{from_boxes}.",
    )
