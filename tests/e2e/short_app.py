"""The dashboard with another sample: the session file that ``NVCORE_TEST_SESSION`` names."""

import os
from pathlib import Path

import streamlit as st

from ui import state
from ui.routes import ROUTES
from ui.trouble import show_trouble

state.SAMPLE = Path(os.environ["NVCORE_TEST_SESSION"])
app = st.App(state.ROOT / "ui" / "main.py", routes=ROUTES, on_script_error=show_trouble)
