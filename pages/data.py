"""Data: what is open, what is wrong with it, at which thresholds, what else to open."""

import streamlit as st

from ui.data import choose, compare, inputs
from ui.data.audit import findings
from ui.data.opening import draw_outcome, new_place

st.title("Data")
for draw in (draw_outcome, choose.draw, findings.draw, compare.draw, inputs.draw):
    with new_place(draw):  # one each: an upload goes on when there is more or less above it
        draw()
