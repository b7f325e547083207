"""Minimal app with a slider, to measure Streamlit's own time."""

import streamlit as st

st.title("Overview")
st.markdown(f"alpha is {st.slider('alpha', 0.0, 1.0, 0.9, key='alpha')}")
