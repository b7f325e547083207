"""The two addresses of a study: for its participants, and for who conducts it."""

from __future__ import annotations

import streamlit as st

from ui.people.studies import is_local


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
