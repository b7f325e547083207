"""Data page: the traffic context of the recordings, stated or changed after they were opened."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import streamlit as st

from nvcore.params.traffic import CONTEXTS, context_word, count_contexts, parse_context
from nvcore.wording import UNDEFINED
from ui.data.opening import try_to_open
from ui.session import state
from ui.session.opening import with_recordings
from ui.widgets.text import docs_link, plain

UNSTATED: Final = "not stated"


def context_text(context: float) -> str:
    """A recording's context in a table; NaN: not stated."""
    return UNDEFINED if np.isnan(context) else str(context_word(context))


def draw() -> None:
    """What is stated, and a form that states it of some recordings or of all."""
    names = state.opened().whole.recordings["name"].tolist()
    contexts = state.opened().dataset.recordings["context"]
    st.caption(
        "How much a miss to the side costs: in town a pedestrian on the far sidewalk costs little, "
        "on a rural road one at the edge as much as one straight ahead "
        f"({docs_link('Context', 'context', doc='formats')}). Now: {count_contexts(contexts)}."
    )
    if state.params().edge_weight is not None:
        st.info(
            "The sidebar's traffic context has a value now, which holds for all recordings "
            "whatever they state.",
            icon=":material/info:",
        )
    with st.form("context_form", border=False):
        left, right = st.columns([2, 1])
        chosen = left.multiselect(
            "Recordings", names, key="context_recordings", placeholder="all recordings"
        )
        text = right.selectbox(
            "Traffic context",
            [*CONTEXTS, UNSTATED],
            index=None,
            key="context_value",
            accept_new_options=True,
            placeholder="urban, rural, or a number",
            help="From 0 (urban) to 1 (rural): type a number for one in between.",
        )
        is_submitted = st.form_submit_button("State this context")
    if is_submitted:
        _state_context(chosen or names, text)


def _state_context(chosen: list[str], text: str | None) -> None:
    if text is None:
        st.error("Choose a traffic context first.", icon=":material/error:")
        return
    try:
        context = None if text == UNSTATED else parse_context(text)
    except ValueError as error:
        st.error(plain(f"Traffic context: {error}"), icon=":material/error:")
        return
    opened = state.opened()
    names = opened.whole.recordings["name"].tolist()
    changes = {name: {"context": context} for name in chosen}
    changed = with_recordings(opened.session, names, changes)
    try_to_open(replace(changed, params=state.params()), label=opened.label)
