"""Systems page: every pair of the open systems against each other."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.session import state
from ui.shell.messages import draw_warnings, needs_comparison
from ui.views.systems import matrix, numbers, pairs
from ui.widgets.text import docs_link


@needs_comparison
def draw(result: Result) -> None:
    """Draw the better system of each pair and measure, then the numbers."""
    if len(result.dataset.systems) == 2:
        pairs.draw_only_pair(result)
        return
    st.caption(
        "Every pair of the open systems, each at its own threshold, by two measures: the share of "
        "encounters that they detect, and mean similarity. p is corrected for all pairs and both "
        "measures, and a difference is claimed only where it holds at equal false alarms "
        f"as well ({docs_link('Significance', 'three-systems-and-more', doc='significance')})."
    )
    draw_warnings(result)
    table = matrix.draw(result)
    if table is not None:
        theme = state.theme()
        pairs.draw(table)
        numbers.draw(table, result.dataset.systems, theme.shade)


st.title("Systems")
draw()
