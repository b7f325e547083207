"""What a visitor sees of a bug: a sentence, no traceback. The log has the rest."""

from __future__ import annotations

import logging

import streamlit as st

_LOG = logging.getLogger("nvcore.ui")


def show_bug(error: Exception) -> bool:
    """Tell that the page could not be drawn; True: Streamlit shows nothing of its own."""
    _LOG.error("a page could not be drawn", exc_info=error)
    st.error(
        "This page could not be drawn: a fault of the program, not of your data. The other pages "
        "still work; the terminal that runs the app has the details.",
        icon=":material/error:",
    )
    return True
