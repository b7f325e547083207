"""Detectors: try one on a frame, look inside, run it over the recordings as a system to compare."""

import streamlit as st

from ui.detectors import choose, frame

st.title("Detectors")
spec = choose.draw()
if spec is not None:
    frame.draw(spec)
