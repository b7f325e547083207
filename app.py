"""The dashboard: ``streamlit run app.py``, or ``streamlit run app.py -- --local-root DIR``."""

import gc
from pathlib import Path

import streamlit as st
from starlette.middleware import Middleware

from ui.access.login import login
from ui.serving.gate import Gate, OwnPages
from ui.serving.headers import SecureHeaders
from ui.serving.life import check_start, lifespan
from ui.serving.styles import StyledPages
from ui.serving.visitors import VisitorLimits
from ui.session.routes import routes_below
from ui.settings.limits import limits_of_environment
from ui.settings.start import base_path
from ui.shell.messages import error_banner
from ui.shell.pages import PAGE_OF

# What the imports have left stays: looking through it each time that Python collects garbage would
# take a fifth of a second.
gc.freeze()

log_in = login()
check_start()

app = st.App(
    Path(__file__).parent / "ui" / "main.py",
    secrets=None if log_in is None else {"auth": dict(log_in.section)},
    routes=routes_below(base_path()),
    middleware=[
        Middleware(SecureHeaders),
        Middleware(OwnPages),
        Middleware(Gate),
        Middleware(VisitorLimits, limits=limits_of_environment()),
        Middleware(StyledPages, pages=list(PAGE_OF)),
    ],
    lifespan=lifespan,
    on_script_error=error_banner,
)
