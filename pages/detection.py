"""Detection page: results of X and Y over all score thresholds, in the terms of the benchmarks."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.shell.messages import draw_warnings, needs_comparison
from ui.views.detection import classes, curves, protocol
from ui.widgets.text import docs_link


@needs_comparison
def draw(result: Result) -> None:
    """Draw the choice of the protocol, and the curves under it."""
    st.caption(
        "Curves over all score thresholds, from the same matching as everything else. They count "
        "boxes, not encounters, and every counted box weighs the same "
        f"({docs_link('Detection curves', 'detection-curves', doc='detection')})."
    )
    draw_warnings(result, is_of_encounters=False)
    curves.draw(result, protocol.choose(result.dataset))
    classes.draw(result)


st.title("Detection")
draw()
