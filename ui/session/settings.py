"""Start of each script run, and the settings that a visitor has made.

Settings are stored independently of the widgets that show them. Streamlit forgets the value of a
widget that a run does not draw, such as a run that is cut off by a click. So a widget only reports
changes, and receives its value in each run.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import streamlit as st

from ui.session import address, state, store

_NONE: Final = object()


def begin_run() -> None:
    """Prepare the state for a run, before any widget is drawn.

    Any run may be cut off by the next one, even while something is being opened. So all state of
    the open comparison is reset here once the number of the comparison has changed.
    """
    store.FIRST_QUERY.setdefault(st.query_params.to_dict())
    space = state.workspace()
    seen_opening = store.SEEN_OPENING.get()
    if seen_opening != space.n_opened:
        _forget()
        if seen_opening is not None:  # a link may set the frame of the first one
            store.PLACE.set((0, 0))
        store.SEEN_OPENING.set(space.n_opened)
    elif store.WANTS_RESET.pop():
        _forget()
    if not store.PLACE.is_set:
        _follow_link()
    keep(**store.NEW_PARAMS.pop())
    store.SETTINGS_RELEASED.pop()
    store.SETTINGS_SHOWN.set({})


def _follow_link() -> None:
    """Apply the page's address: systems, tags, operating point, frame and parameters."""
    query = st.query_params.to_dict()
    get = query.get
    systems = state.opened().dataset.systems
    pair, wrong_systems = address.read_systems(get("x"), get("y"), systems)
    if pair is not None and pair != state.systems():
        state.compare_systems(*pair)
    session, every = state.opened().session, state.opened().whole.recordings
    listed = every[every["name"].isin(session.only)] if session.only else every
    tags, wrong_tags = address.read_tags(get("tags"), listed["tags"])
    if tags is not None and tags != session.only_tags:
        state.compare_as(replace(session, only_tags=tags))
    point, wrong_point = address.read_point(get("point"))
    if point is not None:
        state.set_operating_point(point)
    names, numbers = state.recording_names(), state.frame_numbers
    place, wrong = address.read_place(get("recording"), get("frame"), names, numbers)
    store.PAGE_LINK.set(query)
    values, impossible = address.read_parameters(query)
    for letter in "xy":
        span = state.span_of(letter)
        if span is not None and values.get(f"threshold_{letter}", span) is None:
            values[f"threshold_{letter}"] = span[0]  # the slider's left end: every detection counts
    store.NEW_PARAMS.set(dict(values))
    wrong += wrong_systems + wrong_tags + wrong_point + impossible
    store.PLACE.set(place)
    store.BAD_LINK.set("; ".join(wrong))


def _forget() -> None:
    """Reset all settings to those of the open session."""
    store.PARAMS.pop()
    store.SETTINGS.pop()


def kept(name: str, otherwise: Any) -> Any:
    """Return the value of a setting, or `otherwise` if the visitor has not set it."""
    return store.SETTINGS.get().get(name, otherwise)


def keep(**values: Any) -> None:
    """Set these settings."""
    store.SETTINGS.set({**store.SETTINGS.get(), **values})


def shown() -> dict[str, Any]:
    """Return the values given to widgets so far in this run."""
    return store.SETTINGS_SHOWN.get()


def take(name: str) -> None:
    """Callback: store the new value of a widget."""
    keep(**{name: store.widget(name).get()})
    store.SETTINGS_RELEASED.set(store.SETTINGS_RELEASED.get() | {name})
    store.SETTING_MOVING.pop()


def drag(name: str, value: float) -> None:
    """Store the value of a slider while it is dragged, before Streamlit learns of it.

    Ignored if the slider was released since, because that value is newer.
    """
    if name not in store.SETTINGS_RELEASED.get():
        keep(**{name: value})
        store.SETTING_MOVING.set((name, store.widget(name).get()))


def give(name: str, value: Any) -> None:
    """Set the value of a widget before it is drawn, unless it is up to date or being dragged."""
    store.SETTINGS_SHOWN.set({**shown(), name: value})
    slider = store.widget(name, _NONE)
    own = slider.get()
    if own != value and (name, own) != store.SETTING_MOVING.get():
        slider.set(value)


def key_of(name: str, value: Any) -> str:
    """Return the key of a widget whose value is also changed elsewhere.

    A browser that does not know of such a change yet sends the old value as if the visitor had
    chosen it. So a value that was changed elsewhere gets a new widget.
    """
    memory = store.WIDGETS_SHOWN.of(name)
    shown = memory.get()
    key = next(reversed(shown), name)
    if store.widget(key, shown.get(key, value)).get() != value:
        key = f"{name}_{len(shown)}"
    memory.set({**shown, key: value})
    return key


def is_chosen(name: str, key: str) -> bool:
    """Callback helper: whether the visitor, not the app, changed a widget with a key of `key_of`.

    A browser keeps sending the value of a replaced widget until the new one is drawn. Streamlit
    has forgotten that value, and takes it for a change.
    """
    memory, value = store.WIDGETS_SHOWN.of(name), store.widget(key).get()
    shown = memory.get()
    is_replaced = key != next(reversed(shown))
    memory.set({**shown, key: value})
    return not (is_replaced and value == shown[key])
