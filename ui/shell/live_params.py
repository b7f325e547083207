"""Live parameters, built from the settings before anything is drawn."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from nvcore.common.errors import ParameterError
from nvcore.metrics.proximity import in_use
from nvcore.settings.params import SETTINGS, Params
from nvcore.settings.stages import THRESHOLD, Setting
from ui.session import settings, state, store

KEPT_NUMBERS: Final = 1e-9


def read() -> str:
    """Build the live parameters from the settings.

    A widget reports its new value before it is drawn. So the page can be drawn first, and the less
    urgent sidebar after it.

    Returns
    -------
    Error message for the sidebar, or "". After an error the last valid parameters stay in use.
    """
    values = {name: _read(name, setting) for name, setting in SETTINGS.items()}
    try:
        params = Params(**values)
    except ParameterError as error:
        return str(error)
    if (
        params.proximity == "horizon"
        and params.horizon is None
        and state.opened().dataset.recordings["horizon"].isna().any()
    ):
        return "The recordings do not state the row of the horizon: type it above"
    store.PARAMS.set(params)
    return ""


def _read(name: str, setting: Setting) -> Any:
    if setting.stage is THRESHOLD:
        return _threshold(name)
    return value_of(name) if setting.height_share is None else _chosen_height_px(name)


def value_of(name: str) -> Any:
    """Return the visitor's value of a setting, or else the open session's."""
    return settings.kept(name, getattr(state.session_params(), name))


def slider_start(name: str) -> float:
    """Return a slider's start: the session's value, else that in the data, or 0 if they differ."""
    value = getattr(state.session_params(), name)
    if value is None and SETTINGS[name].height_share is not None:
        return default_height_px(name)
    if value is None:
        own = np.unique(in_use(state.session_params(), name, state.opened().dataset.frame_columns))
        value = own[0] if len(own) == 1 else 0.0
    return float(value)


def is_used(setting: Setting) -> bool:
    """Whether a setting applies to the open data and the other settings."""
    if setting.applies is not None and not setting.applies(state.opened().dataset):
        return False
    if setting.used_with is None:
        return True
    name, values = setting.used_with
    return value_of(name) in values


def picture_height() -> float:
    """Return the height of the highest pictures, px."""
    return float(state.opened().dataset.recordings["height"].max())


def default_height_px(name: str) -> float:
    """Return the default of the sigmoid's midpoint or spread, px."""
    share = SETTINGS[name].height_share
    assert share is not None
    return share * picture_height()


def _chosen_height_px(name: str) -> float | None:
    session_value: float | None = getattr(state.session_params(), name)
    widget_value: float | None = value_of(name)
    if widget_value is None:
        return session_value
    untouched = session_value is None and abs(widget_value - slider_start(name)) < KEPT_NUMBERS
    return None if untouched else widget_value


def threshold_scale(letter: str) -> tuple[float, float, float] | None:
    """Return the ends and the step of the slider over the scores of X or Y.

    Its steps hit round values. Returns None if the scores do not differ.
    """
    span = state.span_of(letter)
    if span is None:
        return None
    width = span[1] - span[0]
    step = 0.01 if width <= 2 else float(10.0 ** np.floor(np.log10(width / 100)))
    return math.floor(span[0] / step) * step, span[1], step


def counts_all(letter: str) -> bool:
    """Whether every detection of X or Y reaches the live threshold."""
    threshold = state.threshold_of(letter)
    span = state.span_of(letter)
    return threshold is None or (span is not None and threshold <= span[0])


def _threshold(name: str) -> float | None:
    """Return the live threshold of a system, or None if every detection counts.

    A threshold at or below the lowest score becomes None, unless the session itself sets one there.
    Without a slider the session's own threshold applies, not one set earlier for another system.
    """
    span = state.span_of(name[-1])
    own: float | None = getattr(state.session_params(), name)
    if span is None:
        return own
    value: float | None = value_of(name)
    if value is None or value > span[0]:
        return value
    return own if own is not None and own <= span[0] else None  # every detection counts either way
