"""Data page: which two systems are X and Y, and at which thresholds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

import pandas as pd
import plotly.graph_objects as go
import streamlit as st

from nvcore.common.wording import capitalised
from nvcore.comparison.measures.table import CLAIMABLE, choose_primary, inference_of
from nvcore.dataset import Dataset
from nvcore.evidence.claims import ALARM_MARGIN
from nvcore.evidence.measures import primary_of
from nvcore.figures.inputs import false_alarm_plot, score_plot
from nvcore.metrics.detection.operating_point import (
    false_alarm_curve,
    operating_point,
    score_histogram,
)
from nvcore.report.words import at_best, sampling_note
from nvcore.settings.defaults import DELIVERED
from nvcore.settings.params import Params
from nvcore.settings.stages import MATCH
from ui.session import state, store
from ui.widgets.charts import draw_chart
from ui.widgets.text import docs_link, number, plain

T = TypeVar("T")
EXACT_OPEN: Final = "exact_thresholds"
"""Key of the popover with the fields for exact thresholds."""
MOST_KEPT: Final = 32
"""Largest number of cached curves, and of cached points."""
PLOT_PX: Final = 250
"""Height of a plot including its heading."""


def draw() -> None:
    """Draw the choice of X and Y, the effect of their thresholds, and a column of plots each."""
    st.header("Compare")
    x, y = state.systems()
    if y is None:
        st.info(
            "There is one system only. Open a comparison with two systems to compare them.",
            icon=":material/info:",
        )
    else:
        _draw_choice(x, y)
    named = [(letter, name) for letter, name in zip("xy", (x, y), strict=True) if name is not None]
    _draw_exact(named)
    st.table(_points(named), width="stretch", hide_index=True)
    notes = (
        "Thresholds are set in the sidebar, also to equal false alarms. False alarms here are "
        "single detections that match {nobody}, counted in every frame. What a driver would notice "
        "is on the Overview: false-alert episodes, false alarms linked over frames ({link}).",
        sampling_note(state.opened().dataset.frame_columns),
    )
    link = docs_link("more", "false-alarms")
    st.caption(" ".join(state.say(note, link=link) for note in notes if note))
    for column, (letter, name) in zip(st.columns(2), named, strict=False):
        with column:
            _draw_plots(letter, name)


def _draw_choice(x: str, y: str) -> None:
    """Draw the choice of X, Y and the primary measure."""
    names = list(state.opened().dataset.systems)
    left, right, last = st.columns(3, vertical_alignment="bottom")
    # the widgets show the open comparison, however it was changed
    store.set_widgets(choice_x=x, choice_y=y)
    left.selectbox("System X", names, key="choice_x", on_change=_choose, args=("x",))
    right.selectbox("System Y", names, key="choice_y", on_change=_choose, args=("y",))
    primary = primary_of(state.opened().dataset)
    store.CHOICE.of("primary").set(primary.key)
    last.selectbox(
        "Decide by",
        list(CLAIMABLE.values()),
        key="choice_primary",
        format_func=lambda key: capitalised(state.say(inference_of(key).noun)),
        on_change=_choose_primary,
        help="The primary measure: the verdict tests it by itself, and claims other differences "
        "only if it shows one. Choose it before you look at the verdict; if it is changed "
        "afterwards, the verdict says so and corrects all measures for one another.",
    )
    store.set_widgets(choice_delivered=state.operating_point() == DELIVERED)
    st.checkbox(
        "Delivered products: the thresholds stay",
        key="choice_delivered",
        on_change=_choose_delivered,
        help="The verdict is about the systems as they are set. It claims that one is better only "
        f"if that one has at most {ALARM_MARGIN:g} times the other's false alarms, beyond chance. "
        "Without the check mark X and Y are compared at equal false alarms.",
    )
    for fact in at_best(state.opened().dataset):
        st.caption(state.say(fact))
    if primary.is_changed:
        st.caption(
            f":material/warning: Changed {primary.when}, after a verdict on these data: all "
            "measures are corrected for one another."
        )


def _choose_primary() -> None:
    """Use another primary measure, and note whether a verdict on the data was shown."""
    chosen = choose_primary(state.primary_so_far(), store.CHOICE.of("primary").get())
    state.compare_as(replace(state.opened().session, primary=chosen))


def _choose_delivered() -> None:
    """Ask about delivered products, or return to the earlier operating point."""
    if store.widget("choice_delivered").get():
        store.BEFORE_DELIVERED.set(state.operating_point())
        state.set_operating_point(DELIVERED)
    else:
        state.set_operating_point(store.BEFORE_DELIVERED.get())


def _choose(letter: str) -> None:
    """Use another system as X or Y. If it has the other letter, the two change places."""
    x, y = state.systems()
    chosen = store.CHOICE.of(letter).get()
    if letter == "x":
        state.compare_systems(chosen, x if chosen == y else y)
    else:
        state.compare_systems(y if chosen == x and y is not None else x, chosen)


def _draw_exact(named: Sequence[tuple[str, str]]) -> None:
    """Draw folded fields for thresholds between the steps of the sidebar's sliders."""
    scored = [letter for letter, name in named if state.score_span(name) is not None]
    place = st.popover(
        "Type exact thresholds", disabled=not scored, key=EXACT_OPEN, on_change="rerun"
    )
    if not place.open:  # a hidden field would send its old value after a change elsewhere
        return
    with place:
        for letter in scored:
            field = store.EXACT_THRESHOLD.of(letter)
            field.set(state.threshold_of(letter))
            st.number_input(
                f"Score threshold of {letter.upper()}",
                key=field.key,
                value=None,
                step=0.01,
                format="%.4g",
                placeholder="every detection counts",
                on_change=_take_threshold,
                args=(letter,),
                help="Detections with a lower score are left out. Empty: every detection counts.",
            )
            _draw_lowest(letter)


def _draw_lowest(letter: str) -> None:
    """Say that the threshold just typed leaves no detection out."""
    typed_letter, threshold = store.LOWEST_THRESHOLD.get()
    if typed_letter == letter:
        store.LOWEST_THRESHOLD.pop()
        st.caption(
            f"No detection of {letter.upper()} has a score below {threshold:g}: every detection "
            "counts, which an empty field stands for."
        )


def _points(named: Sequence[tuple[str, str]]) -> pd.DataFrame:
    """Tabulate detections and false alarms of X and Y at their thresholds. Names are Markdown."""
    dataset, params = state.opened().dataset, state.params()
    rows = []
    for letter, name in named:
        threshold = state.threshold_of(letter)
        point = _counted(operating_point, dataset, name, params, threshold=threshold)
        all_count = "every detection counts"
        if state.score_span(name) is None:
            all_count = "no scores that differ: every detection counts"
        rows.append(
            {
                "System": f"**{letter.upper()}**: {plain(name)}",
                "Score threshold": all_count if threshold is None else f"{threshold:.4g}",
                "Detections kept": f"{point.n_kept:,} of {len(dataset.system(name)):,}",
                "False alarms": f"{point.n_false_alarms:,}",
                "per frame": number(point.false_alarms_per_frame, ".3g"),
                "per minute": number(point.false_alarms_per_minute, ".1f"),
            }
        )
    return pd.DataFrame(rows)


def _draw_plots(letter: str, name: str) -> None:
    if state.score_span(name) is None:
        return
    plots = _plots(letter, name, state.threshold_of(letter))
    for figure, kind in zip(plots, ("scores", "alarms"), strict=True):
        draw_chart(figure, f"{kind}_{letter}")


def _plots(letter: str, name: str, threshold: float | None) -> tuple[go.Figure, go.Figure]:
    """Plot the scores of a system, and its false alarms by threshold."""
    dataset, params, theme = state.opened().dataset, state.params(), state.theme()
    shown: dict[str, Any] = {"letter": letter, "name": name, "threshold": threshold, "theme": theme}
    return state.cached(  # reused while the rest of the page changes
        "threshold_plots",
        (letter, name, threshold, params.only_for(MATCH), theme),
        lambda: (
            score_plot(score_histogram(dataset, name), **shown).update_layout(height=PLOT_PX),
            false_alarm_plot(
                _counted(false_alarm_curve, dataset, name, params), **shown
            ).update_layout(height=PLOT_PX),
        ),
        most=8,
    )


def _take_threshold(letter: str) -> None:
    threshold = store.EXACT_THRESHOLD.of(letter).get()
    state.set_threshold(letter, threshold)
    span = state.span_of(letter)
    if threshold is not None and span is not None and threshold <= span[0]:
        store.LOWEST_THRESHOLD.set((letter, threshold))


def _counted(
    count: Callable[..., T], dataset: Dataset, system: str, params: Params, **more: Any
) -> T:
    """Return the result of `count` for a system's false alarms, cached."""
    matching = params.only_for(MATCH)

    @st.spinner("Counting false alarms")
    def make() -> T:
        return count(dataset, system, matching, **more)

    key = (system, matching, *more.values())
    return state.cached(count.__name__, key, make, most=MOST_KEPT)
