"""The terms of a study: what participants agree to, and how long their answers are kept."""

from __future__ import annotations

import streamlit as st

from nvcore.people.terms import KEPT_DAYS, LONGEST_KEPT_DAYS, MOST_TEXT
from ui.widgets.text import plain


def ask_consent(consent: str, key: str) -> str:
    """A field for the text that participants agree to."""
    return st.text_area(
        "What participants agree to",
        consent,
        key=f"{key}_consent",
        max_chars=MOST_TEXT,
        height=260,
    )


def ask_days(label: str, key: str) -> int:
    """A field for the days that answers are kept."""
    days = st.number_input(
        label,
        min_value=1,
        max_value=LONGEST_KEPT_DAYS,
        value=KEPT_DAYS,
        key=f"{key}_keep_days",
        width=420,
    )
    return int(days)


def draw_consent(consent: str) -> None:
    """The text of consent, paragraph by paragraph."""
    for paragraph in consent.split("\n\n"):
        st.markdown(plain(" ".join(paragraph.split())))
