"""What the app was started with: flags after ``--`` of ``streamlit run``, or the environment.

``nvcore app night/session.toml`` gives ``--session night/session.toml``: what every visitor starts
with, instead of the sample recordings. Whoever starts the app may name any file, and what the
session names is opened wherever it lies: everybody who can open the app sees it.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Final

import streamlit as st

SESSION_FLAG: Final = "--session"
SESSION_VARIABLE: Final = "NVCORE_SESSION"


def start_file() -> Path | None:
    """The session file that every visitor starts with; None: the sample."""
    path = argument(SESSION_FLAG, SESSION_VARIABLE)
    return Path(path).absolute() if path else None


def base_path() -> str:
    """The path that the app is served below, as the start of an address; empty: none."""
    base = str(st.get_option("server.baseUrlPath") or "").strip("/")
    return f"/{base}" if base else ""


def argument(flag: str, variable: str) -> str:
    """Value of a flag, or of the environment where there is no flag; empty: neither is given.

    Parameters
    ----------
    flag, variable
        Their names: ``--local-root``, ``NVCORE_LOCAL_ROOT``.
    """
    arguments, value = sys.argv[1:], os.environ.get(variable, "")
    for index, text in enumerate(arguments):
        name, equals, rest = text.partition("=")
        if name == flag:
            value = rest if equals else "".join(arguments[index + 1 : index + 2])
    return value
