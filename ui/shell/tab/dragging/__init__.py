"""Parameters that act while their slider is dragged, and what still shows their former values.

Streamlit tells Python of a slider only when it is let go. A script of the page reads where the
handle is meanwhile and sends that, one value at a time (`ui.session.settings`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.errors import ParameterError
from nvcore.params import SETTINGS
from ui.session import settings, state

KEY: Final = "dragging"
_ANSWERED: Final = "dragging_answered"
_COMPONENT = st.components.v2.component(
    "nvcore_dragging", js=Path(__file__).with_name("dragging.js").read_text(encoding="utf-8")
)


def draw() -> None:
    """The invisible part of the page that watches the sliders; after all that they act on.

    Until it has heard that the page was drawn for what they show, it says so on the page.
    """
    drawn = {name: value for name, value in settings.shown().items() if isinstance(value, float)}
    data = {
        "labels": {name: state.say(setting.label) for name, setting in SETTINGS.items()},
        "drawn": drawn,
        "answered": st.session_state.get(_ANSWERED, 0),
    }
    _COMPONENT(key=KEY, height=1, data=data, on_drag_change=_note)


def _note() -> None:
    sent = st.session_state.get(KEY)
    note(sent.get("drag") if isinstance(sent, Mapping) else None)


def note(drag: Any) -> None:
    """Make the setting what its slider says in motion, if what the browser sends has a meaning."""
    if not isinstance(drag, Mapping):
        return
    name, value, answered = (drag.get(key) for key in ("name", "value", "id"))
    if isinstance(answered, int) and not isinstance(answered, bool):
        st.session_state[_ANSWERED] = answered
    if not isinstance(name, str) or name not in SETTINGS:
        return
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        return
    with suppress(ParameterError):
        SETTINGS[name].check(name, float(value))
        settings.drag(name, float(value))
