"""What a run begins with: what is open, its frame and the settings that a visitor has made.

Settings are kept independently of the widgets that show them. Streamlit forgets the value of a
widget that a run does not draw, as one that a click on the page cuts off for another page. So a
widget only tells of a change, and is given its value anew.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import streamlit as st

from ui.session import address, state, store

_NONE: Final = object()


def begin_run() -> None:
    """Prepare the state for a run; call before any widget is drawn.

    Any run may be cut off by the next one, even while something is being opened. So whatever
    belongs to the open comparison is renewed here, when its number has changed.
    """
    store.FIRST_QUERY.setdefault(st.query_params.to_dict())
    space = state.workspace()
    seen_opening = store.SEEN_OPENING.get()
    if seen_opening != space.n_opened:
        _forget()
        if seen_opening is not None:  # the first one may be opened by a link
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
    """Take systems, recording and frame from the address with which the session was opened."""
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
    """Drop all settings: those of the open session hold again."""
    store.PARAMS.pop()
    store.SETTINGS.pop()


def kept(name: str, otherwise: Any) -> Any:
    """Value of a setting; `otherwise` if the visitor has not set it."""
    return store.SETTINGS.get().get(name, otherwise)


def keep(**values: Any) -> None:
    """Set these settings."""
    store.SETTINGS.set({**store.SETTINGS.get(), **values})


def shown() -> dict[str, Any]:
    """Values given to widgets so far in this run."""
    return store.SETTINGS_SHOWN.get()


def take(name: str) -> None:
    """Callback: store the new value of a widget."""
    keep(**{name: store.widget(name).get()})
    store.SETTINGS_RELEASED.set(store.SETTINGS_RELEASED.get() | {name})
    store.SETTING_MOVING.pop()


def drag(name: str, value: float) -> None:
    """Store the value of a slider while it is dragged; Streamlit learns of it on release.

    Passed over where it was let go since: that is newer.
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
    """Key of a widget whose value is also changed elsewhere.

    A browser that has not heard of such a change sends what the widget had before, as if it had
    been chosen. So what others have changed is shown by another widget.
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

    A browser sends the value of a widget that another has replaced until it has drawn that one, and
    Streamlit, which has forgotten the value, takes it for a change.
    """
    memory, value = store.WIDGETS_SHOWN.of(name), store.widget(key).get()
    shown = memory.get()
    is_replaced = key != next(reversed(shown))
    memory.set({**shown, key: value})
    return not (is_replaced and value == shown[key])
