"""Data: what is open, what is wrong with it, what else to open, which two systems to compare."""

import streamlit as st

from ui.data import choose, compare, inputs
from ui.data.audit import findings
from ui.data.opening import draw_outcome

st.title("Data")
for draw in (draw_outcome, findings.draw, inputs.draw, choose.draw, compare.draw):
    with st.container():  # one place each: an upload goes on when there is more or less above it
        draw()
