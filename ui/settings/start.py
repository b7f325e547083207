"""Start options of the app: flags after ``--`` of ``streamlit run``, or the environment.

``nvcore app night/session.toml`` passes ``--session night/session.toml``, which every visitor
starts with instead of the sample recordings. The person who starts the app may name any file, and
files named by the session are opened wherever they are. Everybody who can open the app sees them.
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
    """Return the session file that every visitor starts with, or None for the sample."""
    path = argument(SESSION_FLAG, SESSION_VARIABLE)
    return Path(path).absolute() if path else None


def base_path() -> str:
    """Return the base path of the app as the start of an address, or "" without one."""
    base = str(st.get_option("server.baseUrlPath") or "").strip("/")
    return f"/{base}" if base else ""


def argument(flag: str, variable: str) -> str:
    """Return the value of a flag, or else of the environment, or "" if neither is given.

    Parameters
    ----------
    flag, variable
        Names such as ``--local-root`` and ``NVCORE_LOCAL_ROOT``.
    """
    arguments, value = sys.argv[1:], os.environ.get(variable, "")
    for index, text in enumerate(arguments):
        name, equals, rest = text.partition("=")
        if name == flag:
            value = rest if equals else "".join(arguments[index + 1 : index + 2])
    return value
