"""Driver page: the selected pedestrian in the picture and over time, with the light level."""

from __future__ import annotations

from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.figures.style import plain as figure_text
from nvcore.subjects.driver.comparison.encounters import detectability_course, features_of_course
from nvcore.subjects.driver.comparison.figures import detectability_course_plot
from nvcore.subjects.driver.illumination.clock import AdaptationClock, adaptation_clock, with_change
from ui.session import state, store
from ui.session.chosen import chosen_encounter, name_of
from ui.subjects.driver import basis, panel, tunnel
from ui.subjects.driver.known import (
    caution_of,
    clock_of,
    features_of,
    is_estimated,
    may_be_another_clock,
    opened_run,
    part_of,
)
from ui.widgets import compared_viewer
from ui.widgets.charts import clicked_chart
from ui.widgets.drawing import Look, VisiblePictures, look, visible_of
from ui.widgets.text import docs_link, plain

KEY: Final = "driver_viewer"
HEIGHT_PX: Final = 520
PANEL_PX: Final = 655
OTHER_CLOCK: Final = (
    "Light and adaptation are by our default settings: no record says with which ones the "
    "estimates were made, so they may rest on others."
)
BAND: Final = (
    " The band is the estimator's error (root mean square) on pedestrians that it was not trained "
    "on, one number for each adaptation period. Estimates and band are cut to 0 to 1."
)
NOT_KNOWN: Final = "In no frame is it known how detectable this {one} is"


def draw(result: Result, encounter: int) -> None:
    """Draw the selected pedestrian, at first in the frame by which the driver must see them."""
    course = detectability_course(result, encounter)
    name = state.workspace().n_opened, name_of(result, encounter)
    is_new = store.DRIVER_SHOWN.get()[0] != name
    store.DRIVER_SHOWN.set((name, chosen_encounter(result)))
    recording = int(result.encounters.recording[encounter])
    if is_new:
        store.TUNNEL.set(False)
    is_there = state.recording() == recording and not (
        is_new and state.row_in_all() not in course["row"].to_numpy()
    )
    if not is_there:
        state.go_to(*state.place_of(first_shown(course)))
    recording_name, _, track = name[1].rpartition(":")
    st.header(f"{state.say('{One}')} {track} of {plain(recording_name)}")
    _draw_moving(result, encounter, course)


def first_shown(course: pd.DataFrame) -> int:
    """Return the frame row to show first: the first relevant one, or else the first of all."""
    before = course["row"][course["is_up_to_relevant"]]
    return int(before.iloc[-1] if len(before) else course["row"].iloc[0])


@st.fragment
def _draw_moving(result: Result, encounter: int, course: pd.DataFrame) -> None:
    """Draw the parts of the page that follow the current frame. A click in one moves all."""
    # another one was selected in the picture
    if chosen_encounter(result) != store.DRIVER_SHOWN.get()[1]:
        st.rerun()
    settled = compared_viewer.settled(KEY)
    if settled != state.row():
        state.settle(state.recording(), settled)
    recording = state.recording()
    known, run = features_of(recording), opened_run()
    features = None if known is None else features_of_course(result, course, known)
    left, right = st.columns([5, 2], gap="medium")
    below = st.container()
    is_known = bool(course["detectability"].notna().any())
    is_by_estimator = is_estimated(result, recording)
    change = None
    if is_known:
        with below:
            change = tunnel.draw(result, course, features, is_estimated=is_by_estimator)
    clock = _clock(result, recording, change)
    with left:
        compared_viewer.draw(
            result,
            KEY,
            height_px=HEIGHT_PX,
            seen=_look(),
            visible=_visible(recording, clock),
            encounter=encounter,
        )
    with right, st.container(height=PANEL_PX, border=False):
        panel.draw(
            course,
            features,
            clock,
            None if change is None else change.estimates,
            caution=caution_of(result),
            run=None if features is None or run is None else run.run,
            is_estimated=is_by_estimator,
            has_run=run is not None,
        )
    with below:
        if is_known:
            _draw_plot(result, encounter, course, clock, change)
        else:
            why = basis.why_unknown(part_of(recording), features, has_run=run is not None)
            st.info(f"{state.say(NOT_KNOWN)}: {why}", icon=":material/visibility_off:")


def _look() -> Look:
    """Return the selected look of the viewer, with visible light instead of the default picture."""
    chosen = look()
    return chosen._replace(picture="visible") if chosen.picture == "own" else chosen


def _clock(result: Result, recording: int, change: tunnel.Change | None) -> AdaptationClock | None:
    clock = clock_of(recording)
    if change is None:
        return clock
    frames = result.dataset.frame_columns
    fps = float(frames.fps[recording])
    if clock is None:
        clock = adaptation_clock(None, frames.frame[frames.rows_of(recording)], fps)
    return with_change(clock, fps, change.time_s)


def _visible(recording: int, clock: AdaptationClock | None) -> VisiblePictures | None:
    """Return the recording's visible pictures with the light that this page knows or simulates."""
    visible = visible_of(recording)
    if visible is None:
        return None
    visible = visible._replace(can_simulate=False)
    if clock is None:
        return visible
    return visible._replace(seen_s=clock.seen_s, is_simulated=clock.is_simulated)


def _draw_plot(
    result: Result,
    encounter: int,
    course: pd.DataFrame,
    clock: AdaptationClock | None,
    change: tunnel.Change | None,
) -> None:
    figure = detectability_course_plot(
        course,
        threshold=result.params.driver_threshold,
        theme=state.theme(),
        clock=clock,
        caution=caution_of(result),
        simulated=None if change is None else change.estimates,
        objects=result.objects,
    )
    name = state.recording_names()[state.recording()]
    if may_be_another_clock(state.recording()):
        st.caption(OTHER_CLOCK)
    adapting = docs_link("Adapting", "illumination", doc="driver-reference")
    row = clicked_chart(
        figure,
        f"driver_course_{encounter}",
        time_axis="x",
        of=f"{result.objects.singular} {result.encounters.track[encounter]} of {figure_text(name)}",
        help=f"Click a mark to see its frame. {adapting}: seconds from the last change from bright "
        "to dark to the end of the frame; none where the eyes count as adapted, or it is not known."
        f"{BAND if is_estimated(result, state.recording()) else ''}",
    )
    if row is not None:
        state.go_to(*state.place_of(int(row)))
        st.rerun(scope="fragment")
