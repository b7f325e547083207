"""What a page says when it has nothing to show."""

from __future__ import annotations

import streamlit as st

from ui.navigate import open_page


def one_system_only() -> None:
    """There is nothing to compare yet."""
    st.info("Only one system is open. A comparison needs two: add the second one on the Data page.")
    if st.button("Open the Data page", type="primary"):
        open_page("data")
