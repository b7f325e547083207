"""Driver page: how to get detectability, where none is known."""

from __future__ import annotations

from typing import Final

import streamlit as st

from ui.session import state
from ui.widgets.text import docs_link

COMMANDS: Final = """nvcore driver train trials.csv --features study.csv --out driver.npz
nvcore driver estimate session.toml --model driver.npz --out seen
nvcore app seen/session.toml"""


def draw() -> None:
    """What is missing, and the commands that make it."""
    st.info(
        state.words(
            "How detectable pedestrians are is not known here: the ground truth has no column "
            "`detectability`, and the session names no estimates "
            "(`detectability` under `[driver]`)."
        ),
        icon=":material/visibility_off:",
    )
    n_visible = len(state.workspace().visible.sources)
    text = (
        "An estimator, trained on trials with people, estimates it from pictures of visible light "
        f"({docs_link('how', 'estimates', doc='driver')}):"
    )
    st.markdown(text)
    st.code(COMMANDS, language="console")
    st.markdown(
        f"{n_visible} of {len(state.recording_names())} recordings here have pictures of visible "
        f"light beside their own ({docs_link('in the session', 'pictures', doc='driver')})."
    )
