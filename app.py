"""The dashboard: ``streamlit run app.py``, or ``streamlit run app.py -- --local-root DIR``."""

from pathlib import Path

import streamlit as st

from ui.session.routes import ROUTES
from ui.shell.messages import error_banner

app = st.App(Path(__file__).parent / "ui" / "main.py", routes=ROUTES, on_script_error=error_banner)
