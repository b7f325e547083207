"""What a visitor sees when a part of a page cannot be drawn: a sentence, no traceback."""

from __future__ import annotations

import logging

import streamlit as st

from nvcore.errors import NvcoreError
from ui.public import shown_error

_LOG = logging.getLogger("nvcore.ui")


def show_trouble(error: Exception) -> bool:
    """Tell what is wrong with the data, or that the program is; True: Streamlit adds nothing.

    Parts of a page that run again by themselves, and what buttons call, end here; the page as a
    whole has its own place for errors in the data.
    """
    if isinstance(error, NvcoreError):
        st.error(shown_error(error), icon=":material/error:")
        return True
    _LOG.error("a page could not be drawn", exc_info=error)
    st.error(
        "This page could not be drawn: a fault of the program, not of your data. The other pages "
        "still work; the terminal that runs the app has the details.",
        icon=":material/error:",
    )
    return True
