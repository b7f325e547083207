"""The dashboard: ``streamlit run app.py``, or ``streamlit run app.py -- --local-root DIR``."""

from pathlib import Path

import streamlit as st

from ui.routes import ROUTES
from ui.trouble import show_trouble

app = st.App(Path(__file__).parent / "ui" / "main.py", routes=ROUTES, on_script_error=show_trouble)
