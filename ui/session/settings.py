"""The settings a visitor has made, kept independently of the widgets that show them.

Streamlit forgets the value of a widget that a run does not draw, as one that a click on the page
cuts off for another page. So a widget only tells of a change, and is given its value anew.
"""

from __future__ import annotations

from typing import Any, Final

from ui.session import store

_NONE: Final = object()


def kept(name: str, otherwise: Any) -> Any:
    """Value of a setting; `otherwise` if the visitor has not set it."""
    return store.SETTINGS.get().get(name, otherwise)


def keep(**values: Any) -> None:
    """Set these settings."""
    store.SETTINGS.set({**store.SETTINGS.get(), **values})


def forget() -> None:
    """Drop all settings: those of the open session hold again."""
    store.SETTINGS.pop()


def begin_run() -> None:
    """Take over values that widgets changed since the last run; call once at the start of a run."""
    store.SETTINGS_RELEASED.pop()
    store.SETTINGS_SHOWN.set({})


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
