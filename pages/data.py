"""Data: what is open, what is wrong with it, what else to open, which two systems to compare."""

import streamlit as st

from ui import data_compare, data_findings, data_inputs, data_open

st.title("Data")
for part in (data_findings, data_inputs, data_open, data_compare):
    with st.container():  # one place each: an upload goes on when there is more or less above it
        part.draw()
