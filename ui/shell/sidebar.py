"""The sidebar of every page: who is compared, and the live parameters."""

from __future__ import annotations

from html import escape
from typing import Any, Final

import streamlit as st

from nvcore.figures.inputs import proximity_plot
from nvcore.figures.style import CONFIG
from nvcore.palette import X_COLOUR, Y_COLOUR
from nvcore.params import PRESETS, Params
from nvcore.wording import one_line
from ui.session import state
from ui.shell import live_params
from ui.shell.live_params import FIELDS
from ui.widgets.text import plain

MAX_NAME = 26


def legend() -> None:
    """Name of each system beside a sample of its line."""
    theme = state.theme()
    rows = [
        _row("X", state.systems()[0], X_COLOUR[theme], "solid"),
        _row("Y", state.systems()[1], Y_COLOUR[theme], "dashed"),
    ]
    st.html(f'<div style="display:flex;flex-direction:column;gap:2px">{"".join(rows)}</div>')


def _row(letter: str, name: str | None, colour: str, dash: str) -> str:
    shown = "no second system" if name is None else one_line(name)
    short = shown if len(shown) <= MAX_NAME else shown[: MAX_NAME - 1] + "…"
    line = f'<span style="width:34px;border-top:3px {dash} {colour}"></span>'
    return (
        f'<div style="display:flex;align-items:center;gap:8px" title="{escape(shown, quote=True)}">'
        f"{line}<b>{letter}</b><span>{escape(short)}</span></div>"
    )


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
SHOWN_FOR: Final[dict[str, tuple[str, ...]]] = {
    "height": ("midpoint", "spread"),
    "horizon": ("horizon", "midpoint", "spread"),
    "distance": ("midpoint_m", "spread_m"),
    "none": (),
}
"""Which parameters have a widget, by what tells how near."""
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


def draw(wrong: str = "") -> None:
    """Draw the sidebar, after the page: the widgets' values are in use before they are drawn.

    Parameters
    ----------
    wrong
        What `live_params.read` says of the values.
    """
    with st.sidebar:
        legend()
        _presets()
        _slider("alpha")
        _slider("edge_weight", format="urban %0.2f rural")
        _proximity()
        for letter in "xy":
            _threshold(letter)
        _advanced()
        st.button("Reset all parameters", width="stretch", on_click=state.reset_params)
        if wrong:
            st.error(f"{plain(wrong)}. The last settings that worked stay in use.")


def _presets() -> None:
    columns = st.columns(len(PRESETS))
    for column, preset in zip(columns, PRESETS, strict=True):
        column.button(
            preset.name, help=preset.text, width="stretch", key=f"preset_{preset.name}",
            on_click=live_params.set_preset, args=(preset,),
        )  # fmt: skip


def _proximity() -> None:
    kind = _widget("proximity")
    shown = SHOWN_FOR[kind]
    for name in {name for names in SHOWN_FOR.values() for name in names} - set(shown):
        live_params.keep_hidden(name)
    start, height = state.session_params(), live_params.picture_height()
    ends = {
        "midpoint": (0.0, 0.5 * height, 0.1), "spread": (1.0, 0.15 * height, 0.1),
        "midpoint_m": (0.0, 150.0, 1.0), "spread_m": (0.5, 40.0, 0.5),
    }  # fmt: skip
    for name in shown:
        if name == "horizon":
            st.number_input(
                LABELS[name], value=start.horizon, key=name, help=FIELDS[name].metadata["help"],
                placeholder="each recording's own",
            )  # fmt: skip
            continue
        low, high, step = ends[name]
        in_px = name in ("midpoint", "spread")
        value = live_params.default_of_height(name) if in_px else getattr(start, name)
        _number_slider(name, low=low, high=high, value=value, step=step)
    if kind != "none":
        _proximity_plot()


def _proximity_plot() -> None:
    """The weight over the pedestrians' heights."""
    space, settings, theme = state.workspace(), state.params(), state.theme()
    dataset = space.dataset
    assert dataset is not None
    shown = Params(**{name: getattr(settings, name) for name in OF_PROXIMITY})
    figure = space.keep(  # it stays while other sliders move
        "proximity_plot", (shown, theme), lambda: proximity_plot(dataset, shown, theme=theme),
        most=8,
    )  # fmt: skip
    st.plotly_chart(figure, theme=None, config=CONFIG, key="proximity_plot")


def _threshold(letter: str) -> None:
    """Slider over the scores of X or Y; at the lowest score every detection counts."""
    name = f"threshold_{letter}"
    if state.systems()[0 if letter == "x" else 1] is None:
        return
    scale = live_params.threshold_scale(letter)
    if scale is None:
        if getattr(state.params(), name) is None:
            st.caption(f"{letter.upper()} has no scores that differ: every detection counts.")
        return
    low, high, step = scale
    given = getattr(state.session_params(), name)
    _number_slider(
        name, low=low, high=high, value=low if given is None else given, step=step,
        help=FIELDS[name].metadata["help"] + " At the left end all count.",
    )  # fmt: skip
    if getattr(state.params(), name) is None:
        st.caption(f"Every detection of {letter.upper()} counts.")


def _advanced() -> None:
    """The parameters that are rarely moved; folded, they cost neither server nor browser time."""
    place = st.expander("Advanced", key="advanced", on_change="rerun")
    for title, names in ADVANCED:
        if place.open:
            with place:
                st.markdown(f"**{title}**")
                for name in names:
                    _widget(name)
        else:
            for name in names:
                live_params.keep_hidden(name)


def _widget(name: str) -> Any:
    """The widget of a parameter, made from what `Params` says of it; its value."""
    spec = FIELDS[name]
    choices = spec.metadata["choices"]
    if choices is None:
        _slider(name)
        return st.session_state[name]
    st.session_state.setdefault(name, getattr(state.session_params(), name))
    return st.selectbox(
        LABELS[name], list(choices),
        format_func=lambda one: CHOICES[one], key=name, help=spec.metadata["help"],
    )  # fmt: skip


def _slider(name: str, **more: Any) -> None:
    meta = FIELDS[name].metadata
    low = float(meta["step"] if meta["above_low"] else meta["low"])
    high = MAX_SLIDER.get(name, float(meta["high"]))
    value = float(getattr(state.session_params(), name))
    _number_slider(
        name, low=low, high=max(high, value), value=value, step=float(meta["step"]), **more
    )


def _number_slider(
    name: str, *, low: float, high: float, value: float, step: float, **more: Any
) -> None:
    more = {"help": FIELDS[name].metadata["help"], **more}
    # a session or a link may give any possible value: the slider then reaches to it, and stays so,
    # since one with other ends would be another slider and start anew
    given = float(st.session_state.get(name, value))
    base, (least, most) = st.session_state.get(f"ends_{name}", (None, (low, high)))
    if base != (low, high, step):
        least, most = low, high
    ends = min(least, given), max(most, given, low + step)
    is_known = isinstance(st.session_state.get(name), float)
    if not is_known or (base, (least, most)) != ((low, high, step), ends):
        st.session_state[name] = given  # not in each run: it would move a slider in motion
    st.session_state[f"ends_{name}"] = (low, high, step), ends
    st.slider(
        LABELS[name], min_value=ends[0], max_value=ends[1], step=float(step), key=name, **more
    )
