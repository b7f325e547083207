"""Driver page: how to get detectability, where none is known."""

from __future__ import annotations

from typing import Final

import streamlit as st

from ui.session import state

COMMANDS: Final = """nvcore driver train trials.csv --features study.csv --out driver.npz
nvcore driver estimate session.toml --model driver.npz --out seen
nvcore app seen/session.toml"""


def draw() -> None:
    """What is missing."""
    text = state.say(
        "Whether the driver sees the {many} is not known yet. Press *Estimate* below: an "
        "estimator tells it from pictures of visible light. The supplied one was trained on "
        "simulated subjects, not on people."
    )
    st.info(text, icon=":material/visibility_off:")


def draw_commands() -> None:
    """The same by commands."""
    with st.expander("By the command line"):
        st.code(COMMANDS, language="console")
