"""Detectors page: test a detector on a frame, inspect it, and run it over recordings."""

import streamlit as st

from ui.subjects.detectors import choose, frame, run

st.title("Detectors")
st.caption(
    "A detector, run over the pictures of what is open, is a system like any other: its boxes are "
    "compared with those of the others."
)
run.draw_way_back()
spec = choose.draw()
run.draw_last(None if spec is None else frame.draw(spec))
