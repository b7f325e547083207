"""Data page: estimated horizons of recordings that do not state theirs, for adoption."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import streamlit as st

from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.metrics.proximity.horizon import Horizon
from nvcore.tables.inputs import open_horizons
from ui.session import state
from ui.session.opening import with_recordings
from ui.views.data.opening import try_to_open
from ui.widgets.buttons import button
from ui.widgets.text import docs_link, plain

MOST_SHOWN: Final = 10
"""Largest number of recordings named with their estimate."""


def draw() -> None:
    """Draw estimates for the open recordings, and the button that adopts them."""
    whole = state.opened().whole
    n_open = int(whole.recordings["horizon"].isna().sum())
    if not n_open:
        return
    title = f"Estimate the horizon of {count_text(n_open, 'recording')} that do not state it"
    place = st.expander(
        title if n_open > 1 else "Estimate the horizon, which the recording does not state",
        key="horizons",
        on_change="rerun",
    )
    if not place.open:  # folded, it costs nothing
        return
    with place:
        with st.spinner("Estimating the horizon"):
            horizons = open_horizons(whole)
        _draw_estimates(whole, horizons, n_open)


def _draw_estimates(whole: Dataset, horizons: Mapping[str, Horizon], n_open: int) -> None:
    st.caption(
        state.say(
            "On flat ground {a_one} is as tall in the picture as the {feet_are} below the "
            "horizon, times a constant ({link}). Used for nearness by horizon, and to tell "
            "children.",
            link=docs_link("more", "horizon"),
        )
    )
    if not horizons:
        st.info(
            state.say(
                "The boxes do not tell: it takes 30 of 3 {many}, whole, at different distances."
            ),
            icon=":material/info:",
        )
        return
    lines = [
        f"- {plain(name)}: {plain(state.say(horizon.text))}" for name, horizon in horizons.items()
    ]
    if len(lines) > MOST_SHOWN:
        lines[MOST_SHOWN:] = [f"- and {len(lines) - MOST_SHOWN:,} more"]
    st.markdown("\n".join(lines))
    if len(horizons) < n_open:
        n_unknown = count_text(n_open - len(horizons), "recording")
        st.caption(f"Of {n_unknown} the boxes do not tell.")
    words = "this horizon" if len(horizons) == 1 else f"these {len(horizons):,} horizons"
    if button(f"Use {words}", key="use_horizons", icon=":material/check:"):
        changes = {
            name: {"horizon": round(horizon.row_px, 1)} for name, horizon in horizons.items()
        }
        opened = state.opened()
        session = with_recordings(opened.session, whole.recordings["name"].tolist(), changes)
        try_to_open(replace(session, params=state.params()), label=opened.label)
