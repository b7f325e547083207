"""The sidebar of every page: who is compared, and the live parameters."""

from __future__ import annotations

import math
from dataclasses import Field, fields
from typing import Any, Final

import numpy as np
import streamlit as st
from streamlit.delta_generator import DeltaGenerator

from nvcore.errors import ParameterError
from nvcore.figures.inputs import proximity_plot
from nvcore.figures.style import CONFIG
from nvcore.params import MIDPOINT_SHARE, SPREAD_SHARE, Params
from nvcore.presets import PRESETS
from ui import state
from ui.legend import legend
from ui.text import plain

FIELDS: Final[dict[str, Field[Any]]] = {spec.name: spec for spec in fields(Params)}
LABELS: Final = {
    "alpha": "Misses against false alarms (alpha)",
    "edge_weight": "Traffic context",
    "proximity": "What tells how near",
    "midpoint": "Counts half at (px)",
    "spread": "Softness (px)",
    "midpoint_m": "Counts half at (m)",
    "spread_m": "Softness (m)",
    "horizon": "Row of the horizon (px)",
    "threshold_x": "Score threshold of X",
    "threshold_y": "Score threshold of Y",
    "distance": "Distance",
    "low": "Low similarity below",
    "window": "Moving mean (s)",
    "match": "A detection matches by",
    "iou": "Smallest overlap (IoU)",
    "lateral_tolerance": "Largest sideways offset (of width)",
    "coverage": "Detected if matched in (share)",
    "lag_s": "Late after (s)",
    "gap_s": "Dropout after (s)",
    "tolerance": "Least miss for saliency",
    "recency_midpoint": "Remembered half at (of duration)",
    "recency_spread": "Softness of recency",
    "saliency_aggregate": "Saliency of a recording",
    "saliency_scope": "Recency measured in",
}
CHOICES: Final = {
    "height": "height of the box",
    "horizon": "foot point below the horizon",
    "distance": "distance in metres",
    "none": "nothing: all count the same",
    "lateral": "sideways position",
    "ground": "foot points in the picture",
    "iou": "overlap of the boxes",
    "max": "most salient event",
    "sum": "sum of all events",
    "recording": "the recording",
    "encounter": "the encounter",
}
OF_PROXIMITY: Final = ("proximity", "midpoint", "spread", "midpoint_m", "spread_m", "horizon")
MAX_SLIDER: Final = {"lag_s": 5.0, "gap_s": 5.0, "window": 10.0, "recency_spread": 0.5}
"""Ends of sliders where the parameter's own range is wider than anybody moves it."""
ADVANCED: Final = (
    ("Similarity", ("distance", "low", "window")),
    ("Matching", ("match", "iou", "lateral_tolerance")),
    ("Encounters", ("coverage", "lag_s", "gap_s")),
    (
        "Saliency",
        ("tolerance", "recency_midpoint", "recency_spread", "saliency_aggregate", "saliency_scope"),
    ),
)
KEPT_NUMBERS: Final = 1e-9


def draw() -> DeltaGenerator | None:
    """Draw the sidebar, and make its values the live parameters.

    Returns
    -------
    The place for `draw_proximity`; None where there is nothing to show.
    """
    with st.sidebar:
        legend()
        _presets()
        values: dict[str, Any] = {}
        values["alpha"] = _slider("alpha")
        values["edge_weight"] = _slider("edge_weight", format="urban %0.2f rural")
        nearness, place = _proximity()
        values |= nearness
        values |= _thresholds()
        with st.expander("Advanced"):
            for title, names in ADVANCED:
                st.markdown(f"**{title}**")
                values |= {name: _widget(name) for name in names}
        if st.button("Reset all parameters", width="stretch"):
            state.reset_params()
            st.rerun()
    try:
        st.session_state["params"] = Params(**{**_others(), **values})
    except ParameterError as error:
        st.error(f"{plain(error)}. The last settings that worked stay in use.")
    return place


def _others() -> dict[str, Any]:
    """Parameters of the session that have no widget just now."""
    start = state.session_params()
    return {name: getattr(start, name) for name in FIELDS}


def _presets() -> None:
    columns = st.columns(len(PRESETS))
    for column, preset in zip(columns, PRESETS, strict=True):
        if column.button(
            preset.name, help=preset.text, width="stretch", key=f"preset_{preset.name}"
        ):
            height = _height()
            shown = {"midpoint": MIDPOINT_SHARE * height, "spread": SPREAD_SHARE * height}
            state.set_params(
                **{
                    name: shown.get(name) if value is None else value
                    for name, value in preset.values(height).items()
                }
            )
            st.rerun()


def _proximity() -> tuple[dict[str, Any], DeltaGenerator | None]:
    kind = _widget("proximity")
    values = {"proximity": kind}
    if kind == "horizon":
        values["horizon"] = st.number_input(
            LABELS["horizon"], value=state.session_params().horizon, key="horizon",
            help=FIELDS["horizon"].metadata["help"], placeholder="each recording's own",
        )  # fmt: skip
    if kind in ("height", "horizon"):
        height = _height()
        for name, default in (("midpoint", _default_midpoint()), ("spread", _default_spread())):
            end = 0.5 * height if name == "midpoint" else 0.15 * height
            shown = _number_slider(name, low=1.0 if name == "spread" else 0.0, high=end,
                                   value=default, step=0.1)  # fmt: skip
            given = getattr(state.session_params(), name)
            is_default = given is None and abs(shown - default) < KEPT_NUMBERS
            values[name] = None if is_default else shown
    elif kind == "distance":
        values["midpoint_m"] = _number_slider(
            "midpoint_m", low=0.0, high=150.0, value=state.session_params().midpoint_m, step=1.0
        )
        values["spread_m"] = _number_slider(
            "spread_m", low=0.5, high=40.0, value=state.session_params().spread_m, step=0.5
        )
    return values, None if kind == "none" else st.container()


def draw_proximity(place: DeltaGenerator | None) -> None:
    """The weight over the pedestrians' heights; drawn last, since nothing waits for it."""
    if place is None:
        return
    space, settings, theme = state.workspace(), state.params(), state.theme()
    dataset = space.dataset
    assert dataset is not None
    shown = Params(**{name: getattr(settings, name) for name in OF_PROXIMITY})
    figure = space.keep(  # it stays while other sliders move
        "proximity_plot", (shown, theme), lambda: proximity_plot(dataset, shown, theme=theme),
        most=8,
    )  # fmt: skip
    place.plotly_chart(figure, theme=None, config=CONFIG, key="proximity_plot")


def _thresholds() -> dict[str, Any]:
    """Sliders over the scores; at the lowest score every detection counts."""
    space = state.workspace()
    assert space.dataset is not None
    values: dict[str, Any] = {}
    for letter, name in zip("xy", state.systems(), strict=True):
        key = f"threshold_{letter}"
        if name is None:
            continue
        span = state.score_span(name)
        if span is None:
            st.caption(f"{letter.upper()} has no scores: every detection counts.")
            values[key] = getattr(state.session_params(), key)
            continue
        step = _step(span[1] - span[0])
        low = math.floor(span[0] / step) * step  # so that round values lie on the slider's steps
        high = span[1]
        given = getattr(state.session_params(), key)
        start = low if given is None else given
        shown = _number_slider(
            key, low=low, high=high, value=start, step=step,
            help=FIELDS[key].metadata["help"] + " At the left end all count.",
        )  # fmt: skip
        values[key] = None if shown <= span[0] else shown
        if values[key] is None:
            st.caption(f"Every detection of {letter.upper()} counts.")
    return values


def _step(span: float) -> float:
    return 0.01 if span <= 2 else float(10.0 ** np.floor(np.log10(span / 100)))


def _widget(name: str) -> Any:
    """The widget of a parameter, made from what `Params` says of it."""
    spec = FIELDS[name]
    choices = spec.metadata["choices"]
    if choices is None:
        return _slider(name)
    st.session_state.setdefault(name, getattr(state.session_params(), name))
    return st.selectbox(
        LABELS[name], list(choices),
        format_func=lambda one: CHOICES[one], key=name, help=spec.metadata["help"],
    )  # fmt: skip


def _slider(name: str, **more: Any) -> float:
    meta = FIELDS[name].metadata
    low = float(meta["step"] if meta["above_low"] else meta["low"])
    high = MAX_SLIDER.get(name, float(meta["high"]))
    value = float(getattr(state.session_params(), name))
    return _number_slider(name, low=low, high=max(high, value), value=value,
                          step=float(meta["step"]), **more)  # fmt: skip


def _number_slider(
    name: str, *, low: float, high: float, value: float, step: float, **more: Any
) -> float:
    more = {"help": FIELDS[name].metadata["help"], **more}
    # a session or a link may give any possible value: the slider then reaches to it
    given = float(st.session_state.get(name, value))
    low, high = min(low, given), max(high, given, low + step)
    st.session_state[name] = given
    return float(
        st.slider(
            LABELS[name], min_value=float(low), max_value=float(high),
            step=float(step), key=name, **more,
        )
    )  # fmt: skip


def _height() -> float:
    space = state.workspace()
    assert space.dataset is not None
    return float(space.dataset.recordings["height"].max())


def _default_midpoint() -> float:
    given = state.session_params().midpoint
    return MIDPOINT_SHARE * _height() if given is None else given


def _default_spread() -> float:
    given = state.session_params().spread
    return SPREAD_SHARE * _height() if given is None else given
