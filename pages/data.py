"""Data: what is open, what is wrong with it, what else to open, which two systems to compare."""

import streamlit as st

from ui import data_compare, data_findings, data_inputs, data_open
from ui.data_opening import draw_outcome

st.title("Data")
for draw in (
    draw_outcome, data_findings.draw, data_inputs.draw, data_open.draw, data_compare.draw,
):  # fmt: skip
    with st.container():  # one place each: an upload goes on when there is more or less above it
        draw()
