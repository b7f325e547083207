"""What a study says: to participants what they agree to, to its conductor the two addresses."""

from __future__ import annotations

import streamlit as st

from nvcore.people.participants import KEPT_DAYS, LONGEST_KEPT_DAYS, MOST_TEXT
from ui.people.studies import is_local
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


def draw_addresses(for_participants: str, for_conductor: str) -> None:
    """Show them, with a warning where they lead nowhere from other screens."""
    st.markdown("Participants open this address on their screen:")
    st.code(for_participants, language=None, wrap_lines=True)
    if is_local(for_participants):
        st.warning(
            "This address works **on this computer only**. For other screens ask whoever runs the "
            "app to open it to the network; then open it by this computer's name or IP address "
            "instead of localhost, and come back with the second address below: both then begin "
            "with that name.",
            icon=":material/wifi_off:",
        )
    st.markdown("With this one **you** come back to progress and results. Keep it to yourself:")
    st.code(for_conductor, language=None, wrap_lines=True)
