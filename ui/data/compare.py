"""Data page: which two systems are X and Y, and at which thresholds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import pandas as pd
import plotly.graph_objects as go
import streamlit as st

from nvcore.dataset import Dataset
from nvcore.detection.operating_point import (
    OperatingPoint,
    choose_moved,
    false_alarm_curve,
    score_histogram,
)
from nvcore.detection.operating_point import operating_point as point_at
from nvcore.evidence.measures import primary_of
from nvcore.figures.inputs import false_alarm_plot, score_plot
from nvcore.measures.table import CLAIMABLE, choose_primary, inference_of
from nvcore.params import Params
from nvcore.report.words import at_best, sampling_note
from nvcore.stages import MATCH
from nvcore.wording import capitalised
from ui.session import state
from ui.shell import operating_point, systems
from ui.widgets.charts import draw_chart
from ui.widgets.text import docs_link, number, plain

LOWEST: Final = "threshold_at_lowest"
"""System and threshold typed just now, if that is its lowest score or less."""
MOST_KEPT: Final = 32
"""Curves and points that are kept for all sessions."""


def draw() -> None:
    """Choice of X and Y, then one column for each."""
    st.header("Compare")
    _draw_choice()
    x, y = state.systems()
    if y is None:
        st.info(
            "There is one system only. Open a comparison with two systems to compare them.",
            icon=":material/info:",
        )
    else:
        _draw_same_point(x, y)
        _draw_primary()
    st.caption(
        state.say(
            "False alarms here are single detections that match {nobody}, counted in every frame. "
            "What a driver would notice is on the Overview: false-alert episodes, false alarms "
            "linked over frames ({link}).",
            link=docs_link("more", "false-alarms"),
        )
    )
    columns = st.columns(2)
    for column, letter, name in zip(columns, "xy", (x, y), strict=True):
        if name is not None:
            with column:
                _draw_system(letter, name)


def _draw_choice() -> None:
    names = list(state.opened().dataset.systems)
    x, y = state.systems()
    if y is None:
        return
    left, middle, right = st.columns([5, 2, 5], vertical_alignment="bottom")
    # the widgets show what is open, however it was changed
    st.session_state["choice_x"], st.session_state["choice_y"] = x, y
    left.selectbox("System X", names, key="choice_x", on_change=_choose, args=("x",))
    middle.button(
        "Swap",
        icon=":material/swap_horiz:",
        on_click=systems.swap,
        width="stretch",
        key="swap_systems",
    )
    right.selectbox("System Y", names, key="choice_y", on_change=_choose, args=("y",))


def _draw_primary() -> None:
    """The measure by which the comparison is decided."""
    primary = primary_of(state.opened().dataset)
    st.session_state["choice_primary"] = primary.key
    st.selectbox(
        "Decide by",
        list(CLAIMABLE.values()),
        key="choice_primary",
        format_func=lambda key: capitalised(state.say(inference_of(key).noun)),
        on_change=_choose_primary,
        help="The primary measure: the verdict tests it by itself, and claims other differences "
        "only if it shows one. Choose it before you look at the verdict; if it is changed "
        "afterwards, the verdict says so and corrects all measures for one another.",
    )
    for fact in at_best(state.opened().dataset):
        st.caption(state.say(fact))
    if primary.is_changed:
        st.caption(
            f":material/warning: Changed {primary.when}, after a verdict on these data: all "
            "measures are corrected for one another."
        )


def _choose_primary() -> None:
    """Another measure was chosen; the session knows whether a verdict on the data was shown."""
    session, fingerprint = state.opened().session, state.opened().dataset.fingerprint
    primary = session.primary.of_data(fingerprint)
    if state.has_shown_verdict():
        primary = replace(primary, fingerprint=fingerprint)
    chosen = choose_primary(primary, st.session_state["choice_primary"])
    state.compare_as(replace(session, primary=chosen))


def _choose(letter: str) -> None:
    """X or Y was chosen; the system of the other letter changes places with it."""
    x, y = state.systems()
    chosen = st.session_state[f"choice_{letter}"]
    if letter == "x":
        systems.compare(chosen, x if chosen == y else y)
    else:
        systems.compare(y if chosen == x and y is not None else x, chosen)


def _draw_system(letter: str, name: str) -> None:
    dataset, params = state.opened().dataset, state.params()
    field = f"threshold_{letter}"
    threshold: float | None = getattr(params, field)
    st.markdown(f"**{letter.upper()}: {plain(name)}**")
    if state.score_span(name) is None:
        st.caption("The detections of this system have no scores that differ: every one counts.")
    else:
        key = f"data_{field}"
        st.session_state[key] = threshold
        st.number_input(
            f"Score threshold of {letter.upper()}",
            key=key,
            value=None,
            step=0.01,
            format="%.4g",
            placeholder="every detection counts",
            on_change=_take_threshold,
            args=(letter,),
            help="Detections with a lower score are left out. Empty: every detection counts.",
        )
        _draw_lowest(letter)
    point = _point(dataset, name, params, threshold)
    n_all = len(dataset.system(name))
    detections, alarms = st.columns(2)
    detections.metric("Detections kept", f"{point.n_kept:,} of {n_all:,}")
    alarms.metric(
        "False alarms per minute",
        number(point.false_alarms_per_minute, ".1f"),
        help=state.say("Detections that match {nobody}, per minute of the recordings."),
    )
    alarms.caption(
        f"{number(point.false_alarms_per_frame, '.3g')} per frame; {point.n_false_alarms:,} in all"
    )
    if note := sampling_note(dataset.frame_columns):
        alarms.caption(note)
    if state.score_span(name) is not None:
        scores, alarms_left = _plots(letter, name, threshold)
        draw_chart(scores, f"scores_{letter}")
        draw_chart(alarms_left, f"alarms_{letter}")


def _draw_lowest(letter: str) -> None:
    """Why the field is empty, if what was just typed leaves no detection out."""
    typed_letter, threshold = st.session_state.get(LOWEST, ("", 0.0))
    if typed_letter == letter:
        del st.session_state[LOWEST]
        st.caption(
            f"No detection of {letter.upper()} has a score below {threshold:g}: every detection "
            "counts, which an empty field stands for."
        )


def _plots(letter: str, name: str, threshold: float | None) -> tuple[go.Figure, go.Figure]:
    """Scores of a system, and the false alarms that each threshold leaves."""
    dataset, matching, theme = state.opened().dataset, state.params().only_for(MATCH), state.theme()
    shown: dict[str, Any] = {"letter": letter, "name": name, "threshold": threshold, "theme": theme}
    return state.cached(  # they stay while the rest of the page changes
        "threshold_plots",
        (letter, name, threshold, matching, theme),
        lambda: (
            score_plot(score_histogram(dataset, name), **shown),
            false_alarm_plot(_false_alarm_curve(dataset, name, matching), **shown),
        ),
        most=8,
    )


def _take_threshold(letter: str) -> None:
    threshold: float | None = st.session_state[f"data_threshold_{letter}"]
    state.set_threshold(letter, threshold)
    name = state.systems()["xy".index(letter)]
    span = None if name is None else state.score_span(name)
    if threshold is not None and span is not None and threshold <= span[0]:
        st.session_state[LOWEST] = letter, threshold


def _draw_same_point(x: str, y: str) -> None:
    """The button that sets both systems alike, as the verdict does; the sidebar has the others."""
    letter = _which_moves(x, y)
    moved, fixed = (letter, "yx"["xy".index(letter)]) if letter is not None else ("y", "x")
    st.button(
        "Same operating point",
        disabled=letter is None,
        key="same_point",
        icon=":material/balance:",
        on_click=operating_point.move,
        args=(moved,),
        help=f"Sets the threshold of {moved.upper()} so that it has as many false alarms per frame "
        f"as {fixed.upper()} has now, as the verdict does. Without it a system that reports more "
        "of everything looks better.",
    )
    if letter is None:
        st.caption("Neither system has scores that differ: there is no threshold to move.")
    elif operating_point.why_fixed(fixed):
        st.caption(f"{fixed.upper()} has no scores that differ: only {moved.upper()} can be moved.")
    operating_point.draw_change("data")


def _which_moves(x: str, y: str) -> str | None:
    """Which of X and Y moves, as in the verdict; None: neither can."""
    dataset, params = state.opened().dataset, state.params()
    points = (
        _point(dataset, x, params, params.threshold_x),
        _point(dataset, y, params, params.threshold_y),
    )
    index = choose_moved(
        [not operating_point.why_fixed(letter) for letter in "xy"],
        [point.n_false_alarms for point in points],
        [point.n_kept for point in points],
    )
    return None if index is None else "xy"[index]


def _point(
    dataset: Dataset, system: str, params: Params, threshold: float | None
) -> OperatingPoint:
    return _operating_point(dataset, system, params.only_for(MATCH), threshold)


_cached_by_data = st.cache_resource(
    max_entries=MOST_KEPT,
    show_spinner="Counting false alarms",
    # the fingerprint replaces the tables, which Streamlit would compare by a sample of their rows
    hash_funcs={Dataset: lambda dataset: dataset.fingerprint},
)


@_cached_by_data
def _false_alarm_curve(dataset: Dataset, system: str, matching: Params) -> pd.DataFrame:
    return false_alarm_curve(dataset, system, matching)


@_cached_by_data
def _operating_point(
    dataset: Dataset, system: str, matching: Params, threshold: float | None
) -> OperatingPoint:
    return point_at(dataset, system, matching, threshold=threshold)
