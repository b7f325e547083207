"""What limits a page's figures, where the figures stand."""

from __future__ import annotations

import streamlit as st

from nvcore.analysis import Result
from nvcore.significance import is_short


def draw(result: Result) -> None:
    """A word where encounters are mostly single frames."""
    if is_short(result):
        st.warning(
            "Most encounters here are one frame long, as sampled or unlinked annotation makes "
            "them: they are frames rather than persons. Lag, dropout, lead time and saliency mean "
            "little; shares of encounters detected are shares of frames.",
            icon=":material/warning:",
        )
