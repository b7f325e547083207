"""The dashboard with another sample: the session file that ``NVCORE_TEST_SESSION`` names."""

import gc
import os
from pathlib import Path

import streamlit as st
from starlette.middleware import Middleware

from ui.serving.styles import StyledPages
from ui.session import state
from ui.session.routes import routes_below
from ui.settings.start import base_path
from ui.shell.messages import error_banner
from ui.shell.pages import PAGE_OF

gc.freeze()  # as app.py does
state.SAMPLE = Path(os.environ["NVCORE_TEST_SESSION"])
app = st.App(
    state.ROOT / "ui" / "main.py",
    routes=routes_below(base_path()),
    middleware=[Middleware(StyledPages, pages=list(PAGE_OF))],
    on_script_error=error_banner,
)
