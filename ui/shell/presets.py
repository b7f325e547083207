"""Presets in the sidebar, and the settings that were moved away from the preset in use."""

from __future__ import annotations

import math
from typing import Any, Final

import streamlit as st

from nvcore.common.wording import count_text
from nvcore.settings.params import SETTINGS, Params
from nvcore.settings.params.presets import PRESETS, Preset, presets_for
from nvcore.settings.stages import THRESHOLD
from ui.session import settings, state, store
from ui.shell import live_params

KEY: Final = "preset"
MARK: Final = ":primary[●]"
"""Mark beside the name of a setting that was moved."""
CLOSE: Final = 1e-9
_BY_NAME: Final = {preset.name: preset for preset in PRESETS}


def preset_in_use() -> Preset | None:
    """Return the preset that all settings except thresholds agree with (None: custom settings)."""
    live = state.params()
    for preset in _presets():
        values = preset.values(live_params.picture_height())
        if all(_is_same(name, getattr(live, name), values[name]) for name in values):
            return preset
    return None


def _presets() -> tuple[Preset, ...]:
    return presets_for(state.opened().dataset.objects)


def changed() -> dict[str, Any]:
    """Return the settings that were moved, with the values that they were moved away from.

    These are the values of the chosen preset, or else of the open session. Thresholds belong to no
    preset and are always compared with the session's.
    """
    base = {name: getattr(state.session_params(), name) for name in SETTINGS}
    if (preset := _chosen()) is not None:
        base |= preset.values(live_params.picture_height())
    live = state.params()
    return {
        name: value
        for name, value in base.items()
        if not _is_same(name, getattr(live, name), value)
    }


def draw(moved: dict[str, Any]) -> None:
    """Draw the presets, with the one in use marked, and buttons that undo each moved setting."""
    preset = preset_in_use()
    name = None if preset is None else preset.name
    key = settings.key_of(KEY, name)
    st.segmented_control(
        "Preset" if preset is not None else "Preset: custom",
        [preset.name for preset in _presets()],
        default=name,
        key=key,
        on_change=_take,
        args=(key,),
        width="stretch",
        help="  \n".join(f"*{preset.name}*: {state.say(preset.text)}" for preset in _presets()),
    )
    with st.popover(_changes_text(moved), type="tertiary", disabled=not moved, key="changed"):
        for name, value in moved.items():
            label, now = SETTINGS[name].label_with_unit, getattr(state.params(), name)
            st.button(
                f"{state.say(label)}: {_text(name, now)}, back to {_text(name, value)}",
                key=f"reset_{name}",
                icon=":material/undo:",
                type="tertiary",
                on_click=reset,
                args=(name, value),
            )


def _changes_text(moved: dict[str, Any]) -> str:
    """Return the number of moved settings in words, or whether the session sets any."""
    if moved:
        return f"{count_text(len(moved), 'setting')} changed"
    is_of_session = _chosen() is None and state.session_params() != Params()
    return "Settings of the session" if is_of_session else "No setting changed"


def _take(key: str) -> None:
    """Callback: apply the chosen preset. Pressing the preset in use again changes nothing."""
    name: str | None = store.widget(key).get()
    if settings.is_chosen(KEY, key) and name is not None:
        store.PRESET.set((state.workspace().n_opened, name))
        for setting, value in _BY_NAME[name].values(live_params.picture_height()).items():
            reset(setting, value)


def reset(name: str, value: Any) -> None:
    """Reset a setting to this value. For callbacks."""
    setting = SETTINGS[name]
    if setting.stage is THRESHOLD:
        state.set_threshold(name[-1], value)
    else:
        state.set_params(**{name: _resolved(name, value)})


def _chosen() -> Preset | None:
    """Return the preset chosen last for the open comparison, or None."""
    opening, name = store.PRESET.get()
    return _BY_NAME[name] if opening == state.workspace().n_opened else None


def _resolved(name: str, value: Any) -> Any:
    """Return the widget's value: the default in pixels for an unset share of the height."""
    is_share = value is None and SETTINGS[name].height_share is not None
    return live_params.default_height_px(name) if is_share else value


def _is_same(name: str, value: Any, other: Any) -> bool:
    value, other = _resolved(name, value), _resolved(name, other)
    if isinstance(value, float | int) and isinstance(other, float | int):
        return math.isclose(value, other, rel_tol=CLOSE, abs_tol=CLOSE)
    return bool(value == other)


def _text(name: str, value: Any) -> str:
    value, setting = _resolved(name, value), SETTINGS[name]
    if setting.words is not None:
        return state.say(setting.words[value])
    if value is None:
        return setting.unset or ("all count" if setting.stage is THRESHOLD else "not given")
    return f"{value:.4g}"
