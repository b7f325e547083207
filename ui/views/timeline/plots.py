"""Timeline page: viewer, plot over time and lanes that move together."""

from __future__ import annotations

from functools import partial
from itertools import chain
from typing import Any, Final, Literal, NoReturn

import numpy as np
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.figures.lanes import lane_order, lanes_figure
from nvcore.figures.over_time import TimeLayout, loss_plot, similarity_plot
from nvcore.settings.stages import shown_results
from ui.session import state, store
from ui.session.chosen import choose_encounter, chosen_encounter
from ui.session.results import comparison_key
from ui.shell import title
from ui.streamlit_inside.types import DeltaGenerator
from ui.subject import subject_pages
from ui.views.timeline import codes, listed, panel
from ui.widgets import compared_viewer
from ui.widgets.charts import clicked_chart, kept_figure
from ui.widgets.choices import choose_first, choose_side_by_side
from ui.widgets.text import docs_link

VIEWER: Final = "viewer"
VIEWER_PX: Final = 700
PANEL_PX: Final = 640
"""Height of the panel beside the picture. Longer content scrolls by itself."""
LANES: Final = 20
"""Maximum number of lanes at a time, which fill a screen."""
PLOTS: Final[dict[TimeLayout | Literal["losses"], str]] = {
    "time": "Similarity",
    "losses": "Lost to misses and false alarms",
    "upright": "Upright, mirrored",
    "side_by_side": "Upright, side by side",
}
"""Choices for the plot over time. The vertical ones are figure 8 of the paper."""
SIMILARITY_TEXT: Final = (
    "Thin: similarity of each frame, 1 is best. Thick: moving mean. Filled: low intervals. "
    "Marks above or between: saliency events."
)
LOSSES_TEXT: Final = (
    "What each frame loses of its similarity of 1. Filled: to misses, alpha × D(G, S). Hatched, on "
    "top: to false alarms, (1 − alpha) × D(S, G), both as shares of half the picture's width."
)


@st.fragment
def draw_all(result: Result, recording: int) -> None:
    """Draw all parts of the page that follow the current frame. A click in one moves all.

    The rest of the page is drawn for this recording.
    """
    if state.recording() != recording:  # an entry of a list is in another recording
        st.rerun()
    settled = compared_viewer.settled(VIEWER)
    if settled != state.row():
        state.settle(state.recording(), settled)
    title.follow_frame()
    listed.draw()
    left, right = st.columns([5, 2], gap="medium")
    with st.container():  # first, because people who drag a slider wait for the plot
        _draw_plot(result)
    with left:
        box = listed.box_in(state.recording())
        compared_viewer.draw(result, VIEWER, height_px=VIEWER_PX, fits_window=True, listed=box)
    with right, st.container(height=PANEL_PX, border=False, key="frame_panel"):
        panel.draw(result, state.row_in_all())
    _draw_lanes(result)
    _draw_added(result)
    codes.draw(state.recording())


def _draw_lanes(result: Result) -> None:
    """Draw lanes of encounters, only so many at a time that their axis stays visible."""
    recording, space = state.recording(), state.workspace()
    left, right = st.columns([2, 3], vertical_alignment="bottom")
    only_missed = left.toggle(
        state.say("Only {many} with misses"), key="lanes_missed", persist_state="session"
    )
    key = (space.version, recording, only_missed, result.params.only_for(*shown_results()))
    order = space.cached(
        "lane_order", key, lambda: lane_order(result, recording, only_missed=only_missed)
    )
    chosen = chosen_encounter(result)
    first = _first_lane(right, order, chosen)
    lanes = kept_figure(  # cached while alpha and similar settings move
        "lanes",
        (*key, first, LANES, chosen, state.theme(), result.dataset.settings.codes),
        lambda: lanes_figure(
            result,
            recording,
            theme=state.theme(),
            first=first,
            most=LANES,
            only_missed=only_missed,
            chosen=chosen,
        ),
    )
    clicked = _clicked(lanes, "lanes", "x")
    if clicked is not None:
        row, encounter = clicked
        choose_encounter(result, encounter)
        _go_to(row)


def _draw_added(result: Result) -> None:
    """Draw figures over time that subjects add."""
    recording, theme = state.recording(), state.theme()
    for plot in chain(*(subject.timeline_plots for subject in subject_pages())):
        if not plot.applies(result):
            continue
        figure = kept_figure(
            plot.key,
            (comparison_key(result), recording, theme),
            partial(plot.make, result, recording, theme),
        )
        clicked = _clicked(figure, plot.key, "x")
        if clicked is not None:
            row, encounter = clicked
            if encounter >= 0:
                choose_encounter(result, encounter)
            _go_to(row)


def _first_lane(place: DeltaGenerator, order: np.ndarray, chosen: int | None) -> int:
    """Return the first lane to show. A newly selected encounter's lane is brought into view."""
    if len(order) > LANES:
        if chosen != store.LANE_SEEN.get() and chosen in order:
            lane = int(np.flatnonzero(order == chosen)[0])
            store.FIRST_LANE.set(lane - lane % LANES)
        store.LANE_SEEN.set(chosen)
    with place:
        return choose_first(
            state.say("{Many}, most severe first"), len(order), LANES, store.FIRST_LANE.key
        )


def _draw_plot(result: Result) -> None:
    recording = state.recording()
    kind = choose_side_by_side("Plot over time", PLOTS, "plot_over_time", default="time")
    figure = kept_figure(
        "plot_over_time",
        (result.params, state.systems(), state.theme(), kind, recording),
        lambda: (
            loss_plot(result, recording, theme=state.theme())
            if kind == "losses"
            else similarity_plot(result, recording, theme=state.theme(), layout=kind)
        ),
    )
    upright = kind in ("upright", "side_by_side")
    words = LOSSES_TEXT if kind == "losses" else SIMILARITY_TEXT
    clicked = _clicked(
        figure,
        "time_plot",
        "y" if upright else "x",
        f"{words} Click to see the frame ({docs_link('Metrics', 'similarity')}).",
    )
    if clicked is not None:
        _go_to(int(clicked))


def _clicked(
    figure: Any, key: str, time_axis: Literal["x", "y"], help_text: str | None = None
) -> Any:
    name = f"{key}_{state.recording()}"
    return clicked_chart(figure, name, time_axis=time_axis, help=help_text)


def _go_to(row: int) -> NoReturn:
    state.go_to(*state.place_of(row))
    st.rerun(scope="fragment")
