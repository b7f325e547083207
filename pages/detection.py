"""Detection: what X and Y find over all score thresholds, in the terms of the benchmarks."""

import streamlit as st

from ui.detection import curves, protocol
from ui.session import state
from ui.shell.messages import draw_caution, one_system_only
from ui.widgets.text import docs_link

st.title("Detection")
result = state.result()
if result is None:
    one_system_only()
else:
    st.caption(
        "Curves over all score thresholds, from the same matching as everything else. They count "
        "boxes, not encounters, and every counted box weighs the same "
        f"({docs_link('Detection curves', 'detection-curves', doc='detection')})."
    )
    draw_caution(result, is_of_encounters=False)
    chosen = protocol.choose(result.dataset)
    curves.draw(result, chosen)
