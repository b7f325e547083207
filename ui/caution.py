"""What limits a page's figures, where the figures stand."""

from __future__ import annotations

import streamlit as st

from nvcore.analysis import Result
from nvcore.findings import Severity
from nvcore.tables import is_short
from nvcore.verdict import CAVEATS
from ui import state
from ui.text import plain

SHORT: str = (
    "Most encounters here are one frame long, as sampled or unlinked annotation makes "
    "them: they are frames rather than persons. Lag, dropout, lead time and saliency mean "
    "little; shares of encounters detected are shares of frames."
)


def draw_caution(result: Result, *, is_of_encounters: bool = True) -> None:
    """Where encounters are mostly single frames, and what the audit warns of: a box for each.

    Parameters
    ----------
    is_of_encounters
        Whether the page is about encounters: curves of boxes do not depend on their length.
    """
    if is_of_encounters and is_short(result):
        st.warning(SHORT, icon=":material/warning:")
    warned = [
        CAVEATS[one.code] for one in state.findings()
        if one.severity is not Severity.NOTE and one.code in CAVEATS
        and one.code != "short-encounters"
    ]  # fmt: skip
    if warned:
        told = "; ".join(dict.fromkeys(warned))
        st.warning(
            f"The audit found: {plain(told)}. Details and remedies are on the page Data.",
            icon=":material/warning:",
        )
