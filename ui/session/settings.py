"""The settings a visitor has made, kept independently of the widgets that show them.

Streamlit forgets the value of a widget that a run does not draw, as one that a click on the page
cuts off for another page. So a widget only tells of a change, and is given its value anew.
"""

from __future__ import annotations

from typing import Any, Final

import streamlit as st

_KEPT: Final = "settings"
_MOVING: Final = "settings_moving"
"""The setting whose slider is in motion, and the value that Streamlit has of it meanwhile."""
_SHOWN: Final = "settings_shown"
"""The values that the widgets of this run were given."""
_LET_GO: Final = "settings_let_go"
"""The settings whose widgets told of a change before this run."""
_NONE: Final = object()


def kept(name: str, otherwise: Any) -> Any:
    """Value of a setting; `otherwise` if the visitor has not set it."""
    return st.session_state.get(_KEPT, {}).get(name, otherwise)


def keep(**values: Any) -> None:
    """Set these settings."""
    st.session_state[_KEPT] = {**st.session_state.get(_KEPT, {}), **values}


def forget() -> None:
    """Drop all settings: those of the open session hold again."""
    st.session_state.pop(_KEPT, None)


def begin_run() -> None:
    """Take over values that widgets changed since the last run; call once at the start of a run."""
    st.session_state.pop(_LET_GO, None)
    st.session_state[_SHOWN] = {}


def shown() -> dict[str, Any]:
    """Values given to widgets so far in this run."""
    values: dict[str, Any] = st.session_state.get(_SHOWN, {})
    return values


def take(name: str) -> None:
    """Callback: store the new value of a widget."""
    keep(**{name: st.session_state[name]})
    st.session_state[_LET_GO] = {*st.session_state.get(_LET_GO, ()), name}
    st.session_state.pop(_MOVING, None)


def drag(name: str, value: float) -> None:
    """Store the value of a slider while it is dragged; Streamlit learns of it on release.

    Passed over where it was let go since: that is newer.
    """
    if name not in st.session_state.get(_LET_GO, ()):
        keep(**{name: value})
        st.session_state[_MOVING] = name, st.session_state.get(name)


def give(name: str, value: Any) -> None:
    """Set the value of a widget before it is drawn, unless it is up to date or being dragged."""
    st.session_state[_SHOWN] = {**shown(), name: value}
    own = st.session_state.get(name, _NONE)
    if own != value and (name, own) != st.session_state.get(_MOVING):
        st.session_state[name] = value


def key_of(name: str, value: Any) -> str:
    """Key of a widget whose value is also changed elsewhere.

    A browser that has not heard of such a change sends what the widget had before, as if it had
    been chosen. So what others have changed is shown by another widget.
    """
    memory = f"shown_{name}"
    shown: dict[str, Any] = st.session_state.get(memory, {})
    key = next(reversed(shown), name)
    if st.session_state.get(key, shown.get(key, value)) != value:
        key = f"{name}_{len(shown)}"
    st.session_state[memory] = {**shown, key: value}
    return key


def is_chosen(name: str, key: str) -> bool:
    """Callback helper: whether the visitor, not the app, changed a widget with a key of `key_of`.

    A browser sends the value of a widget that another has replaced until it has drawn that one, and
    Streamlit, which has forgotten the value, takes it for a change.
    """
    memory, value = f"shown_{name}", st.session_state[key]
    shown: dict[str, Any] = st.session_state[memory]
    is_replaced = key != next(reversed(shown))
    st.session_state[memory] = {**shown, key: value}
    return not (is_replaced and value == shown[key])
