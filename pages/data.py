"""Data page: the open session, its problems, score thresholds, and other data to open."""

import streamlit as st

from ui.views.data import choose, compare, inputs
from ui.views.data.audit import findings
from ui.views.data.opening import draw_outcome, new_place

st.title("Data")
for draw in (draw_outcome, choose.draw, findings.draw, compare.draw, inputs.draw):
    # separate containers, so that an upload continues when the content above it changes
    with new_place(draw):
        draw()
