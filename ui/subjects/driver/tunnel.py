"""Driver page: simulation of a change of light at some time of the recording."""

from __future__ import annotations

from functools import partial
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.comparison.compare import Result
from nvcore.figures.over_time import end_of
from nvcore.subjects.driver.comparison.notes import simulated_change
from nvcore.subjects.driver.running.estimate import simulate_change
from ui.session import state, store
from ui.shell.messages import shown_error
from ui.subjects.driver.confined import on_estimator
from ui.subjects.driver.known import OpenedRun, caution_of, clock_of, opened_run

MOST_KEPT: Final = 64


class Change(NamedTuple):
    """Time of a simulated change of light, and resulting estimates for each row of the course."""

    time_s: float
    estimates: pd.DataFrame


def draw(
    result: Result, course: pd.DataFrame, features: pd.DataFrame | None, *, is_estimated: bool
) -> Change | None:
    """Draw the controls, and return the simulated change of light, or None if it is switched off.

    Parameters
    ----------
    features
        Rows as in the course. None: unknown.
    is_estimated
        Whether the estimator gave the detectability that the simulation is compared with.
    """
    known = opened_run()
    missing = _missing(known, features, is_estimated=is_estimated)
    left, right = st.columns([1, 2], vertical_alignment="center")
    is_on = left.toggle(
        "A tunnel ends here",
        key=store.TUNNEL.key,
        disabled=bool(missing),
        on_change=_begin_here,
        help="Simulates that it becomes dark at the frame that is shown, as where a lit tunnel "
        "ends. The pictures stay what they are: only the time that the eyes have had to adapt is "
        "another. Nothing of the session changes.",
    )
    if missing:
        right.caption(missing)
        return None
    assert known is not None
    assert features is not None
    if not is_on:
        right.caption("Simulates a change from bright to dark at the frame that is shown.")
        return None
    fps = float(result.dataset.frame_columns.fps[state.recording()])
    with right:
        change_s = st.slider(
            "Dark from (s)",
            0.0,
            end_of(result, state.recording()),
            step=1 / fps,
            format="%.2f",
            key=store.TUNNEL_S.key,
        )
    try:
        estimates = _estimates(known, course, features, fps, change_s)
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")
        return None
    note = simulated_change(
        course,
        estimates,
        threshold=result.params.driver_threshold,
        change_s=change_s,
        caution=caution_of(result),
    )
    st.info(state.say(note), icon=":material/dark_mode:")
    return Change(change_s, estimates)


def _begin_here() -> None:
    """Start the change of light at the shown frame. Moving the slider overrides this."""
    time_s = state.opened().dataset.frames["time_s"].to_numpy()[state.row_in_all()]
    store.TUNNEL_S.set(float(time_s))


def _missing(known: OpenedRun | None, features: pd.DataFrame | None, *, is_estimated: bool) -> str:
    """Return why no change of light can be simulated, or "" if it can."""
    if known is None:
        return (
            "To simulate a change of light, features and an estimator are needed, and the session "
            "has estimates alone: press *Estimate* above."
        )
    if features is None:
        return (
            "Features of this recording are not known: it was not among those that were estimated, "
            "and needs pictures of visible light."
        )
    if not is_estimated:
        return (
            "A simulated change of light is compared with what the estimator says without it, and "
            "that is not known here: what is shown is the ground truth's."
        )
    return ""


def _estimates(
    known: OpenedRun, course: pd.DataFrame, features: pd.DataFrame, fps: float, change_s: float
) -> pd.DataFrame:
    """Simulate the change of light with the run's estimator, in its sandboxed process. Cached."""
    space = state.workspace()
    end_s = course["time_s"].to_numpy(np.float64) + 1 / fps
    clock = clock_of(state.recording())
    real_s = None if clock is None else clock.change_s

    simulated = partial(simulate_change, features, end_s, change_s, real_s=real_s)
    simulated = partial(simulated, interpolate=known.run.is_interpolated)
    what, call = "simulating a change of light", space.model_process.call
    ask = partial(call, on_estimator, known.spec, simulated, what=what)
    key = known.named, int(course["truth_row"].iloc[0]), change_s
    estimates: pd.DataFrame = space.cached("driver_tunnel", key, ask, most=MOST_KEPT)
    return estimates
