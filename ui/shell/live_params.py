"""The live parameters, made from the settings before anything is drawn."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from nvcore.errors import ParameterError
from nvcore.metrics.proximity import in_use
from nvcore.params import SETTINGS, Params
from nvcore.stages import THRESHOLD, Setting
from ui.session import settings, state, store

KEPT_NUMBERS: Final = 1e-9


def read() -> str:
    """Make the settings the live parameters.

    A widget tells of its new value before it is drawn: so the page can be drawn first, and the
    sidebar, which is less urgent, after it.

    Returns
    -------
    What is wrong with the values, for the sidebar; empty if nothing. The last parameters that
    worked then stay in use.
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
    """Value of a setting as it was made, else that of the open session."""
    return settings.kept(name, getattr(state.session_params(), name))


def slider_start(name: str) -> float:
    """Where the slider of a parameter starts: the session's value, else what the data agree on."""
    value = getattr(state.session_params(), name)
    if value is None and SETTINGS[name].height_share is not None:
        return default_height_px(name)
    if value is None:
        own = np.unique(in_use(state.session_params(), name, state.opened().dataset.frame_columns))
        value = own[0] if len(own) == 1 else 0.0
    return float(value)


def is_used(setting: Setting) -> bool:
    """Whether the setting has a meaning with the data and the choices that are made."""
    if setting.applies is not None and not setting.applies(state.opened().dataset):
        return False
    if setting.used_with is None:
        return True
    name, values = setting.used_with
    return value_of(name) in values


def picture_height() -> float:
    """Height of the highest pictures, pixels."""
    return float(state.opened().dataset.recordings["height"].max())


def default_height_px(name: str) -> float:
    """The default of the sigmoid's midpoint or spread, pixels."""
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
    """Ends and step of the slider over the scores of X or Y; None without different scores.

    Round values lie on its steps.
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
    """At the lowest score every detection counts: no threshold, unless what is open has one there.

    Where no slider can be drawn the session's own threshold holds, not one that was set for
    another system before.
    """
    span = state.span_of(name[-1])
    own: float | None = getattr(state.session_params(), name)
    if span is None:
        return own
    value: float | None = value_of(name)
    if value is None or value > span[0]:
        return value
    return own if own is not None and own <= span[0] else None  # all count: nothing has changed
