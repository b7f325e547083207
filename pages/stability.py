"""Stability page: whether the verdict depends on settings that the analyst may choose freely."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.shell.messages import draw_notices, needs_comparison
from ui.views.stability import survey, verdict_map
from ui.widgets.text import docs_link


@needs_comparison
def draw(result: Result) -> None:
    """Draw a table of all settings, then a map over two of them."""
    st.caption(
        "Weights, thresholds and matching rules are choices of whoever compares. Each map shows "
        "who is better for every choice, all else as in the sidebar; a verdict that holds over the "
        "plausible range does not depend on them "
        f"({docs_link('Stability', 'stability', doc='significance')})."
    )
    draw_notices(result)
    above = st.container()  # filled last, because the map is ready earlier
    verdict_map.draw(result)
    with above:
        survey.draw(result)


st.title("Stability")
draw()
