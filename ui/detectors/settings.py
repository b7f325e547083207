"""Detectors page: the settings of the chosen detector, from what it knows of them itself."""

from __future__ import annotations

from typing import Any, Final

import streamlit as st

from nvcore.dataset.provenance import About, Setting
from nvcore.detectors.registry import DETECTORS, run_settings
from nvcore.detectors.settings import SettingFacts
from nvcore.wording import capitalised
from ui.detectors.asking import key_of
from ui.detectors.confined import DetectorSpec
from ui.widgets.text import plain

NOT_HERE: Final = ("classifier", "threads")
"""Settings that the choice of the detector makes, or that change nothing of its boxes."""
COLUMNS: Final = 3


def draw(spec: DetectorSpec, about: About) -> DetectorSpec:
    """The detector with the settings of the form; threshold and overlap are moved elsewhere."""
    moved = (DETECTORS[about.kind].threshold, "overlap", *NOT_HERE)
    facts = {name: known for name, known in run_settings(about).items() if name not in moved}
    changed: dict[str, Setting] = {}
    with st.expander("Settings"):
        columns = st.columns(COLUMNS, gap="medium")
        for number, (name, known) in enumerate(facts.items()):
            with columns[number % COLUMNS]:
                own = about.settings[name]
                value = _draw_setting(name, known, own, key=f"detector_{key_of(spec)}_{name}")
                if value != own:
                    changed[name] = value
    return spec.with_settings(changed)


def _draw_setting(name: str, facts: SettingFacts, own: Setting, *, key: str) -> Setting:
    """The field of one setting; its value."""
    words = capitalised(name.replace("_", " "))
    more: dict[str, Any] = {
        "key": key,
        "help": plain(facts.meaning),
        "persist_state": "session",
    }
    value: Setting
    if facts.choices:
        choices = dict(facts.choices)
        value = st.selectbox(
            words,
            list(choices),
            index=list(choices).index(str(own)),
            format_func=lambda choice: f"{choice}: {choices[choice]}",
            **more,
        )
    elif isinstance(own, bool):
        value = st.toggle(words, own, **more)
    elif isinstance(own, int | float):
        kind = type(own)
        low, high = (None if end is None else kind(end) for end in (facts.low, facts.high))
        form = "%d" if kind is int else "%.4g"
        step = facts.multiple_of  # None: as usual
        value = st.number_input(words, low, high, own, step, form, **more)
    else:
        value = st.text_input(words, str(own or ""), max_chars=2000, **more)
    return value
